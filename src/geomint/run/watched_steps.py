"""Steps whose length nobody has given, watched outside of `solve`: in loops, and in samples."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from ..arguments import Array
from ..kernels.solve.status import OK
from .local_error import DOUBT, SURE, LocalError, Ranked, promised
from .step_notes import tell_errors

if TYPE_CHECKING:
    from .integrator import Integrator

__all__ = ["WatchedSteps", "tell_errors_at"]

MORE = 2.0  # times the largest error so far: what is measured next


class WatchedSteps:
    """The steps of an integrator, ranked from call to call; errors are measured where they rise."""

    def __init__(self, made: Integrator) -> None:
        self._made, self._limit = made, DOUBT * promised(made.method)
        self._ranked: Ranked | None = None
        self._at, self._known = -1, 0.0
        self._cuts, self._longest = 0, 0.0

    def rank(self) -> Ranked:
        """Rank the steps that come next: those of another motion, if it has begun anew."""
        ranked, self._at = self._ranked if self._at == self._made.done else None, -1
        self._ranked = ranked or Ranked(self._made)
        return self._ranked

    def look(self) -> LocalError | None:
        """Return what the steps taken err by, if that is more than is promised."""
        ranked, self._at = self._ranked, self._made.done
        assert ranked is not None
        number = ranked.number("largest")
        if not number > self._known:
            return None
        error = ranked.measured(1)
        if error.largest > SURE * self._limit:
            error = ranked.measured()
        more = max(SURE * self._limit / max(error.largest, 1e-300), MORE)
        self._known = number * more ** (1.0 / ranked.power)
        return error if error.largest > self._limit else None

    def cut(self, end: float) -> LocalError | None:
        """Return what one step to a time errs by, if that is too much; some of them are looked at."""
        length = abs(end - self._made.time)
        self._cuts += 1
        if self._cuts & (self._cuts - 1) and length <= MORE * self._longest:
            return None
        self._longest = max(length, self._longest)
        return self._to(end)

    def _to(self, end: float) -> LocalError | None:
        """Return what a few steps to a time err by, if that is more than is promised."""
        ranked = Ranked(self._made)
        ranked.end = end
        error = ranked.measured()
        return error if error.largest > self._limit else None

    def through(self, steps: int) -> LocalError | None:
        """Take steps; return what they err by, if that is more than is promised, or if one fails."""
        made = self._made
        begin, window = made.time, self.rank().window
        if steps <= window:
            return self._to(begin + max(steps, 1) * made.h)
        if made.take(steps, made.done + steps + 1, made.unread)[0].status != OK:
            return LocalError(math.inf, made.time, math.inf, abs(made.h))
        return self.look()

    def at(self, state: Array, time: float) -> LocalError | None:
        """Go to a state, and return what a step from there errs by, if that is too much."""
        self._made.begin(state, time)
        return self._to(time + self._made.h)


def tell_errors_at(made: Integrator, places: Iterable[tuple[Array, float]]) -> None:
    """Warn of steps from some states at their times that err by more than is promised."""
    watched = WatchedSteps(made)
    found = [error for place in places if (error := watched.at(*place)) is not None]
    if found:
        tell_errors(max(found), made.problem.time)
