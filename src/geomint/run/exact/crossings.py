"""Events along an exact motion: looked for on the motion itself, piece by piece."""

import math
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from ...arguments import Array, Booleans
from ...errors import EventError
from ...problems.at_states import Values, evaluator
from ..events import Event, looked_at
from ..met import Met
from .path import ExactPath
from .polynomials import points_of
from .roots import Found, Roots

# Pieces that are looked at together: few at first, where an event may end it.
FIRST, MOST = 32, 1024
SEEN = 1e-9  # of a piece: nearer to where a run goes on it is what ended it


class ExactCrossings:
    """Events along one exact motion.

    Parameters
    ----------
    path : ExactPath
    events : mapping of name to Event
    begin, sign : float
        The problem's own time from which on they are looked for; the direction, 1 or −1.
    clock : bool
        Whether physical times are told beside it.
    again : bool
        Whether an earlier run has told what happened at `begin`.
    compiled : bool

    Attributes
    ----------
    reached : float
        The problem's own time up to which all is known.
    stopped : str
        The event that has ended the motion there.
    error : EventError or None
        Of one that cannot be told.
    """

    def __init__(
        self,
        path: ExactPath,
        events: Mapping[str, Event],
        begin: float,
        sign: float,
        *,
        clock: bool = False,
        again: bool = False,
        compiled: bool = True,
    ) -> None:
        self._path, self._events, self._clock = path, dict(events), clock
        self._begin, self._sign, self._again = begin, sign, again
        self._compiled = compiled
        self._values: dict[str, Values] = {}
        self._roots = {name: Roots(path.piece) for name in events}
        self._found = {name: _Known(name, event) for name, event in self._events.items()}
        self.reached, self.stopped = begin, ""
        self.error: EventError | None = None

    def prepare(self) -> None:
        """Compile, or find in the cache, the functions."""
        problem = self._path.problem
        for name, event in self._events.items():
            self._values[name] = evaluator(problem, looked_at(event, problem), self._compiled)

    def follow(self, end: float) -> Iterator[float]:
        """Look up to `end`, which may be infinite, or up to what ends it; yield what is reached."""
        if not self._events:
            self.reached = end
            return
        latest = abs(self._begin) if math.isinf(end) else max(abs(self._begin), abs(end))
        done, count = 0, FIRST
        piece = self._sign * max(self._path.piece, 4.0 * math.ulp(latest))  # else none is distinct
        while self.reached != end and not self.stopped and self.error is None:
            edges = self._begin + piece * np.arange(done, done + count + 1, dtype=np.float64)
            beyond = np.flatnonzero(self._sign * edges >= self._sign * end)
            if len(beyond):
                edges = np.append(edges[: beyond[0]], end)
            self._look(edges)
            done, count = done + count, min(2 * count, MOST)
            yield self.reached

    def _look(self, edges: Array) -> None:
        """Take the pieces between edges."""
        points = points_of(edges[:-1], edges[1:])
        times = points.reshape(-1)
        states = self._path.states(times)
        ends: list[tuple[float, str, EventError | None]] = [(float(edges[-1]), "", None)]
        for name, known in self._found.items():
            values, level = self._values[name], self._events[name].level

            def at(t: Array, values: Values = values, level: float = level) -> Array:
                return values(t, self._path.states(t)) - level

            here = (values(times, states) - level).reshape(points.shape)
            found = self._roots[name].within(edges, here, at)
            known.take(found, self._after)
            if known.last is not None:
                ends.append((known.last, name, None))
            if found.failure is not None:
                piece, t, value, what = found.failure
                ends.append((float(edges[piece]), "", EventError(name, t, None, value, what)))
        end, self.stopped, self.error = min(ends, key=lambda one: self._sign * one[0])
        self.reached = end
        for known in self._found.values():
            known.cut(self._sign, end)

    def _after(self, times: Array) -> Booleans:
        """Tell which of some times no earlier run has told."""
        if not self._again:
            return np.ones(len(times), dtype=bool)
        return self._sign * (times - self._begin) > SEEN * self._path.piece

    def count(self, name: str) -> int:
        """Return how many events of a name there are so far."""
        return len(self._found[name].times)

    @property
    def met(self) -> dict[str, Met]:
        """All events so far, by name."""
        result = {}
        for name, known in self._found.items():
            tau = known.times
            told = self._clock or self._path.problem.time == "t"
            t = self._path.physical(tau) if told else None
            result[name] = Met(tau.copy(), t, self._path.states(tau), known.directions.copy())
        return result


class _Known:
    """The events of one name so far."""

    def __init__(self, name: str, event: Event) -> None:
        self._event = event
        self.times, self.directions = np.zeros(0), np.zeros(0)

    def take(self, found: Found, after: Callable[[Array], Booleans]) -> None:
        """Take those of a direction that is asked for."""
        wanted = self._event.sign * found.directions >= 0.0
        wanted &= after(found.times)
        self.times = np.concatenate([self.times, found.times[wanted]])
        self.directions = np.concatenate([self.directions, found.directions[wanted]])

    @property
    def last(self) -> float | None:
        """When the event that ends the motion is, if it is among these."""
        last = self._event.last
        return float(self.times[last - 1]) if 0 < last <= len(self.times) else None

    def cut(self, sign: float, end: float) -> None:
        """Drop what lies beyond the end."""
        which = sign * self.times <= sign * end
        self.times, self.directions = self.times[which], self.directions[which]
