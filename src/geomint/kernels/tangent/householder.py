"""Householder's reflections of eight matrices at once: every number is a lane value."""

from __future__ import annotations

from typing import Any

from ..compiling.recorded import helper
from ..numbers.arithmetic import fma, like, select, sqrt

__all__ = ["reflect_by", "write_reflections"]


@helper
def reflect_by(s: Any, a: int, C: Any, by: Any, width: int, X: Any, first: int) -> None:
    """Reflect columns of a table, from `first` on, by column a of C: four at once."""
    pivot, end, m, fours = int(s.pivots[a]), int(s.ends[a]), len(by), (width - first) // 4
    for c in range(first, first + 4 * fours, 4):
        v, at = C[pivot * m + a], pivot * width + c
        d0, d1, d2, d3 = v * X[at], v * X[at + 1], v * X[at + 2], v * X[at + 3]
        for r in range(pivot + 1, end):
            v, at = C[r * m + a], r * width + c
            d0, d1 = fma(v, X[at], d0), fma(v, X[at + 1], d1)
            d2, d3 = fma(v, X[at + 2], d2), fma(v, X[at + 3], d3)
        d0, d1, d2, d3 = -by[a] * d0, -by[a] * d1, -by[a] * d2, -by[a] * d3
        for r in range(pivot, end):
            v, at = C[r * m + a], r * width + c
            X[at], X[at + 1] = fma(d0, v, X[at]), fma(d1, v, X[at + 1])
            X[at + 2], X[at + 3] = fma(d2, v, X[at + 2]), fma(d3, v, X[at + 3])
    for c in range(first + 4 * fours, width):
        d0 = C[pivot * m + a] * X[pivot * width + c]
        for r in range(pivot + 1, end):
            d0 = fma(C[r * m + a], X[r * width + c], d0)
        d0 = -by[a] * d0
        for r in range(pivot, end):
            X[r * width + c] = fma(d0, C[r * m + a], X[r * width + c])


@helper
def write_reflections(s: Any, C: Any, by: Any) -> Any:
    """Write Householder's reflections over columns, in their rows; return the volume they span.

    `s` are the `Supports` of `geomint.kernels.tangent.supports`.
    """
    m, volume = len(by), like(1.0, by[0])
    for a in range(m):
        pivot = int(s.pivots[a])
        first = C[pivot * m + a]
        square = first * first
        for r in range(pivot + 1, int(s.ends[a])):
            square = fma(C[r * m + a], C[r * m + a], square)
        norm = sqrt(square)
        volume = volume * norm
        by[a] = 1.0 / (norm * (norm + abs(first)))
        C[pivot * m + a] = first + select(first < 0.0, -norm, norm)
        reflect_by(s, a, C, by, m, C, a + 1)
    return volume
