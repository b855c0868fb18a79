"""How errors grow from the end of a stretch to the end of the run."""

from __future__ import annotations

import numpy as np

from ...arguments import Array

__all__ = ["extrapolated"]


def extrapolated(times: Array, errors: Array, end: float, symmetric: bool) -> float:
    """Return the error at `end`, from those at some times before.

    Of a regular motion the phases go wrong in proportion to time, and by a symmetric method nothing
    else does; by others the frequencies do too, and the phases with the square of time: e/t is then
    a + b t, whose coefficients are fitted, none of them negative.
    """
    some = times >= 0.25 * times[-1]
    t, slopes = times[some], errors[some] / times[some]
    if end <= 1.01 * times[-1]:
        return float(np.sqrt(np.mean(slopes**2))) * end
    if symmetric or len(t) < 4:
        return float(np.sqrt(np.mean(slopes**2))) * end
    tilt = float(np.polyfit(t, slopes, 1)[0])
    if tilt <= 0.0:
        return float(np.sqrt(np.mean(slopes**2))) * end
    level = float(np.mean(slopes)) - tilt * float(np.mean(t))
    if level < 0.0:
        level, tilt = 0.0, float(np.sum(slopes * t) / np.sum(t * t))
    return level * end + tilt * end * end
