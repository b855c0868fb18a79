"""The order that a method shows in a comparison: the slope of its errors where they fall steadily.

Of a method at fixed steps the logarithms of step and error have a slope p, the order, where steps are
small enough for the first term of the error and errors large enough not to be rounding. The
*asymptotic part* is the longest run of at least three neighbouring points whose local slopes

    (log e_i − log e_(i+1)) / (log h_i − log h_(i+1))

are above a half, for errors that fall, and differ by at most a fifth of the largest; of several as
long the one of the smaller steps. The order is the slope of the line of least squares through its
points, with its standard error.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..arguments import Array

__all__ = ["FittedOrder", "fitted_order", "fitted_orders"]

FEWEST = 3  # points
AGREE = 0.2  # of the largest local slope
LEAST = 0.5  # what counts as a fall


class FittedOrder(NamedTuple):
    """The order that a method shows.

    Attributes
    ----------
    order : int
        The method's own.
    fitted, error : float or None
        The slope and its standard error; None without an asymptotic part.
    steps : tuple of float
        Of the asymptotic part, the coarse one first; empty without.
    """

    order: int
    fitted: float | None = None
    error: float | None = None
    steps: tuple[float, ...] = ()

    @property
    def text(self) -> str:
        """The slope with its error, to the digits that this leaves: ``"4.02 ± 0.01"``; "—" without."""
        if self.fitted is None or self.error is None:
            return "—"
        digits = 4 if self.error < 1e-4 else max(1, -math.floor(math.log10(self.error)))
        return f"{self.fitted:.{digits}f} ± {self.error:.{digits}f}"


def fitted_orders(points: Sequence[Mapping[str, Any]]) -> dict[str, FittedOrder]:
    """Return the order of each method at fixed steps, of points as ``compare.json`` has them."""
    found: dict[str, list[Mapping[str, Any]]] = {}
    for point in points:
        if point["rtol"] is None and point["representation"]:
            found.setdefault(point["method"], []).append(point)
    return {
        method: fitted_order(own[0]["order"], [(p["step"], p["error"]) for p in own if p["error"]])
        for method, own in found.items()
    }


def fitted_order(order: int, measured: Sequence[tuple[float, float]]) -> FittedOrder:
    """Return what pairs (step, error) > 0 show of a method of that order."""
    pairs = sorted(dict(measured).items(), reverse=True)
    if len(pairs) < FEWEST:
        return FittedOrder(order)
    h, e = np.log(np.array(pairs)).T
    part = _asymptotic(np.diff(e) / np.diff(h))
    if part is None:
        return FittedOrder(order)
    first, last = part
    x, y = h[first : last + 1], e[first : last + 1]
    x = x - x.mean()
    slope = float((x @ y) / (x @ x))
    left = y - y.mean() - slope * x
    error = float(np.sqrt((left @ left) / (len(x) - 2) / (x @ x)))
    return FittedOrder(order, slope, error, tuple(step for step, _ in pairs[first : last + 1]))


def _asymptotic(slopes: Array) -> tuple[int, int] | None:
    """Return the first and the last point of the longest part with slopes that agree, or None."""
    best = None
    for first in range(len(slopes)):
        for last in range(first + FEWEST - 2, len(slopes)):
            own = slopes[first : last + 1]
            if own.min() < LEAST or own.max() - own.min() > AGREE * own.max():
                continue
            if best is None or last + 1 - first >= best[1] - best[0]:
                best = first, last + 1
    return best
