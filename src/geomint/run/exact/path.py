"""The exact motion of a problem as a run sees it: states at own and at physical times."""

import functools
import math
from typing import Any

import numpy as np

from ...arguments import Array
from ...errors import DeclarationError, GeomintError
from ...problems.problem import Problem
from ...problems.time_scale import characteristic_time


class ExactPath:
    """The exact motion through one state, in the times of a run.

    Parameters
    ----------
    problem : Problem
        With an exact motion.
    y0 : array
        A canonical state.
    own, physical : float
        The problem's own time at that state, and physical time.

    Raises
    ------
    FormError, DomainError
        If the problem has no exact motion, or none through this state.
    """

    def __init__(self, problem: Problem, y0: Array, own: float, physical: float) -> None:
        self.problem, self._y0, self._own, self._physical = problem, y0, own, physical
        self._in_tau = problem.time == "tau"
        self.motion = problem.exact(y0)

    def states(self, own: Array) -> Array:
        """Return the states at the problem's own times, one a row."""
        motion = self.motion.at_tau if self._in_tau else self.motion
        return self._states(motion, np.asarray(own) - self._own)

    def at_physical(self, t: Array) -> Array:
        """Return the states at physical times, one a row."""
        return self._states(self.motion, np.asarray(t) - self._physical)

    def physical(self, own: Array) -> Array:
        """Return physical times at the problem's own."""
        if not self._in_tau:
            return np.array(own)
        after = np.asarray(own) - self._own
        return self._physical + _passed(after, self._numbers(self.motion.time, after, ()))

    def own(self, t: Array) -> Array:
        """Return the problem's own times at physical ones."""
        if not self._in_tau:
            return np.array(t)
        after = np.asarray(t) - self._physical
        return self._own + _passed(after, self._numbers(self.motion.tau, after, ()))

    @property
    def has_clock(self) -> bool:
        """Whether physical time can be told: where it is another one, its series may be refused."""
        try:
            self.physical(np.array([self._own]))
        except GeomintError:
            return False
        return True

    @functools.cached_property
    def piece(self) -> float:
        """How much of its own time is looked at as one when events are looked for.

        A quarter of the shortest period, where the motion says its frequencies, and not more than the
        characteristic time at the state where it was begun.
        """
        longest = characteristic_time(self.problem, self._y0)
        name = "frequencies" if self._in_tau else "mean_frequencies"
        fastest = np.abs(getattr(self.motion, name, np.zeros(0))).max(initial=0.0)
        return min(longest, 0.5 * math.pi / float(fastest)) if fastest > 0.0 else longest

    def _states(self, function: Any, times: Array) -> Array:
        return self._numbers(function, times, (self.problem.rows,))

    def _numbers(self, function: Any, times: Array, shape: tuple[int, ...]) -> Array:
        """Return what the motion says at times; or raise `DeclarationError` for what are no numbers."""
        if not times.size:
            return np.zeros((*times.shape, *shape))
        found = np.asarray(function(times))
        right = found.shape == times.shape + shape and found.dtype.kind in "biuf"
        if not (right and np.isfinite(found).all()):
            expected = f"a motion of finite numbers, of the shape {times.shape + shape} at times"
            what = f"has to give {expected} of the shape {times.shape}"
            raise DeclarationError(self.problem.name, "make_exact", what)
        return found.astype(np.float64)


def _passed(after: Array, time: Array) -> Array:
    """Return a time of the other kind, 0 where what rounding leaves of it points to the other side."""
    return np.where(np.sign(after) == np.sign(time), time, 0.0)


class Following:
    """What watchers see in the place of a stepper: a step is the exact motion from any state."""

    def __init__(self, problem: Problem, state: Array, compiled: bool) -> None:
        self._problem, self.state, self.compiled = problem, state, compiled

    def single_step(self, y: Array, time: float, length: float) -> Array:
        """Return the state after a span of the problem's own time, without the row of the clock."""
        state = self._problem.canonical(y[: self._problem.rows])
        path = ExactPath(self._problem, state, time, 0.0)
        return path.states(np.array([time + length]))[0]
