"""Whether physical time, integrated beside a problem in τ, will get to its end."""

import math

from ..errors import ClockError
from .timeline import MOST_STEPS

FIRST = 512  # steps after which there is a pace


class Pace:
    """The mean pace of the clock over the last half of all steps, or more.

    A single chunk would say too little: a clock may nearly rest for a while. Where half of a run is
    nearly at rest, and at its pace the end is more than 2⁵³ steps away, as many as a run may have, the
    end is taken for one that is never reached.

    Parameters
    ----------
    end : float
        In physical time.
    direction : float
        Of the run: its sign counts.
    """

    def __init__(self, end: float, direction: float) -> None:
        self._end, self._sign = end, math.copysign(1.0, direction)
        self._before: tuple[int, float] | None = None  # a step, and physical time there

    def reaches(self, number: int, own_time: float, physical: float) -> None:
        """Take physical time after so many steps; raise `ClockError` if it will not get to its end."""
        if self._before is None:
            self._before = (number, physical) if number >= FIRST else None
            return
        steps = number - self._before[0]
        if steps < self._before[0]:
            return
        gained = self._sign * (physical - self._before[1])
        left = abs(self._end - physical)
        if not gained * MOST_STEPS > left * steps:
            hint = (
                f"it is {physical:.9g} of {self._end:.9g} and gained {gained:.3g} in the last {steps} "
                "steps; the clock dt/dτ has to be positive and not to tend to 0"
            )
            raise ClockError(own_time, number, left, 0, hint)
        self._before = (number, physical)
