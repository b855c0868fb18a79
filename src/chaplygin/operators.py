"""Symmetric operators on so(n) inside of recorded functions: how they are stored and applied.

An operator is stored in the parameters as its n(n−1)/2 diagonal entries in the basis E_i∧E_j, or as
a matrix row after row; which of them is decided once, when a problem is made.
"""

import functools
from typing import Any

import geomint as gi

from .inertia import GeneralInertia, Inertia
from .manifold import Array, triangle_rows


def operator_entries(inertia: Inertia) -> tuple[bool, Array]:
    """Return whether the operator is stored as a matrix, and its entries."""
    if inertia.diagonal is not None:
        return False, inertia.diagonal
    assert isinstance(inertia, GeneralInertia)
    return True, inertia.matrix.reshape(-1)


@functools.cache
def operator_applied(full: bool, n: int) -> Any:
    """Return ``f(entries, w, out)``, which writes 𝓘w for the operator of those entries."""
    size = triangle_rows(n)

    def diagonal_operator(entries: Any, w: Any, out: Any) -> None:
        for i in range(size):
            out[i] = entries[i] * w[i]

    def full_operator(entries: Any, w: Any, out: Any) -> None:
        for r in range(size):
            total = entries[r * size] * w[0]
            for c in range(1, size):
                total += entries[r * size + c] * w[c]
            out[r] = total

    return gi.helper(full_operator if full else diagonal_operator)
