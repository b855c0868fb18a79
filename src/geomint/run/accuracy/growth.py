"""How errors grow from the end of a stretch to the end of the run."""

from __future__ import annotations

import math

import numpy as np

from ...arguments import Array

__all__ = ["amplified", "exponential_rate", "extrapolated"]

FITTED = 0.25  # of the time of a stretch: errors from there on count
EARLY, MIDDLE, LATE = 0.25, 0.5, 0.75  # parts of the time whose errors tell exponential growth
REGULAR = (
    2.2  # of the logarithm of their ratio: 0.8 where errors grow with time, 1.7 with its square
)
SATURATED = 0.03  # relative errors beyond which they grow less
FEWEST = 5  # errors that tell anything
MOST = 300.0  # of an exponent


def extrapolated(times: Array, errors: Array, end: float, symmetric: bool) -> float:
    """Return the error at `end`, from those at some times before.

    Of a regular motion the phases go wrong in proportion to time, and by a symmetric method nothing
    else does; by others the frequencies do too, and the phases with the square of time: e/t is then
    a + b t, whose coefficients are fitted, none of them negative.
    """
    first = int(times.searchsorted(FITTED * times[-1]))
    t = times[first:]
    slopes = errors[first:] / t
    mean = root_mean_square(slopes)
    if symmetric or len(t) < 4 or end <= times[-1]:
        return mean * end
    tilt = float(np.polyfit(t, slopes, 1)[0])
    if tilt <= 0.0:
        return mean * end
    level = float(np.mean(slopes)) - tilt * float(np.mean(t))
    if level < 0.0:
        level, tilt = 0.0, float(np.sum(slopes * t) / np.sum(t * t))
    return level * end + tilt * end * end


def exponential_rate(times: Array, errors: Array) -> float | None:
    """Return the rate at which errors grow exponentially; 0 where they grow as in regular motions.

    By late ones against earlier ones, each in the root mean square, before they are as large as the
    motion; None where they are so before they tell anything.
    """
    large = np.flatnonzero(errors > SATURATED)
    count = int(large[0]) if len(large) else len(times)
    if count < FEWEST:
        return None if len(large) else 0.0
    times, errors = times[:count], errors[:count]
    part = times / times[-1]
    late, early = part >= LATE, (part >= EARLY) & (part <= MIDDLE)
    before, after = root_mean_square(errors[early]), root_mean_square(errors[late])
    then, now = (float(np.add.reduce(t)) / len(t) for t in (times[early], times[late]))
    grown = math.log(after / before) if before > 0.0 and after > 0.0 else 0.0
    return (grown - math.log(now / then)) / (now - then) if grown > REGULAR else 0.0


def amplified(rate: float, span: float) -> float:
    """Return how many times as far an error that grows exponentially gets as one that grows with time.

    ∫ exp(λ s) ds over the span, divided by it.
    """
    exponent = min(rate * span, MOST)
    return math.expm1(exponent) / exponent if exponent > 0.0 else 1.0


def root_mean_square(values: Array) -> float:
    """Return √(mean of squares)."""
    return math.sqrt(float(np.add.reduce(values * values)) / len(values))
