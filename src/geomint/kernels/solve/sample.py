"""Observables along saved states, and functions at many points."""

from __future__ import annotations

from typing import Any

from ..compiling.bound import Bound
from ..compiling.recorded import helper
from ..compiling.signatures import BLOCK, FIELD, WHOLE, takes
from ..numbers.blocks import part

__all__ = ["SAMPLE"]


@helper
def sample(
    values: Any,
    params: Any,
    times: Any,
    states: Any,
    stride: int,
    rows: int,
    count: int,
    work: Any,
    out: Any,
    width: int,
) -> None:
    """Write what `values` writes, `width` numbers, for `count` states, `stride` rows apart."""
    for i in range(count):
        y, row = part(states, i * stride, rows), part(out, i * width, width)
        values(params, times[i], y, row, work)


_SAMPLE = takes(
    values=FIELD,
    params=BLOCK,
    times=BLOCK,
    states=BLOCK,
    stride=WHOLE,
    rows=WHOLE,
    count=WHOLE,
    work=BLOCK,
    out=BLOCK,
    width=WHOLE,
)
SAMPLE = Bound(sample, _SAMPLE)
