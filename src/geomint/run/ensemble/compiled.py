"""Members whose steps are of given lengths, in compiled code: in lanes where a step allows it."""

import math

import numpy as np

from ...arguments import Array, Integers
from ...errors import DeclarationError, GeomintError
from ...kernels.compiling.call import Call, Code
from ...kernels.compiling.number_types import SCALAR, NumberType, members
from ...kernels.numbers.blocks import Block, scalar_block
from ...kernels.numbers.lanes import LANES
from ...kernels.solve.members import ENDED, OPEN, members_sweep
from ...methods.flow import Flow
from ...methods.stepper import Stepper
from ...problems.problem import Problem
from ..asked import wants_clock
from ..integrator import Integrator
from ..timeline import Timeline, plan_timeline
from ..watched_steps import WatchedSteps, fastest_of
from .given import Asked, Members
from .outcome import NOT_RUN, Outcome, check_room

# Functions of a problem that are the same for members that share compiled code.
_CODE = ("field", "action", "hamiltonian", "splitting", "clock", "work", "pieces", "time")
PART, PART_IN_LANES, MEMBERS = 30, 300, 16  # of all steps and of all members, that are looked at
_alone: set[tuple[str, ...]] = set()  # what does not compile for lanes


def run_compiled(asked: Asked, given: Members, stop: Array) -> Outcome | None:
    """Return what has become of members; `NOT_RUN` where a step failed or `stop` ended it.

    None where their steps cannot be taken so: ends in another time than the problem's own, functions
    that differ by more than parameters, default steps that err by more than is promised.
    """
    first, shared = given.problem(0), asked.shared
    if not all(_same_code(first, problem) for problem in given.problems):
        return None
    try:
        lines = _timelines(asked, given)
    except GeomintError:  # of a member, which its own run will tell
        return None
    if lines[0].physical_end is not None:
        return None
    wanted = wants_clock(first, lines[0], None, shared["clock"])
    clock = first.clock is not None if wanted is None else wanted
    if shared["save_every"]:  # by as many states as the ensemble has, before anything is computed
        most = max(line.steps or 0 for line in lines) // shared["save_every"]
        all_kept = asked.keep_states and not asked.streamed
        check_room(asked.members if all_kept else len(given), most, first.rows)
    made = _prepared(asked, given, lines[0], clock)
    sweep = _Sweep(
        made.stepper, given, lines, shared["t0"] if clock else None, shared["save_every"]
    )
    sweep.run(stop)
    found = sweep.outcome(first, clock)
    if shared["step"] is None and stop[0] == 0.0 and _err(made, given, lines, found):
        return None
    return found


def _err(made: Integrator, given: Members, lines: list[Timeline], found: Outcome) -> bool:
    """Tell whether default steps err by more than is promised, in a sample of the members.

    Looked at are the first steps of one, that with the longest, and a step back from the end where
    the motion is fastest, of some of the ends.
    """
    longest = max(range(len(lines)), key=lambda k: abs(lines[k].h))
    own, total = lines[longest].steps, sum(line.steps or 0 for line in lines)
    part = PART_IN_LANES if made.stepper.flow.lane_by_lane else PART
    watched = _watched(made, given, longest, lines[longest], 1.0)
    if watched.through(WatchedSteps.enough(made.method, own, part, total)):
        return True
    ended = [k for k in range(0, len(lines), MEMBERS) if found.status[k] == "success"]
    if len(given.problems) > 1 or len(ended) < 2:
        return False
    ends = [(found.final[k], lines[k].own_end or 0.0) for k in ended]
    fastest = fastest_of(made, ends)
    return fastest is not None and WatchedSteps(made).at(*fastest) is not None


def _same_code(one: Problem, other: Problem) -> bool:
    """Tell whether two problems differ in their parameters alone, for a stepper."""
    if one is other:
        return True
    same = all(getattr(one, name) == getattr(other, name) for name in _CODE)
    return same and len(one.params) == len(other.params)


def _timelines(asked: Asked, given: Members) -> list[Timeline]:
    """Return the timeline of each member, or one for all."""
    count, ends = 1 if asked.shared["step"] is not None else len(given), asked.ends
    return [
        plan_timeline(given.problem(k), asked.method, given.states[k], **ends, compiled=True)
        for k in range(count)
    ]


def _watched(made: Integrator, given: Members, k: int, line: Timeline, sign: float) -> WatchedSteps:
    """Return what watches the steps of a member, by what is prepared for another one."""
    if len(given.problems) > 1:
        made.params = given.problem(k).params
    made._anew(given.states[k], line.start, sign * line.h)
    return WatchedSteps(made)


def _prepared(asked: Asked, given: Members, line: Timeline, clock: bool) -> Integrator:
    """Return the integrator of the first member, compiled and checked as that of a single run.

    Others are looked at where the first step of that one fails, which shows nothing.
    """
    states = given.states
    flow = asked.method.on(given.problem(0), states[0], line.start, clock)
    for state in states[:MEMBERS]:
        if not flow.proven:
            flow.begin(state, line.start, line.h).prepare()
    return Integrator.of(flow.begin(states[0], line.start, line.h, line.own_end))


