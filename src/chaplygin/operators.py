"""Symmetric operators on so(n) inside of recorded functions: how they are stored and applied.

An operator is stored in the parameters as its n(n−1)/2 diagonal entries in the basis E_i∧E_j, or as
a matrix row after row; which of them is decided once, when a problem is made. What they write goes
to parts of the scratch.
"""

import functools
from typing import Any

import geomint as gi
from geomint import part

from .inertia import GeneralInertia, Inertia
from .manifold import Array, triangle_rows


@gi.helper
def after(block, row):
    """Return the part of a block from a row on."""
    return part(block, row, len(block) - row)


@gi.helper
def in_two(work, size):
    """Return two parts of so many rows, and what is left of the scratch."""
    return part(work, 0, size), part(work, size, size), after(work, 2 * size)


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

    def diagonal_operator(entries, w, out):
        for i in range(size):
            out[i] = entries[i] * w[i]

    def full_operator(entries, w, out):
        for r in range(size):
            total = entries[r * size] * w[0]
            for c in range(1, size):
                total += entries[r * size + c] * w[c]
            out[r] = total

    return gi.helper(full_operator if full else diagonal_operator)
