"""Recorded functions as machine code, with the errors that users are to see."""

from __future__ import annotations

from typing import Any

from ..errors import DomainError
from ..kernels.recorded import Recorded

__all__ = ["compiled"]


def compiled(function: Recorded, signature: Any) -> Any:
    """Return a function compiled for a signature: found, or made if it is new or reaches new values.

    Every run begins with this for each of its functions, and holds what it got.

    Raises
    ------
    DomainError
        If the function reaches what numba has compiled by itself, or objects of unknown content.
    """
    from ..kernels.compile import compile_function
    from ..kernels.foreign import ForeignError

    try:
        return compile_function(function, signature)
    except ForeignError as error:
        raise DomainError(error.place, error.value, error.expected) from None
