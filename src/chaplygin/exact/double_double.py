"""Compiled: double-double numbers, unevaluated sums (high, low) of two float64, about 32 digits.

Dekker's and Knuth's exact sums and products; in blocks they lie side by side.
"""

from __future__ import annotations

from typing import Any

import geomint as gi

__all__ = ["added", "divided", "inverse_root", "load", "negative", "store", "times"]


@gi.helper
def load(block: Any, i: int) -> Any:
    """Return the number i of a block."""
    return block[2 * i], block[2 * i + 1]


@gi.helper
def store(block: Any, i: int, x: Any) -> None:
    """Write the number i of a block."""
    block[2 * i], block[2 * i + 1] = x[0], x[1]


@gi.helper
def ordered_sum(high: Any, low: Any) -> Any:
    """Return the exact sum of two float64, the first of which is the larger one."""
    total = high + low
    return total, low - (total - high)


@gi.helper
def added(x: Any, y: Any) -> Any:
    """Return x + y."""
    total = x[0] + y[0]
    part = total - x[0]
    error = (x[0] - (total - part)) + (y[0] - part)
    low = x[1] + y[1]
    part = low - x[1]
    rest = (x[1] - (low - part)) + (y[1] - part)
    high = ordered_sum(total, error + low)
    return ordered_sum(high[0], high[1] + rest)


@gi.helper
def negative(x: Any) -> Any:
    """Return −x."""
    return -x[0], -x[1]


@gi.helper
def times(x: Any, y: Any) -> Any:
    """Return xy."""
    product = x[0] * y[0]
    error = gi.fma(x[0], y[0], -product)
    return ordered_sum(product, error + (x[0] * y[1] + x[1] * y[0]))


@gi.helper
def divided(x: Any, y: Any) -> Any:
    """Return x/y: three digits of long division."""
    first = x[0] / y[0]
    rest = added(x, negative(times(y, (first, 0.0))))
    second = rest[0] / y[0]
    rest = added(rest, negative(times(y, (second, 0.0))))
    high = ordered_sum(first, second)
    return added(high, (rest[0] / y[0], 0.0))


@gi.helper
def inverse_root(x: Any) -> Any:
    """Return 1/√x, x > 0: two of Newton's steps, the second for the last bits."""
    y = (1.0 / gi.sqrt(x[0]), 0.0)
    for _ in range(2):
        left = added((1.0, 0.0), negative(times(x, times(y, y))))
        y = added(y, times(y, (0.5 * left[0], 0.5 * left[1])))
    return y
