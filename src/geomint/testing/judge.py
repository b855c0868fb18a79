"""How a property that does not hold is said."""

import functools
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np

from ..arguments import Array
from ..errors import DomainError, GeomintError, GeomintWarning, quoted, raised

__all__ = ["checks", "hold", "small", "sure"]

Check = TypeVar("Check", bound=Callable[..., None])


def checks(kind: type) -> Callable[[Check], Check]:
    """Say of a check what its first argument is, and let it name what a user's functions raise."""

    def made(check: Check) -> Check:
        @functools.wraps(check)
        def checked(value: Any, *args: Any, **options: Any) -> None:
            if not isinstance(value, kind):
                raise DomainError(kind.__name__.lower(), value, f"a geomint.{kind.__name__}")
            try:
                check(value, *args, **options)
            except (AssertionError, GeomintError, GeomintWarning):
                raise
            except Exception as error:  # whatever a user's functions raise
                what = raised(error)
                raise AssertionError(f"{what}, by a function of {quoted(value)}") from error

        return cast(Check, checked)

    return made


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
