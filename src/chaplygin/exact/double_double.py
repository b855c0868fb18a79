"""Arrays of double-double numbers: unevaluated sums of two float64, about 32 digits.

Dekker's and Knuth's exact sums and products, in numpy: many numbers cost hardly more than one, where
arithmetic of any precision takes a microsecond for each.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..manifold import Array

__all__ = ["DoubleDouble"]

SPLITTER = 2.0**27 + 1.0


@dataclass(frozen=True)
class DoubleDouble:
    """high + low, arrays of one shape; |low| ≤ half a unit in the last place of high."""

    high: Array
    low: Array

    @classmethod
    def of(cls, values: Any) -> DoubleDouble:
        """Return numbers of any precision, rounded."""
        high = np.array([float(x) for x in values])
        return cls(
            high, np.array([float(x - y) for x, y in zip(values, high.tolist(), strict=True)])
        )

    @classmethod
    def one(cls, value: Any) -> DoubleDouble:
        """Return a single number of any precision, rounded."""
        high = float(value)
        return cls(np.float64(high), np.float64(float(value - high)))  # type: ignore[arg-type]

    def __add__(self, other: DoubleDouble) -> DoubleDouble:
        high, error = _sum(self.high, other.high)
        low, rest = _sum(self.low, other.low)
        high, error = _ordered_sum(high, error + low)
        return DoubleDouble(*_ordered_sum(high, error + rest))

    def __mul__(self, other: DoubleDouble) -> DoubleDouble:
        product, error = _product(self.high, other.high)
        error = error + (self.high * other.low + self.low * other.high)
        return DoubleDouble(*_ordered_sum(product, error))

    def __getitem__(self, at: Any) -> DoubleDouble:
        """Return some of the numbers along the last axis."""
        return DoubleDouble(self.high[..., at], self.low[..., at])

    def __neg__(self) -> DoubleDouble:
        return DoubleDouble(-self.high, -self.low)

    def scaled(self, power_of_two: float) -> DoubleDouble:
        """Return the numbers times a power of two."""
        return DoubleDouble(self.high * power_of_two, self.low * power_of_two)

    def inverse(self) -> DoubleDouble:
        """Return 1/x by a step of Newton's method, and another for its last bits."""
        start = 1.0 / self.high
        x = DoubleDouble(start, 0.0 * start)
        one = DoubleDouble(1.0 + 0.0 * start, 0.0 * start)
        for _ in range(2):
            x = x + x * (one + -(self * x))
        return x

    def root(self) -> DoubleDouble:
        """Return √x, x > 0: Karp's step."""
        start = 1.0 / np.sqrt(self.high)
        near = self.high * start
        square, error = _product(near, near)
        left = self + DoubleDouble(-square, -error)
        return DoubleDouble(*_sum(near, left.high * (0.5 * start)))

    def total(self) -> DoubleDouble:
        """Return the sum over the last axis."""
        x = self
        while (count := x.high.shape[-1]) > 1:
            half = count // 2
            odd = x[2 * half :]
            x = x[:half] + x[half : 2 * half]
            if count % 2:
                first, rest = x[:1] + odd, x[1:]
                high = np.concatenate([first.high, rest.high], axis=-1)
                x = DoubleDouble(high, np.concatenate([first.low, rest.low], axis=-1))
        return x[0]


def _sum(a: Array, b: Array) -> tuple[Array, Array]:
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def _ordered_sum(a: Array, b: Array) -> tuple[Array, Array]:
    total = a + b
    return total, b - (total - a)


def _product(a: Array, b: Array) -> tuple[Array, Array]:
    product = a * b
    a_high, a_low = _halves(a)
    b_high, b_low = _halves(b)
    return product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


def _halves(a: Array) -> tuple[Array, Array]:
    shifted = SPLITTER * a
    high = shifted - (shifted - a)
    return high, a - high
