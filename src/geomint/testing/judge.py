"""How a property that does not hold is said."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arguments import Array

__all__ = ["hold", "small", "sure"]


def sure(holds: Any, what: str) -> None:
    """Raise `AssertionError` unless it holds."""
    if not holds:
        raise AssertionError(what)


def small(value: Any, most: float, what: str) -> None:
    """Raise `AssertionError` unless the largest number is at most `most`."""
    largest = float(np.max(np.abs(value), initial=0.0))
    sure(largest <= most, f"{what}: by {largest:.3g}, where at most {most:.3g} is rounding")


def hold(left: Array, right: Array, what: str) -> None:
    """Raise `AssertionError` unless both are the same bits."""
    where = int(np.argmax(np.atleast_1d(left != right)))
    sure(np.array_equal(left, right), f"{what}: row {where} is another number")
