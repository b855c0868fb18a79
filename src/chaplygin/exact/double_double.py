"""Compiled: double-double numbers, unevaluated sums (high, low) of two float64, about 32 digits.

Dekker's and Knuth's exact sums and products; in blocks they lie side by side.
"""

import geomint as gi


@gi.helper
def load(block, i):
    """Return the number i of a block."""
    return block[2 * i], block[2 * i + 1]


@gi.helper
def added(x, y):
    """Return x + y."""
    total, low = x[0] + y[0], x[1] + y[1]
    part, low_part = total - x[0], low - x[1]
    error = (x[0] - (total - part)) + (y[0] - part) + low
    rest = (x[1] - (low - low_part)) + (y[1] - low_part)
    high = total + error
    rest += error - (high - total)
    total = high + rest
    return total, rest - (total - high)


@gi.helper
def negative(x):
    """Return −x."""
    return -x[0], -x[1]


@gi.helper
def times(x, y):
    """Return xy."""
    product = x[0] * y[0]
    error = gi.fma(x[0], y[0], -product) + (x[0] * y[1] + x[1] * y[0])
    total = product + error
    return total, error - (total - product)


@gi.helper
def inverse_root(x):
    """Return 1/√x, x > 0: two of Newton's steps, the second for the last bits."""
    y = (1.0 / gi.sqrt(x[0]), 0.0)
    for _ in range(2):
        left = added((1.0, 0.0), negative(times(x, times(y, y))))
        y = added(y, times(y, (0.5 * left[0], 0.5 * left[1])))
    return y
