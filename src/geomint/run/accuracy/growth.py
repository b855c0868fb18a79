"""How errors grow from the end of a stretch to the end of the run."""

from __future__ import annotations

import math

import numpy as np

from ...arguments import Array

__all__ = ["extrapolated"]

FITTED = 0.25  # of the time of a stretch: errors from there on count


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


def root_mean_square(values: Array) -> float:
    """Return √(mean of squares)."""
    return math.sqrt(float(np.add.reduce(values * values)) / len(values))
