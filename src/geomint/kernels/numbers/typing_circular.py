"""The numba half of sine and cosine."""

import math
from typing import Any

from numba import njit
from numba.core import types
from numba.extending import overload

from . import circular
from .arithmetic import top
from .circular import FAR
from .typing_lanes import LANE_VALUE, LANES, extract_lane, insert_lane

_turned: Any = njit(forceinline=True)(circular.turned)


def _overload(function, of_library, quarters: float) -> None:
    def one(x):
        return _turned(x, quarters) if abs(x) <= FAR else of_library(x)

    # Symbols are made of names, and must differ for sine and cosine (`compile._unique` says why).
    one.__qualname__ = f"{function.__name__}_of_one"
    single = njit(one)

    def eight(x):
        if top(abs(x)) <= FAR:
            return _turned(x, quarters)
        for i in range(LANES):
            x = insert_lane(x, i, single(extract_lane(x, i)))
        return x

    eight.__qualname__ = f"{function.__name__}_of_eight"
    lanes = njit(eight)

    @overload(function)
    def choose(x):
        if x == LANE_VALUE:
            return lambda x: lanes(x)
        return (lambda x: single(float(x))) if isinstance(x, types.Float | types.Integer) else None


_overload(circular.sin, math.sin, 0.0)
_overload(circular.cos, math.cos, 1.0)
