"""Eight numbers that go through the same arithmetic: the Python half of a *lane value*.

A lane value carries eight float64 numbers; ``+ - * /`` act on all of them at once. Compiled
code holds them in one LLVM ``<8 x double>`` (`geomint.kernels.numbers.typing_lanes`); here, in plain
Python, they are an array. Both give the same bits, and so does float64 arithmetic lane by lane.

The Python half takes any numpy dtype and any count: extended precision references run the
source of a field on `numpy.longdouble` or on `object` arrays of mpmath numbers.
"""

from __future__ import annotations

import numpy as np

LANES = 8
"""Number of float64 numbers in a compiled lane value."""


class Lanes(np.ndarray):
    """An array whose in-place operators make a new array, so that a lane value never changes.

    Compiled lane values are values: after ``b = a``, ``b += 1`` must leave ``a`` alone.
    """

    def __new__(cls, values) -> Lanes:
        return np.array(values, ndmin=1).view(cls)

    def __iadd__(self, other):  # type: ignore[misc]
        return self + other

    def __isub__(self, other):  # type: ignore[misc]
        return self - other

    def __imul__(self, other):  # type: ignore[misc]
        return self * other

    def __itruediv__(self, other):  # type: ignore[misc]
        return self / other
