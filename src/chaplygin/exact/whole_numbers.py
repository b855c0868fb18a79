"""Numbers of more digits than a float64 has, as whole numbers of Python.

Whole numbers have as many digits as it takes, and nothing is rounded but where one says so: float64 are
such numbers over a power of two, and so is what is made of them without a division. A product of two
with a hundred digits takes a tenth of a microsecond.

What compiled code takes of them are *double-doubles*, unevaluated sums of two float64 with 32 digits.
"""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from ..manifold import Array

DoubleDouble = tuple[float, float]
BITS = 160  # of what is rounded: a double-double has 106, and a few are lost


def whole_over(values: Iterable[float]) -> tuple[list[int], int]:
    """Return whole numbers x and the least s ≥ 0 with which the values are x/2^s."""
    ratios = [float(value).as_integer_ratio() for value in values]
    bits = max(below.bit_length() for _, below in ratios) - 1
    return [above << (bits - below.bit_length() + 1) for above, below in ratios], bits


def double_double(above: int, below: int) -> DoubleDouble:
    """Return above/below, rounded: a quotient of whole numbers is rounded once, whatever their size."""
    high = above / below
    over, under = high.as_integer_ratio()
    return high, (above * under - over * below) / (below * under)


def root_of_quotient(above: int, below: int) -> DoubleDouble:
    """Return √(above/below) of numbers that are not negative, rounded."""
    shift = max(0, 2 * BITS + below.bit_length() - above.bit_length()) // 2
    return double_double(math.isqrt((above << 2 * shift) // below), 1 << shift)


def whole_of(numbers: Array) -> tuple[Any, int]:
    """Return double-doubles as x/2^s, shape (..., 2) ↦ nested lists of whole x of shape (...)."""
    flat, bits = whole_over(numbers.reshape(-1).tolist() or [0.0])
    sums = [high + low for high, low in zip(flat[::2], flat[1::2], strict=False)]
    return np.array([*sums, None], dtype=object)[:-1].reshape(numbers.shape[:-1]).tolist(), bits


def eliminated(matrix: list[list[int]]) -> int:
    """Make the first columns of a matrix diagonal, in place; return what is on the diagonal.

    Bareiss' elimination: minors take the place of entries, and every quotient is a whole number. 0 for
    a singular matrix.
    """
    before = 1
    for c, row in enumerate(matrix):
        best = max(range(c, len(matrix)), key=lambda r: abs(matrix[r][c]))
        matrix[c], matrix[best] = matrix[best], row
        pivot = matrix[c]
        if pivot[c] == 0:
            return 0
        for r, other in enumerate(matrix):
            if r != c:
                factor = other[c]
                matrix[r] = [
                    (pivot[c] * x - factor * y) // before for x, y in zip(other, pivot, strict=True)
                ]
        before = pivot[c]
    return before
