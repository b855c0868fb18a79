"""Observables along saved states."""

from __future__ import annotations

from typing import Any

from ..compiling.bound import Bound
from ..compiling.recorded import helper
from ..compiling.signatures import BLOCK, VALUE, WHOLE, takes
from ..numbers.blocks import part

__all__ = ["SAMPLE"]


@helper
def sample(
    value: Any,
    params: Any,
    times: Any,
    states: Any,
    stride: int,
    rows: int,
    count: int,
    work: Any,
    out: Any,
) -> None:
    """Write ``value(params, t, y, work)`` for the first `count` of the states, `stride` rows apart."""
    for i in range(count):
        out[i] = value(params, times[i], part(states, i * stride, rows), work)


_SAMPLE = takes(
    value=VALUE,
    params=BLOCK,
    times=BLOCK,
    states=BLOCK,
    stride=WHOLE,
    rows=WHOLE,
    count=WHOLE,
    work=BLOCK,
    out=BLOCK,
)
SAMPLE = Bound(sample, _SAMPLE)
