"""A second run in longer steps, beside the first where a core is free: how both part tells errors.

Local errors say nothing of what becomes of them. With order p the second run, in steps r times as long,
errs r^p times as much, so that the difference of both ends is r^p − 1 times the error of the first one
(L. F. Richardson).
"""

import threading

from ..arguments import Array
from ..kernels.compiling.cores import cores
from ..kernels.solve.status import OK
from ..methods.partial import rounding
from ..methods.stepper import NOTHING, Stepper
from .integrator import Integrator
from .timeline import Timeline

LONGER, MORE = 1.37, 10.0  # times the step, at most: both meet at their ends only; times the error
LONG = 300  # steps from which on another core is worth while
PIECE = 1 << 14  # steps after which it is seen that nobody waits


def longer(order: int) -> float:
    """Return how many times as long steps of a second run are: those of high orders err soon."""
    return float(min(LONGER, MORE ** (1.0 / order)))


class Second:
    """The run of an integrator that has not begun yet, in longer steps, without anything beside it."""

    def __init__(self, integrator: Integrator, stretches: tuple[Timeline, ...]) -> None:
        self._from, self._stretches = integrator.stepper.state.copy(), stretches
        self._integrator, self._longer = integrator, longer(integrator.method.order)
        self._end: float | None = None
        self._found: Array | None = None
        self._thread: threading.Thread | None = None
        self._given_up = False

    def begin(self, end: float) -> None:
        """Let it go on beside the run, to its end, where that is long and a core is free."""
        first = self._stretches[0]
        steps = abs((end - first.start) / (self._longer * first.h))
        alone = threading.active_count() == 1 and cores() > 1
        if steps > LONG and alone and self._integrator.stepper.compiled:
            self._end = end
            given = self._new(), end  # before the run may change its stepper
            self._thread = threading.Thread(target=self._run, args=given, daemon=True)
            self._thread.start()

    def state(self, end: float) -> Array | None:
        """Return its state at the end, of which the run may have had another; None where it fails."""
        if self._thread is not None:
            self._given_up = end != self._end
            self._thread.join()
            self._thread = None
        if end != self._end or self._given_up:
            self._given_up, self._end = False, end
            self._run(self._new(), end)
        return self._found

    def give_up(self) -> None:
        """Let it end as soon as it can: nobody asks for it."""
        self._given_up = True

    def both(self, end: float) -> tuple[Array | None, Array | None]:
        """Return the states of both runs at another time; None where one fails."""
        stepper = self._new()
        return self._state(stepper, end, 1.0), self._state(stepper, end, self._longer)

    def _new(self) -> Stepper:
        first = self._stretches[0]
        stepper = self._integrator.stepper.like(self._from, first.start, self._longer * first.h)
        stepper.turning = False  # Newton's method is compiled for the run alone
        return stepper

    def _run(self, stepper: Stepper, end: float) -> None:
        self._found = self._state(stepper, end, self._longer)

    def _state(self, stepper: Stepper, end: float, longer: float) -> Array | None:
        y, last = self._from, self._stretches[-1]
        for stretch in self._stretches:
            h, until = longer * stretch.h, stretch.own_end
            if stretch is last or until is None or (end - until) * h <= 0.0:
                return self._over(stepper, y, stretch.start, end, h)
            found = self._over(stepper, y, stretch.start, until, h)
            if found is None:
                break
            y = found
        return None

    def _over(self, stepper: Stepper, y: Array, begin: float, end: float, h: float) -> Array | None:
        """Return the state after whole steps of h, and a last partial one."""
        done, whole = 0, int((end - begin) / h)
        stepper.begin(y, begin, h)
        while done < whole and not self._given_up:
            count = min(PIECE, whole - done)
            if stepper.advance(done, count, whole + 1, NOTHING).status != OK:
                return None
            done += count
        rest = end - (begin + whole * h)
        if abs(rest) > rounding(end):
            stepper.begin(stepper.state.copy(), end - rest, rest)
            if stepper.advance(0, 1, 2, NOTHING).status != OK:
                return None
        return stepper.state.copy()
