"""The types of number that functions are compiled for; numba is imported when one is asked for."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, repr=False)
class NumberType:
    """A type of number: the numba types of a number and of blocks of them.

    Attributes
    ----------
    load : callable
        Returns the types of a number, of a block of them, and of a block of what `memory` holds.
    derived : bool
        Whether they are other numbers with their derivatives.
    by_params : bool
        Whether a problem's parameters are such numbers too: have derivatives, or differ by lane.
    by_lane : bool
        Whether each of them has a time and a step of its own.
    """

    name: str
    load: Callable[[], tuple[Any, Any, Any]]
    derived: bool = False
    by_params: bool = False
    by_lane: bool = False

    def __repr__(self) -> str:
        return self.name

    @property
    def number(self):
        """The type of a number."""
        return self.load()[0]

    @property
    def block(self):
        """The type of a block of them."""
        return self.load()[1]

    @property
    def memory(self):
        """The type of a stepper's memory, scratch and saved states."""
        return self.load()[2]

    @property
    def given(self):
        """The type of a block of float64 whatever the numbers are."""
        return SCALAR.block

    @property
    def params(self):
        """The type of a problem's parameters: float64, unless they move with the directions."""
        return self.memory if self.by_params else self.given

    @property
    def coefficients(self):
        """The type of a method's coefficients: float64, but for numbers with a memory of their own."""
        own = self.memory is not self.block and not self.derived
        return self.memory if own else self.given

    @property
    def whole(self):
        """The type of whole numbers."""
        from numba.core import types

        return types.int64

    @property
    def real(self):
        """The type of numbers that are float64 whatever the others are."""
        return SCALAR.number

    @property
    def time(self):
        """The type of times and steps: float64, unless each number has its own."""
        return self.number if self.by_lane else SCALAR.number

    @property
    def in_lanes(self) -> NumberType:
        """The type of eight of them at once."""
        return LANE if self is SCALAR else self


def _scalar() -> tuple[Any, Any, Any]:
    from numba.core import types

    from ..numbers.typing_blocks import SCALAR_BLOCK

    return types.float64, SCALAR_BLOCK, SCALAR_BLOCK


def _lane() -> tuple[Any, Any, Any]:
    from ..numbers.typing_blocks import LANE_BLOCK
    from ..numbers.typing_lanes import LANE_VALUE

    return LANE_VALUE, LANE_BLOCK, LANE_BLOCK


def _extended() -> tuple[Any, Any, Any]:
    from ..numbers.typing_double_double import DD_BLOCK, DD_LANE_BLOCK, DD_LANE_VALUE

    return DD_LANE_VALUE, DD_LANE_BLOCK, DD_BLOCK


@functools.cache
def tangent(directions: int, by_params: bool = False) -> NumberType:
    """Return numbers with so many derivatives beside them: eight, or a multiple."""

    def load() -> tuple[Any, Any, Any]:
        from ..numbers.typing_tangent import tangent_numbers

        number, block = tangent_numbers(directions)
        return number, block, block

    return _derived(f"TANGENT{directions}", load, by_params)


@functools.cache
def tangent_lanes(directions: int, by_params: bool = False) -> NumberType:
    """Return eight numbers with so many derivatives each; memory holds single ones."""

    def load() -> tuple[Any, Any, Any]:
        from ..numbers import typing_tangent

        return typing_tangent.tangent_lanes(directions)

    return _derived(f"TANGENT_LANES{directions}", load, by_params)


@functools.cache
def members(by_params: bool) -> NumberType:
    """Return eight numbers of as many motions, each with its own time, step and perhaps parameters."""
    return NumberType(f"MEMBERS{'_P' if by_params else ''}", _lane, False, by_params, True)


def _derived(name: str, load: Callable[[], tuple[Any, Any, Any]], by_params: bool) -> NumberType:
    return NumberType(f"{name}{'_P' if by_params else ''}", load, True, by_params)


SCALAR = NumberType("SCALAR", _scalar)
LANE = NumberType("LANE", _lane)
EXTENDED = NumberType(
    "EXTENDED", _extended
)  # eight double-double numbers; memory holds single ones
