"""What numba would compile in, from sources that nobody can see: refused.

A function that numba has compiled by itself (``njit``, ``vectorize``, an overload, an intrinsic, a
``jitclass``) keeps the values that its globals had then, for every type of argument those of another
moment. numba's own, of which the version is known, and those of geomint's numbers are welcome.
"""

from collections.abc import Iterable
from types import FunctionType
from typing import Any

from numba.core import types
from numba.core.errors import NumbaError

from ...errors import DomainError
from ..numba_inside import has_type, source_of, templates_of
from .contents import content_of, home_of
from .fingerprint import COMPILER
from .recorded import Recorded

__all__ = ["NumbaError", "refuse_compiled", "refuse_foreign", "refuse_modules"]

OWN = ("numba.", "llvmlite.", *COMPILER)
HELPER = "a function recorded by geomint.helper"
VALUES = "numbers, strings, numpy arrays, tuples of them, modules, or recorded functions"


def refuse_compiled(recorded: Recorded) -> None:
    """Raise `DomainError` if the function reaches what numba has compiled by itself."""
    for place, value in recorded.reach.compiled:
        if value is getattr or value is hasattr:
            raise DomainError(place, value, "module.name, where a module is meant")
        raise DomainError(place, value, f"{HELPER}: numba keeps what a function saw when compiled")


def refuse_foreign(recorded: Recorded) -> None:
    """Raise `DomainError` if numba would compile what the function's fingerprint does not see."""
    for place, value in recorded.reach.others:
        templates = templates_of(value)
        if templates is not None:
            if templates and not any(map(_is_own, templates)):
                raise DomainError(place, value, f"{HELPER}, not an implementation for numba")
        elif not isinstance(value, FunctionType | type) and has_type(value):
            raise DomainError(place, value, VALUES)


def _is_own(template) -> bool:
    """Tell whether an implementation of a function is numba's or geomint's own."""
    homes = [home_of(f) for f in _with_closure(source_of(template))]
    return all(f"{home}.".startswith(OWN) for home in homes or [template.__module__])


def _with_closure(function) -> list[FunctionType]:
    """Return a function and those that it closes over: what `register_jitable` is given is there."""
    if not isinstance(function, FunctionType):
        return []
    inside = [content_of(cell) for cell in function.__closure__ or ()]
    return [function, *(f for f in inside if isinstance(f, FunctionType))]


def refuse_modules(recorded: Recorded, types_given: Iterable[Any]) -> None:
    """Raise `DomainError` if a function is given a module.

    numba compiles a function once for each type, and a module's type does not say what is in it.
    """
    for given in types_given:
        if isinstance(given, types.Module):
            place = f"an argument of {recorded.function.__qualname__}"
            raise DomainError(place, given.pymod, "no module: what is read from it")
        if isinstance(given, types.BaseTuple):
            inner: Any = given
            refuse_modules(recorded, inner)
