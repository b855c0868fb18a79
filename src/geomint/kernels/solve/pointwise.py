"""A function at many points."""

from __future__ import annotations

import functools
from typing import Any

from ..compiling.bound import Bound
from ..compiling.recorded import Recorded, helper
from ..compiling.signatures import BLOCK, WHOLE, takes
from ..numbers.blocks import part

__all__ = ["pointwise_sweep"]

SWEEP = takes(
    params=BLOCK, points=BLOCK, width=WHOLE, out=BLOCK, rows=WHOLE, count=WHOLE, work=BLOCK
)


@functools.cache
def pointwise_sweep(f: Recorded) -> Bound:
    """Return the function that writes ``f(params, 0, x, out, work)`` for many points x.

    `f` is a part of it: a function given as an argument is unboxed at every call, which takes
    longer (0.1 ms) than most single points.
    """

    def sweep(
        params: Any, points: Any, width: int, out: Any, rows: int, count: int, work: Any
    ) -> None:
        for i in range(count):
            f(params, 0.0, part(points, i * width, width), part(out, i * rows, rows), work)

    return Bound(helper(sweep), SWEEP)
