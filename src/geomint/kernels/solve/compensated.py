"""Sums that keep what rounding loses."""

from __future__ import annotations

from typing import Any

from ..compiling.recorded import helper

__all__ = ["add_compensated"]


@helper
def add_compensated(state: Any, carry: Any, row: int, increment: Any) -> None:
    """Add `increment` to ``state[row] + carry[row]``, an unevaluated sum (Knuth's TwoSum).

    The rounded sum goes to `state`, the rest to `carry`; both are blocks of any kind.
    """
    y = state[row]
    z = carry[row] + increment
    s = y + z
    shadow = s - y
    carry[row] = (y - (s - shadow)) + (z - shadow)
    state[row] = s
