"""Steps whose length nobody has given, watched outside of `solve`: in loops, and in samples."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from ..arguments import Array
from ..kernels.solve.status import OK
from ..methods.method import Method
from ..methods.stepper import NOTHING
from ..problems.evaluate import rates_of
from ..problems.time_scale import turning_time
from .local_error import DOUBT, SURE, LocalError, Ranked, promised, tell_errors

if TYPE_CHECKING:
    from .integrator import Integrator

LONG = 1000  # steps that are ranked whenever a motion begins anew: it costs them nothing
TIMES = 8.0  # characteristic times: a turn of a motion that seemed faster than it is
MANY = 9  # steps of the longest window of ranks
PIECE, OFTEN, SELDOM = 1 << 13, 8, 8  # steps ranked at a time: the first pieces, then one in eight
NEAR = 1e-5  # of a step: how far rates are looked at from a state
ROUNDING = 2.0**-53  # errors tell no more
MORE = 2.0  # times the largest error so far: what is measured next


class WatchedSteps:
    """The steps of an integrator, ranked from call to call; errors are measured where they rise."""

    def __init__(self, made: Integrator) -> None:
        self._made, self._limit = made, DOUBT * promised(made.method)
        self._ranked: Ranked | None = None
        self._at, self._until, self._turn = -1, 0, 0
        self._known, self._ranking = 0.0, False
        self._far = 0.0

    def rank(self, count: int) -> None:
        """Rank the `count` steps that come next, as they are, or a part of them where they are many."""
        made, ranked = self._made, self._ranked
        anew = made.done != self._at
        if anew or made.done >= self._until:  # another motion, or another piece of it
            few = ranked is not None and max(count, made.done) <= ranked.window
            self._until = made.done + (MANY if few else PIECE)
            self._turn += not few
            often = self._turn <= OFTEN or self._turn % SELDOM == 0 or (anew and count > LONG)
            self._ranking = often and not few
            made._ranks = NOTHING
            if self._ranking:
                self._ranked = Ranked(made)
        self._at = -1  # until they have been taken

    def look(self) -> LocalError | None:
        """Return what the steps taken err by, if that is more than is promised."""
        self._at, ranked = self._made.done, self._ranked
        if ranked is None or not self._ranking:
            return None
        number = ranked.number("largest")
        if not number > self._known:
            return None
        error = ranked.measured(1)
        if error.largest > SURE * self._limit:
            error = ranked.measured()
        self._known = number * self._more(error) ** (1.0 / ranked.power)
        return error if error.largest > self._limit else None

    def cut(self, end: float, after: Array) -> LocalError | None:
        """Return what one step to a time, which leads there, errs by, if that is too much.

        Looked at are those that lead farther than all before.
        """
        far = max(map(abs, (after - self._made.stepper.state).tolist()))
        if not far > self._far:
            return None
        error = self._of(end)
        self._far = far * self._more(error) ** (1.0 / (self._made.method.order + 1))
        return error if error.largest > self._limit else None

    def _of(self, end: float) -> LocalError:
        """Return what a few steps to a time err by."""
        ranked = Ranked(self._made)
        ranked.end = end
        return ranked.measured()

    def _more(self, error: LocalError) -> float:
        """Return times what an error is looked at again."""
        return max(SURE * self._limit / max(error.largest, ROUNDING), MORE)

    def through(self, steps: int) -> bool:
        """Take steps; tell whether they err by more than is promised, or one fails."""
        made, ranked = self._made, Ranked(self._made)
        while steps > 0:
            taken, _ = made.take(min(steps, PIECE), made.done + PIECE + 1, made._unread)
            if taken.status != OK:
                return True
            steps -= taken.steps
        ranked.end = made.time
        return ranked.measured(1).largest > self._limit

    @staticmethod
    def enough(method: Method, steps: int | None, part: int, all_steps: int = 0) -> int:
        """Return how many steps of a run are looked at: a few characteristic times, or a part."""
        most = steps or 0
        return min(max((all_steps or most) // part, math.ceil(TIMES / method.step_fraction)), most)

    def at(self, state: Array, time: float) -> LocalError | None:
        """Go to a state, and return what a step from there errs by, if that is too much.

        What is left of a step half as long, as of a piece that is nearly 0, are roundings.
        """
        made, h = self._made, self._made.h
        made._anew(state, time, h)
        error = self._of(time + h)
        if not error.largest > self._limit:
            return None
        made._anew(state, time, 0.5 * h)
        rounded = 0.5 * error.largest < self._of(time + 0.5 * h).largest < math.inf
        return None if rounded else error


def tell_fastest(made: Integrator, places: Iterable[tuple[Array, float]]) -> None:
    """Warn if steps err by more than is promised where rates turn fastest, of states at their times."""
    fastest = fastest_of(made, places)
    error = None if fastest is None else WatchedSteps(made).at(*fastest)
    if error is not None:
        tell_errors(error, made.problem.time)


def fastest_of(
    made: Integrator, places: Iterable[tuple[Array, float]]
) -> tuple[Array, float] | None:
    """Return the state, with its time, from which rates turn around soonest."""
    found, least, problem = None, math.inf, made.problem
    for y, time in places:
        rate_at = rates_of(problem, y, made.stepper.compiled)
        rates = rate_at(problem, y, time)
        turning = turning_time(problem, y, rates, time, rate_at, NEAR * abs(made.h))
        if turning <= least:
            found, least = (y, time), turning
    return found
