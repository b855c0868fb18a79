"""Which rows of a state conditions depend on: gradients are 0 elsewhere."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

from ..compiling.recorded import inlined
from ..numbers.blocks import sections
from .layout import Sizes, pieces_of

__all__ = ["Supports", "supports_of"]

# Of a condition: the rows from `lows` to `ends` that it and those that share rows with it depend on;
# the row among them that its reflection leads to. Rows that none leads to; the most rows of one.
Supports = namedtuple("Supports", "pieces lows pivots ends free most")


@inlined
def supports_of(given: Any, s: Sizes) -> Supports:
    """Return the parts of what a sweep is given of them, after the numbers of pieces."""
    layout = Supports(pieces=s.n, lows=s.m, pivots=s.m, ends=s.m, free=s.d, most=1)
    return sections(pieces_of(given), layout)