class _Sweep:
    """All arguments of the loop over members, in the order of their steps."""

    def __init__(
        self,
        stepper: Stepper,
        given: Members,
        lines: list[Timeline],
        clock_begins: float | None,
        save_every: int | None,
    ) -> None:
        count, rows = len(given), stepper.rows
        self._rows, self._save_every = rows, save_every
        lines = lines if len(lines) == count else lines * count
        steps = np.array([line.steps or 0 for line in lines])
        self._order = np.argsort(-steps, kind="stable")
        steps = steps[self._order]
        ordered = [lines[k] for k in self._order]
        lasts = [stepper.last_begin(x.start, x.h, x.steps or 0, x.own_end) for x in ordered]
        states = np.zeros((count, rows))
        states[:, : given.states.shape[1]] = given.states[self._order]
        if clock_begins is not None:
            states[:, -1] = clock_begins
        self._begin = states.copy()
        self._steps, self._ordered = steps, ordered
        rests = np.array([line.remainder for line in ordered])
        every = save_every or 1
        met = (steps % every == 0) & (rests == 0.0)  # the last is one of them
        self._counts = steps // every + np.where(met, 1, 2)
        room = int(self._counts.max()) if save_every else 0
        self._kept = np.empty((count, room, rows))
        moved = np.zeros(0)
        if len(given.problems) > 1:
            moved = np.array([given.problems[k].params for k in self._order], dtype=np.float64)
        self._blocks = {
            "starts": np.array([line.start for line in ordered]),
            "lasts": np.array(lasts),
            "lengths": np.array([line.h for line in ordered]),
            "counts": steps.astype(np.float64),
            "rests": rests,
            "states": states.reshape(-1),
            "saved": self._kept.reshape(-1)[rows:],  # behind the first
            "found": np.full(count, OPEN),
            "moved": moved.reshape(-1),
        }
        self._call = _call_of(stepper.flow, {k: Block(v) for k, v in self._blocks.items()})

    def run(self, stop: Array) -> None:
        """Move all members."""
        every, room = self._save_every or 0, self._kept.shape[1]
        self._call(stop=Block(stop), rows=self._rows, every=every, saves=room)

    def outcome(self, problem: Problem, clock: bool) -> Outcome:
        """Return what has become of the members, in their own order."""
        ended = self._blocks["found"] == ENDED
        counts = np.where(ended, self._counts if self._save_every else 1, 0)
        samples = max(int(counts.max()), 1)
        kept, tau = self._states(counts)[:, :samples], self._times(counts, samples)
        own = np.argsort(self._order)
        if np.any(np.diff(self._order) != 1):
            kept, tau, counts, ended = kept[own], tau[own], counts[own], ended[own]
        y = np.ascontiguousarray(kept[:, :, : problem.rows])
        physical = np.full_like(tau, math.nan)
        if clock:
            physical = kept[:, :, -1].copy()
        elif problem.time == "t":
            physical = tau.copy()
        steps = np.where(ended, self._steps[own], 0)
        status = np.where(ended, "success", NOT_RUN).astype(object)
        return Outcome(tau, physical, y, counts, steps, status)

    def _states(self, counts: Integers) -> Array:
        """Return the saved states of each member, NaN behind them."""
        last = self._blocks["states"].reshape(len(counts), self._rows)
        kept = self._kept if self._save_every else last[:, None]
        if self._save_every:
            kept[:, 0] = self._begin
            kept[np.arange(len(counts)), self._counts - 1] = last
        for k in np.flatnonzero(counts < kept.shape[1]):
            kept[k, counts[k] :] = math.nan
        return kept

    def _times(self, counts: Integers, samples: int) -> Array:
        """Return the times of these states."""
        ends = np.array([line.own_end for line in self._ordered])
        number = np.arange(samples) * (self._save_every or 0)
        starts, lengths = self._blocks["starts"][:, None], self._blocks["lengths"][:, None]
        times: Array = starts + lengths * number
        times[np.arange(samples) >= counts[:, None]] = math.nan
        here = np.flatnonzero(counts)
        times[here, counts[here] - 1] = ends[here]
        return times


def _call_of(flow: Flow, blocks: dict[str, Block]) -> Call:
    """Return the loop over members for a flow: in lanes, if it can be had so."""
    moving = len(blocks["moved"]) > 0
    names = flow.kernel.fingerprint, *(f.recorded.fingerprint for f in flow.functions)
    key = (*names, str(moving))
    jitted = type(flow.functions[0].entry()) is Code  # not with NUMBA_DISABLE_JIT
    if flow.lane_by_lane and jitted and key not in _alone:
        try:
            return _call_in(members(moving), flow, blocks)
        except DeclarationError:  # it is compiled for single numbers already
            _alone.add(key)
    return _call_in(SCALAR, flow, blocks)


def _call_in(numbers: NumberType, flow: Flow, blocks: dict[str, Block]) -> Call:
    kernel = flow.bound.of_type(numbers)
    functions = tuple(f.of_type(numbers) for f in flow.functions)
    width = 1 if numbers is SCALAR else LANES
    held = numbers.memory.held

    def room(rows: int) -> Block:
        if width == 1:
            return scalar_block(rows)
        return held(scalar_block(rows * width).data.reshape(rows, width))

    params = flow.params if not len(blocks["moved"]) else room(len(flow.params))
    call = members_sweep(kernel, functions, numbers).call(
        advance=kernel,
        functions=functions,
        params=params,
        coefficients=flow.coefficients,
        fractions=flow.fractions,
        memory=room(flow.memory),
        work=room(flow.work),
        times=room(2),
        carries=scalar_block(flow.rows * width),
    )
    call.set(**blocks)
    return call
