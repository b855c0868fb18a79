"""Along a run: where events happen, as its steps come in, and which of them ends it."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arguments import Array, Booleans
from ..errors import EventError, StepError
from ..kernels.compiling.call import Call
from ..kernels.compiling.signatures import VALUE
from ..kernels.numbers.blocks import Block, filled_block, part, scalar_block
from ..kernels.solve.events import EVENTS, MOST_IN_STEP, NODES, NOTE, SCRATCH
from ..kernels.solve.status import CHATTER, EVENT_NOT_FINITE, EVENT_UNCLEAR, NOT_CONVERGED, OK
from ..methods.partial import Nodes, driven, inside_of, own_blocks
from ..methods.stepper import Advance, Stepper
from ..problems.bound import bound
from .events import Event, component_at, looked_at
from .met import Met
from .restart import Restart

ROOM = 1 << 18  # numbers of events a call
SEEN = 1e-9  # of a step: nearer to the end of a run one event may be what was told last
_NOTHING = scalar_block(0)
_FAILED = {
    EVENT_NOT_FINITE: "is not a finite number",
    EVENT_UNCLEAR: "changes too fast to tell how often it is 0: it may jump; a smaller step may do",
    CHATTER: f"is 0 more than {MOST_IN_STEP - 2} times in one step: a smaller step may tell them apart",
}


class Stop(NamedTuple):
    """What ends a run: after which node of the chunk, when, the state with the clock; or an error."""

    name: str
    node: int
    time: float
    state: Array | None
    error: StepError | None = None


class _Look(NamedTuple):
    """What was found of one event in a chunk: a row each; after which node it went wrong, and what."""

    found: Array
    node: int
    error: StepError | None
    signs: Array  # as they were before


class Crossings:
    """Events along one run.

    Parameters
    ----------
    before : Restart, optional
        Of the run that this one goes on from, with what it has told.
    """

    def __init__(
        self,
        stepper: Stepper,
        events: Mapping[str, Event],
        before: Restart | None = None,
    ) -> None:
        self._problem, self._events = stepper.flow.problem, dict(events)
        self._stepper = stepper.fixed_step
        self._after = None if before is None else before.seen
        self._told = {} if before is None else before.told
        self._found: dict[str, list[Array]] = {name: [] for name in events}
        self._count = dict.fromkeys(events, 0)
        self._calls: dict[str, Call] = {}
        self._tail: Nodes | None = None
        if before is not None and len(before.times):
            self._tail = Nodes(before.times, before.states, np.zeros(len(before.times), np.int64))
        self._begun = False
        self._memories = _NOTHING  # of the steps that are looked at now, the first ones
        self._past = _NOTHING  # of the step before them
        if before is not None and before.done and self.use_memories:
            self._past = filled_block(before.memory)
        self._late: dict[str, list[Array]] = {}
        self._sign = np.sign(self._stepper.h)  # of the direction of the run

    def go_on(self) -> None:
        """Know that the run begins anew at a break: what was before it tells nothing of the rest."""
        self._tail, self._past = None, _NOTHING

    @property
    def use_memories(self) -> bool:
        """Whether what the method remembers of each step is of use."""
        return self._stepper.flow.between is not None

    @property
    def entries(self) -> int:
        """How many functions `prepare` asks for."""
        return len(self._events) * (2 + self._stepper.flow.entries)

    def prepare(self) -> None:
        """Compile, or find in the cache, what looks for events."""
        if not self._calls:
            self._make({name: scalar_block(3) for name in self._events})

    def _make(self, signs: Mapping[str, Block]) -> None:
        """Make the calls, with the signs that events have had last."""
        flow, problem = self._stepper.flow, self._problem
        self._flow = flow
        room = max(MOST_IN_STEP + 1, min(64 * MOST_IN_STEP, ROOM // (flow.rows + 2)))
        for name, event in self._events.items():
            row = event.row(problem)
            function = looked_at(event, problem) if row < 0 else component_at(0)  # never called
            self._calls[name] = EVENTS.call(
                flow.compiled,
                **{**driven(flow), **own_blocks(flow), **inside_of(flow)},
                event=bound(problem, function, VALUE),
                component=row,
                level=event.level,
                y=scalar_block(problem.rows),
                free=scalar_block(problem.work),
                direction=event.sign,
                signs=signs[name],
                scratch=scalar_block(SCRATCH),
                note=scalar_block(NOTE),
                room=room,
                out=scalar_block(room * (flow.rows + 2)),
            )

    def take(self, nodes: Nodes, memories: Array | None = None) -> Stop | None:
        """Look between the nodes, the first of which was the last before; return what ends the run.

        `memories`: what is remembered of the steps, one a row, where that is of use.
        """
        if len(nodes.times) < 2:
            return None
        before = self._tail
        first = 0 if before is None else len(before.times)
        known = nodes if before is None else before.with_more(nodes)
        if not self._begun:
            self._look_back(known, first)
        if memories is not None:
            self._memories = Block(memories[: len(nodes.times) - 1].reshape(-1))
        seen, begin = (nodes, 0) if self.use_memories else (known, first)
        looks = {name: self._look(name, seen, begin) for name in self._events}
        self._look_again(looks, nodes, seen, begin)
        errors = [
            Stop(name, look.node - begin, float(seen.times[look.node]), None, look.error)
            for name, look in looks.items()
            if look.error is not None
        ]
        if memories is not None:
            self._past, self._memories = filled_block(memories[len(nodes.times) - 2]), _NOTHING
        stop = self._earliest([*self._ends(looks, nodes), *errors])
        for name, look in looks.items():
            self._found[name].append(look.found)
            self._count[name] += len(look.found)
        self._late.clear()
        if stop is not None:
            known = known.up_to(first + stop.node)
            self._cut(self._sign * stop.time)
        self._tail = known.before_last(NODES - 1, 1 - int(stop is None))
        return stop

    def _look_again(self, looks: dict[str, _Look], nodes: Nodes, known: Nodes, first: int) -> None:
        """Look once more where something went wrong in the step of the end: it may lie beyond it."""
        tried = set()
        while (stop := self._earliest(self._ends(looks, nodes))) is not None:
            at = first + stop.node
            wrong = [name for name, look in looks.items() if look.error and look.node == at]
            doubtful = [name for name in wrong if (name, stop.time) not in tried]
            if not doubtful:
                return
            shorter = known.up_to(at)
            if len(self._memories):
                self._memories = part(self._memories, 0, at * len(self._stepper.memory))
            if stop.time != known.times[at]:
                assert stop.state is not None
                end = Nodes(np.array([stop.time]), stop.state[None, :], known.steps[at : at + 1])
                shorter = shorter.with_more(end)
            for name in doubtful:
                tried.add((name, stop.time))
                self._calls[name].given("signs").data[:] = looks[name].signs
                looks[name] = self._look(name, shorter, first)

    def _ends(self, looks: Mapping[str, _Look], nodes: Nodes) -> list[Stop]:
        """Return for each event that is to end the run here where it does."""
        ends = (self._end(name, look.found, nodes) for name, look in looks.items())
        return [end for end in ends if end is not None]

    def _earliest(self, stops: list[Stop]) -> Stop | None:
        """Return what comes first; an event before what goes wrong there."""
        return min(stops, key=lambda s: (self._sign * s.time, s.error is not None), default=None)

    def _look_back(self, known: Nodes, first: int) -> None:
        """Learn what the signs of events were before the first node, where a run goes on."""
        self._begun = True
        for name in self._events if first else ():
            look = self._look(name, known.up_to(first), 0)
            self._late[name] = [look.found]  # what rounding has hidden from the run before
            if look.error is not None:
                self._calls[name].given("signs").data[:] = 0.0

    def _look(self, name: str, known: Nodes, first: int) -> _Look:
        """Return the events of one name, a row each: time, direction, state; what went wrong where."""
        call, parts, begin = self._calls[name], [], first
        rows = self._stepper.rows + 2
        signs, late = call.given("signs").data.copy(), self._late.get(name, [])
        call.set(states=Block(known.states.reshape(-1)), times=Block(known.times))
        call.set(memories=self._memories, before=self._past)
        while True:
            status, node, count, residual = call(first=first)
            parts.append(call.given("out").data[: count * rows].reshape(count, rows).copy())
            if status != OK or node >= len(known.times) - 1:
                break
            first = node
        if status == NOT_CONVERGED and self._stepper.turn(self._flow):
            call.given("signs").data[:] = signs
            self._make({name: other.given("signs") for name, other in self._calls.items()})
            return self._look(name, known, begin)
        found = np.concatenate(parts)
        if self._after is not None and len(found):
            found = found[~self._has_been_told(name, found)]
        found = np.concatenate([*late, found])
        return _Look(found, node, self._error(name, status, node, residual, known), signs)

    def _has_been_told(self, name: str, found: Array) -> Booleans:
        """Tell which events the run before has told; near its end those, to rounding, that it names."""
        assert self._after is not None
        times = found[:, 0]
        near = max(SEEN * abs(self._stepper.h), 4.0 * np.spacing(abs(self._after)))
        ahead = self._sign * (times - self._after)
        every = [x for of in self._told.values() for x in of]  # where it has another name now
        again = np.zeros(len(found), dtype=bool)
        for time, direction in self._told.get(name, every):
            again |= (np.abs(times - time) <= near) & (found[:, 1] == direction)
        return (ahead < -near) | (again & (ahead <= near))

    def left_behind(self, restart: Restart, end: float, here: float) -> Restart:
        """Return what a run that goes on needs: up to where events have been told, and which last.

        `end` is where the run has ended, `here` where the other one goes on from, in the problem's
        own time.
        """
        near = max(SEEN * abs(self._stepper.h), 4.0 * np.spacing(abs(end)))
        told = {}
        for name, parts in self._found.items():
            before = np.array(self._told.get(name, [])).reshape(-1, 2)
            known = np.concatenate((before, self._joined(parts)[:, :2]))
            told[name] = known[np.abs(known[:, 0] - end) <= near].tolist()
        restart = replace(restart, seen=end, told=told)
        tail = self._tail
        if tail is None or not (known := self._sign * (tail.times - here) < -near).any():
            return restart
        return replace(restart, times=tail.times[known], states=tail.states[known])

    def _error(
        self, name: str, status: int, node: int, residual: float, known: Nodes
    ) -> StepError | None:
        if status == OK:
            return None
        note = self._calls[name].given("note")
        span = known.times[node + 1] - known.times[node]
        t = float(known.times[node] + note[3] * span)
        step = int(known.steps[node])
        if status in _FAILED:
            return EventError(name, t, step, float(residual), _FAILED[status])
        failed = self._stepper.like(known.states[node], known.times[node], note[3] * span)
        return failed.error(Advance(status, 0, int(note[1]), residual), 0, step)

    def _end(self, name: str, found: Array, nodes: Nodes) -> Stop | None:
        """Return the event of one name that ends the run, if it is among those found."""
        left = self._events[name].last - self._count[name]
        if not 0 < left <= len(found):
            return None
        row, sign = found[left - 1], self._sign
        node = int(np.searchsorted(sign * nodes.times, sign * row[0], side="right")) - 1
        return Stop(name, max(node, 0), float(row[0]), row[2:])

    def _cut(self, end: float) -> None:
        """Drop what lies beyond the end."""
        for name, parts in self._found.items():
            known = self._joined(parts)
            self._found[name] = [known[self._sign * known[:, 0] <= end]]

    def _joined(self, parts: list[Array]) -> Array:
        return np.concatenate([np.zeros((0, self._stepper.rows + 2)), *parts])

    def met(self, clock: bool, end: float) -> dict[str, Met]:
        """Return all events up to the end of the run, by name."""
        self._cut(self._sign * end)
        n = self._problem.rows
        result = {}
        for name, parts in self._found.items():
            (found,) = parts
            tau, states = found[:, 0].copy(), found[:, 2:]
            t = states[:, -1].copy() if clock else tau if self._problem.time == "t" else None
            result[name] = Met(tau, t, states[:, :n].copy(), found[:, 1].copy())
        return result
