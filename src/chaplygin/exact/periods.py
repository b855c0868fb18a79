"""Means over one turn of the differentials on an oval: the trapezoidal rule in double-double arrays.

How many points it takes follows from the gap to the nearest singular point, before any is computed.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np

import geomint as gi

from ..manifold import Array
from .branch_points import DIGITS, Oval, Separation, mp
from .double_double import DoubleDouble

__all__ = ["gap_of", "means_of", "points_of", "strip_of"]

FEWEST_POINTS, MOST_POINTS = 16, 16384  # of the trapezoidal rule
DECAY = 79.0  # e^−DECAY: to what the periods are computed


def gap_of(oval: Oval, b: Any) -> Any:
    """Return the gap from b below, or minus that from b above."""
    return oval.lower - b if b <= oval.lower else oval.upper - b


def strip_of(oval: Oval, separation: Separation) -> float:
    """Return η: cosh η = 1 + gap/d for the nearest singular point."""
    pairs = [x for x, ell in zip(separation.alpha, separation.ell, strict=True) if ell]
    gap = min(abs(gap_of(oval, b)) for b in (*oval.others, *pairs))
    return 2.0 * math.asinh(math.sqrt(float(gap / (oval.upper - oval.lower))))


def points_of(strip: float, separation: Separation) -> int:
    """Return how many points the trapezoidal rule takes: 2^k or 3·2^k."""
    needed = max(FEWEST_POINTS, DECAY / max(strip, 1e-300))
    if needed > MOST_POINTS:
        ratio = 1.0 / math.sinh(0.5 * max(strip, 1e-150)) ** 2
        expected = (
            "a motion that is not next to a separatrix: a branch point is beside an oval that is "
            f"{ratio:.3g} times as wide as their distance, condition {ratio:.3g}"
        )
        raise gi.DomainError("state", [float(x) for x in separation.polynomial], expected)
    power: int = 2 ** math.ceil(math.log2(needed))
    return 3 * power // 4 if needed <= 3 * power // 4 else power


@functools.lru_cache(maxsize=32)
def _sine_squares(count: int) -> DoubleDouble:
    """Return sin²(θ/2) at θ = 2πi/count, i = 0 … count/2."""
    with mp.workdps(DIGITS):
        quarter = [mp.sin(mp.pi * i / count) ** 2 for i in range(count // 4 + 1)]
        return DoubleDouble.of(quarter + [1 - x for x in quarter[-2::-1]])


def means_of(
    separation: Separation, k: int, nodes: list[Any], pairs: list[int], count: int
) -> tuple[list[Any], Array]:
    """Return the means over θ_k of all differentials, and samples at θ = 2πi/N, shape (rows, N)."""
    oval = separation.ovals[k]
    sine = _sine_squares(count)
    cosine = sine[::-1]
    width = DoubleDouble.one(oval.upper - oval.lower)

    def away(b: Any) -> DoubleDouble:  # |λ − b|
        below = b <= oval.lower
        gap = oval.lower - b if below else b - oval.upper
        return DoubleDouble.one(gap) + width * (sine if below else cosine)

    def product(points: list[Any], scale: Any) -> DoubleDouble:  # of |λ − b|, times scale
        value = DoubleDouble.one(scale)
        for b in points:
            value = value * away(b)
        return value

    density = product(list(oval.others), 16 * separation.lead).root().inverse()  # 1/(4√Q)
    rows = []
    for j, node in enumerate(nodes):  # −ℓ_j/(4√Q)
        others = [(s, x) for s, x in enumerate(nodes) if s not in (j, k)]
        scale = -1 / mp.fprod(node - x for s, x in enumerate(nodes) if s != j)
        scale *= (-1) ** sum(s > k for s, _ in others)
        value = density * product([x for _, x in others], scale)
        rows.append(value if j == k else value * width * (sine + DoubleDouble.one(mp.mpf(-0.5))))
    alpha = separation.alpha
    for g in pairs:  # −½ ℓ_g α_g P/((λ − α_g)² √Q)
        scale = -2 * separation.ell[g] * alpha[g] * (-1) ** sum(x >= oval.upper for x in alpha)
        others = [x for h, x in enumerate(alpha) if h != g]
        rows.append(density * product(others, scale) * away(alpha[g]).inverse())
    half = np.array([row.high for row in rows])
    return [_mean(row, count) for row in rows], np.concatenate([half, half[:, -2:0:-1]], axis=1)


def _mean(row: DoubleDouble, count: int) -> Any:
    """Return the mean of an even function of θ from its values over half of the circle."""
    ends, inside = row[[0, -1]].total(), row[1:-1].total()
    parts = (2 * inside.high, 2 * inside.low, ends.high, ends.low)
    return mp.fsum(mp.mpf(float(x)) for x in parts) / count
