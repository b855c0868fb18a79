"""Orthonormal bases by Householder's reflections, and determinants of matrices near the identity.

Reflections are ``1 − v vᵀ`` with (v, v) = 2, one row of N numbers each. With the m reflections of
m independent rows, the first m columns of their product span those rows and the others what is
perpendicular to them.
"""

from __future__ import annotations

from typing import Any

from ..compiling.recorded import helper
from ..numbers.arithmetic import log, sqrt
from ..numbers.blocks import part

__all__ = ["log_det_near_identity", "reflect", "reflect_back", "reflections"]


@helper
def mirror(v: Any, x: Any) -> None:
    """Apply ``1 − v vᵀ`` to x."""
    along = v[0] * x[0]
    for i in range(1, len(x)):
        along += v[i] * x[i]
    for i in range(len(x)):
        x[i] = x[i] - along * v[i]


@helper
def reflect(m: int, vectors: Any, x: Any) -> None:
    """Replace x by its components in the basis: ``H_m ⋯ H_1 x``."""
    for a in range(m):
        mirror(part(vectors, a * len(x), len(x)), x)


@helper
def reflect_back(m: int, vectors: Any, x: Any) -> None:
    """Replace components in the basis by the vector: ``H_1 ⋯ H_m x``."""
    for a in range(m):
        mirror(part(vectors, (m - 1 - a) * len(x), len(x)), x)


@helper
def reflections(n: int, m: int, rows: Any, vectors: Any) -> float:
    """Write the m reflections of m rows of length n; return ``½ log det(C Cᵀ)`` of the rows C.

    The rows are overwritten. Dependent rows give −inf, and reflections that are not finite.
    """
    total = 0.0
    for a in range(m):
        row = part(rows, a * n, n)
        v = part(vectors, a * n, n)
        reflect(a, vectors, row)
        square = row[a] * row[a]
        for i in range(a + 1, n):
            square += row[i] * row[i]
        norm = sqrt(square)
        total += log(norm)
        v_a = row[a] + (norm if row[a] >= 0.0 else -norm)
        factor = 1.0 / sqrt(norm * abs(v_a))
        for i in range(n):
            v[i] = 0.0 if i < a else factor * row[i]
        v[a] = factor * v_a
    return total


@helper
def log_one_plus(x: float) -> float:
    """Return ``log|1 + x|`` to full relative accuracy for small x (Kahan's quotient)."""
    u = 1.0 + x
    return x if u == 1.0 else log(abs(u)) * (x / (u - 1.0)) if abs(x) < 0.5 else log(abs(u))


@helper
def log_det_near_identity(n: int, E: Any) -> float:
    """Return ``log|det(1 + E)|`` and overwrite E: to relative accuracy where E is small.

    Elimination of 1 + E that keeps the ones apart, with diagonal pivots where E is small by its row
    sums and with the largest pivot of the column elsewhere.
    """
    largest = 0.0
    for i in range(n):
        row = 0.0
        for j in range(n):
            row += abs(E[i * n + j])
        largest = row if row > largest or row != row else largest
    if not largest < 0.5:
        return log_det(n, E)
    total = 0.0
    for k in range(n):
        pivot = E[k * n + k]
        total += log_one_plus(pivot)
        for i in range(k + 1, n):
            factor = E[i * n + k] / (1.0 + pivot)
            for j in range(k + 1, n):
                E[i * n + j] = E[i * n + j] - factor * E[k * n + j]
    return total


@helper
def log_det(n: int, E: Any) -> float:
    """Return ``log|det(1 + E)|`` by elimination with the largest pivots, and overwrite E."""
    for i in range(n):
        E[i * n + i] = 1.0 + E[i * n + i]
    total = 0.0
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(E[i * n + k]) > abs(E[best * n + k]):
                best = i
        total += log(abs(E[best * n + k]))
        for j in range(k, n):
            above, below = E[k * n + j], E[best * n + j]
            E[k * n + j] = below
            E[best * n + j] = above
        for i in range(k + 1, n):
            factor = E[i * n + k] / E[k * n + k]
            for j in range(k + 1, n):
                E[i * n + j] = E[i * n + j] - factor * E[k * n + j]
    return total
