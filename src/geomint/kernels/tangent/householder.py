"""Householder's reflections of eight matrices at once: every number is a lane value."""

from __future__ import annotations

from typing import Any

from ..compiling.recorded import helper
from ..numbers.arithmetic import fma, like, select, sqrt

__all__ = ["reflect_by", "write_reflections"]


@helper
def reflect_by(n: int, m: int, a: int, C: Any, by: Any, width: int, X: Any, first: int) -> None:
    """Reflect columns of a table of n rows, from `first` on, by column a of C: four at once."""
    fours = (width - first) // 4
    for c in range(first, first + 4 * fours, 4):
        v, at = C[a * m + a], a * width + c
        d0, d1, d2, d3 = v * X[at], v * X[at + 1], v * X[at + 2], v * X[at + 3]
        for r in range(a + 1, n):
            v, at = C[r * m + a], r * width + c
            d0, d1 = fma(v, X[at], d0), fma(v, X[at + 1], d1)
            d2, d3 = fma(v, X[at + 2], d2), fma(v, X[at + 3], d3)
        d0, d1, d2, d3 = -by[a] * d0, -by[a] * d1, -by[a] * d2, -by[a] * d3
        for r in range(a, n):
            v, at = C[r * m + a], r * width + c
            X[at], X[at + 1] = fma(d0, v, X[at]), fma(d1, v, X[at + 1])
            X[at + 2], X[at + 3] = fma(d2, v, X[at + 2]), fma(d3, v, X[at + 3])
    for c in range(first + 4 * fours, width):
        d0 = C[a * m + a] * X[a * width + c]
        for r in range(a + 1, n):
            d0 = fma(C[r * m + a], X[r * width + c], d0)
        d0 = -by[a] * d0
        for r in range(a, n):
            X[r * width + c] = fma(d0, C[r * m + a], X[r * width + c])


@helper
def write_reflections(n: int, m: int, C: Any, by: Any) -> Any:
    """Write Householder's reflections over m columns; return the volume that columns span."""
    volume = like(1.0, by[0])
    for a in range(m):
        square = C[a * m + a] * C[a * m + a]
        for r in range(a + 1, n):
            square = fma(C[r * m + a], C[r * m + a], square)
        norm, first = sqrt(square), C[a * m + a]
        volume = volume * norm
        by[a] = 1.0 / (norm * (norm + abs(first)))
        C[a * m + a] = first + select(first < 0.0, -norm, norm)
        reflect_by(n, m, a, C, by, m, C, a + 1)
    return volume
