"""Double-double numbers: unevaluated sums of two float64, about 32 digits, for reference solutions.

The Python half: packing and unpacking of blocks, and sums of two numbers, which elementary functions
are made of, too. `geomint.kernels.numbers.typing_double_double` makes the same field sources and
kernels compile for eight double-double numbers at a time. A row of a block takes two numbers (hi, lo),
a lane row sixteen: eight hi, then eight lo.

Algorithms: T. J. Dekker, Numer. Math. 18 (1971) 224; D. E. Knuth, TAOCP 2, 4.2.2.
"""

from __future__ import annotations

import numpy as np

from ...arguments import Array
from .arithmetic import fma
from .blocks import Block
from .lanes import LANES


class DoubleDoubleBlock(Block):
    """A block of double-double rows: `data` holds hi and lo in turn."""

    __slots__ = ()

    def __len__(self) -> int:
        return len(self.data) // 2

    def part(self, start: int, rows: int) -> DoubleDoubleBlock:
        """Return `rows` rows from `start` on, sharing memory."""
        return DoubleDoubleBlock(Block(self.data).part(2 * start, 2 * rows).data)


def lane_rows(hi: Array, lo: Array) -> Array:
    """Return numbers of lane rows in memory order: eight hi, eight lo, and so on."""
    pairs = np.stack((hi.reshape(-1, LANES), lo.reshape(-1, LANES)), axis=1)
    return pairs.ravel()


def summed(x, y):
    """Return x + y and what its rounding leaves, for |x| ≥ |y| or x = 0."""
    found = x + y
    return found, (x - found) + y


def multiplied(x, y):
    """Return x y and what its rounding leaves."""
    found = x * y
    return found, fma(x, y, -found)


def divided(x, x_low, y, y_low):
    """Return a quotient of sums of two numbers as such a sum."""
    found = x / y
    return found, ((fma(-found, y, x) + x_low) - found * y_low) / y
