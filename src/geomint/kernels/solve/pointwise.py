"""A function at many points."""

from __future__ import annotations

from typing import Any

from ..compiling.bound import Bound
from ..compiling.recorded import helper
from ..compiling.signatures import BLOCK, FIELD, WHOLE, takes
from ..numbers.blocks import part

__all__ = ["POINTWISE"]


@helper
def pointwise(
    function: Any, params: Any, points: Any, width: int, out: Any, rows: int, count: int, work: Any
) -> None:
    """Write ``function(params, 0, x, out, work)`` for `count` points x, `width` numbers each."""
    for i in range(count):
        function(params, 0.0, part(points, i * width, width), part(out, i * rows, rows), work)


_POINTWISE = takes(
    function=FIELD,
    params=BLOCK,
    points=BLOCK,
    width=WHOLE,
    out=BLOCK,
    rows=WHOLE,
    count=WHOLE,
    work=BLOCK,
)
POINTWISE = Bound(pointwise, _POINTWISE)
