"""The time scale of a motion at a state, of which default steps are a fraction."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from .errors import DomainError
from .evaluate import derivative
from .problem import Problem

__all__ = ["characteristic_time"]

Array = npt.NDArray[np.float64]
RESTING = 1.0 / 32.0  # a piece whose time is this part of the next one's is nearly at rest
SPACING = 1e-6  # of the differences that give the linearised motion, relative


def characteristic_time(problem: Problem, y0: Array) -> float:
    """Return the shortest ‖piece‖ / ‖d piece/dt‖ over the pieces of the state, at y0.

    For a unit vector turning at angular velocity ω this is 1/ω. But the size of a piece at rest, or
    nearly so, as a momentum is at a turning point, is not that of its motion. Where there are such
    pieces the time scale of the linearised motion (`linearised_time`) decides: alone if no piece has
    a time, and else where the two are far apart. 1 if there is none.

    Raises
    ------
    DomainError
        If the derivative at y0 is not finite, or so large that no time is left.
    """
    rates = derivative(problem, y0)
    times, from_rest = [], False
    for rows in problem.slices.values():
        size, rate = length(y0[rows]), length(rates[rows])
        if not (math.isfinite(rate) and (rate == 0.0 or size / rate > 0.0 or size == 0.0)):
            expected = "a state with a finite derivative, of which it is a time: give a step"
            raise DomainError("state", y0, expected)
        if rate > 0.0 and size > 0.0:
            times.append(size / rate)
        from_rest |= rate > 0.0 and size == 0.0
    times.sort()
    nearly = len(times) > 1 and times[0] < RESTING * times[1]
    if times and not (from_rest or nearly):
        return times[0]
    linear = linearised_time(problem, y0, rates)
    if not times:
        return linear if math.isfinite(linear) else 1.0
    time = max(times[0], min(times[1], linear)) if nearly else times[0]
    return linear if from_rest and linear < RESTING * time else time


@np.errstate(all="ignore")
def linearised_time(problem: Problem, y0: Array, rates: Array) -> float:
    """Return min(1/ρ(J), √(‖piece‖ / ‖J ẏ‖)) with J = ∂ẏ/∂y, ρ its spectral radius; inf if all are 0.

    The second, for pieces that are not nearly at rest themselves, is the time in which the second
    derivative moves a piece by its own size.
    """
    J = jacobian(problem, y0)
    if not np.isfinite(J).all():
        return math.inf
    radius = float(np.max(np.abs(np.linalg.eigvals(J))))
    linear = 1.0 / radius if radius > 0.0 else math.inf
    found = [linear]
    for rows in problem.slices.values():
        size, rate, second = length(y0[rows]), length(rates[rows]), length((J @ rates)[rows])
        resting = rate > 0.0 and size < RESTING * rate * linear
        if second > 0.0 and size > 0.0 and not resting:
            found.append(math.sqrt(size / second))
    return min(found)


def jacobian(problem: Problem, y0: Array) -> Array:
    """Return ∂ẏ/∂y by central differences."""
    J = np.zeros((problem.rows, problem.rows))
    for rows in problem.slices.values():
        size = SPACING * (length(y0[rows]) or length(y0) or 1.0)
        for i in range(rows.start, rows.stop):
            above, below = y0.copy(), y0.copy()
            above[i] += size
            below[i] -= size
            difference = derivative(problem, above) - derivative(problem, below)
            J[:, i] = difference / (above[i] - below[i])
    return J


def length(v: Array) -> float:
    """Return ‖v‖ without overflow or underflow of its square."""
    largest = float(np.max(np.abs(v)))
    if largest == 0.0 or not math.isfinite(largest):
        return largest
    return largest * float(np.linalg.norm(v / largest))
