"""Exact coefficients: text to rationals, rationals to the nearest float64.

A coefficient enters the package once, as text, and becomes a `fractions.Fraction` without any
rounding. Binary numbers are made from it at the very end: ``x_float`` is the float64 nearest to x.
"""

from collections.abc import Iterable
from dataclasses import fields
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arguments import Array
from ..errors import ArgumentError, DomainError, MethodError

__all__ = ["Array", "Exact", "Row", "nearest", "read_only", "row", "rows"]

Row = tuple[Fraction, ...]
"""Coefficients of one row of a tableau."""


def row(text: str, length: int = 0) -> Row:
    """Read coefficients separated by blanks.

    Parameters
    ----------
    text : str
        Rationals ("1/6"), integers or decimals ("0.25", "-8.5e-2").
    length : int
        Pad with zeros on the right up to this many coefficients.

    Returns
    -------
    tuple of Fraction
        Equal to the text exactly.

    Examples
    --------
    >>> from geomint.tableaux import row
    >>> row("1/2 0.25", length=3)
    (Fraction(1, 2), Fraction(1, 4), Fraction(0, 1))
    """
    try:
        read = tuple(Fraction(word) for word in text.split())
    except (AttributeError, ValueError, ZeroDivisionError):
        expected = "rationals with blanks between, such as '1/2 0.25'"
        raise DomainError("coefficients", text, expected) from None
    return read + (Fraction(0),) * (length - len(read))


def rows(*texts: str) -> tuple[Row, ...]:
    """Read a square matrix, one text per row; zeros at the end of a row may be left out.

    Examples
    --------
    >>> from geomint.tableaux import rows
    >>> rows("", "1/2")
    ((Fraction(0, 1), Fraction(0, 1)), (Fraction(1, 2), Fraction(0, 1)))
    """
    return tuple(row(text, length=len(texts)) for text in texts)


def nearest(values: Iterable[Fraction]) -> Array:
    """Return the float64 numbers nearest to `values`, shape (n,)."""
    return read_only([float(value) for value in values])


def read_only(values: ArrayLike) -> Array:
    """Return an array of `values` that is C-contiguous, and read-only because it is shared."""
    array = np.array(values, np.float64, order="C")
    array.setflags(write=False)
    return array


class Exact:
    """A frozen dataclass of exact coefficients, of which only these are pickled.

    Binary coefficients, which are read-only and shared, are made again.
    """

    def __post_init__(self) -> None:
        """Check what was given; values of wrong kinds, and coefficients that fit nothing, are typed."""
        try:
            self._check()
        except ValueError as error:
            raise MethodError(str(error)) from None
        except (TypeError, AttributeError, ArithmeticError) as error:
            raise ArgumentError(f"{type(self).__name__}: {error}") from error

    def _check(self) -> None:
        """Check types, shapes and sums."""

    def __getstate__(self) -> dict[str, Any]:
        return {each.name: getattr(self, each.name) for each in fields(self)}  # type: ignore[arg-type]
