"""A series taken apart: jumps, oscillations, a trend, and a rest.

Jumps and oscillations hide each other, so both are looked for twice. Neither is known exactly, and
what is wrong with them looks like a trend: that is the systematic error of the rise.
"""

from typing import NamedTuple

import numpy as np

from ..arguments import Array
from .jumps import Jump, best_step, find_jumps, steps_of
from .oscillations import without_oscillations
from .trend import Trend, find_trend

TWO_SIDED = 1.96  # standard errors: 95 % of a normal distribution
FEIGNED = 0.05  # of what is seen in an oscillation: it may not be the sine that was taken away
LEVER = 1.5  # what a jump of size 1 in the middle of a run is to a line
WALK, STEP = 10.0, 20.0  # gains of likelihood, see `geomint.watch.trend`
CLEAR_STEP = 8.0  # standard errors


class Part(NamedTuple):
    """A series without jumps, taken apart.

    Attributes
    ----------
    series, rest : array
        As it is, and without its oscillations.
    trend : Trend
        Of the rest.
    doubt : float
        The systematic error of its rise.
    unsteady : float
        The standard deviation of what sines of constant amplitudes leave.
    """

    series: Array
    rest: Array
    trend: Trend
    doubt: float
    unsteady: float

    @property
    def error(self) -> float:
        """The error of the rise."""
        return float(np.hypot(self.trend.error, self.doubt))

    @property
    def bound(self) -> float:
        """The largest rise or fall that is not excluded at 95 %."""
        return abs(self.trend.rise) + TWO_SIDED * self.error


def evenly(times: Array, *rows: Array) -> tuple[Array, ...]:
    """Return rows at equally spaced times, and these from 0 to 1."""
    x = (times - times[0]) / (times[-1] - times[0])
    even = np.linspace(0.0, 1.0, len(x))
    if np.abs(x - even).max() > 1e-3 / len(x):
        rows = tuple(np.interp(even, x, row) for row in rows)
    return even, *rows


def taken_apart(x: Array, series: Array, jumps: list[Jump]) -> Part:
    """Take a series apart at equally spaced times from 0 to 1; `jumps` have been taken away."""
    cleaned = without_oscillations(x, series)
    doubts = [FEIGNED * cleaned.seen, *(LEVER * jump.error for jump in jumps)]
    doubt = float(np.linalg.norm(doubts))
    return Part(series, cleaned.rest, find_trend(x, cleaned.rest), doubt, cleaned.unsteady)


def without_jumps(x: Array, series: Array, least: float) -> tuple[Part, list[Jump]]:
    """Take a series without its jumps apart, and return them, the largest first.

    Jumps below half of `least` are left in it, as are those below `least` that only a fit finds.
    """
    part = plain = taken_apart(x, series, [])
    jumps = []
    for _ in range(2):
        beside = part.rest + (series - part.series)  # what oscillations leave, jumps and all
        jumps = find_jumps(beside, 0.5 * least)
        if not jumps:
            break
        part = taken_apart(x, series - steps_of(jumps, beside), jumps)
    if jumps:
        return part, jumps
    if plain.trend.by_walk > WALK and plain.bound > least:
        jump = best_step(plain.rest)
        part = taken_apart(x, series - steps_of([jump], plain.rest), [jump])
        others = plain.trend.white + plain.trend.by_walk + max(plain.trend.by_line, 0.0)
        large = abs(jump.size) > max(least, CLEAR_STEP * jump.error)
        if large and part.trend.white > others + STEP:
            return part, [jump]
    return plain, []
