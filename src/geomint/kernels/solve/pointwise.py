"""A function at many points."""

from __future__ import annotations

import functools
from typing import Any

from ..compiling.recorded import Recorded, helper
from ..numbers.blocks import part

__all__ = ["pointwise_sweep"]


@functools.cache
def pointwise_sweep(f: Recorded) -> Recorded:
    """Return the function that writes ``f(params, 0, x, out, work)`` for many points x.

    `f` is a part of it: a function given as an argument is unboxed at every call, which takes
    longer (0.1 ms) than most single points.
    """

    def sweep(
        params: Any, points: Any, width: int, out: Any, rows: int, count: int, work: Any
    ) -> None:
        for i in range(count):
            f(params, 0.0, part(points, i * width, width), part(out, i * rows, rows), work)

    return helper(sweep)
