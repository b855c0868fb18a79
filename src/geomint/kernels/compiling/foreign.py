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
from numba.core.registry import cpu_target
from numba.core.typing.typeof import Purpose, typeof

from ...errors import DomainError
from .contents import content_of, home_of
from .fingerprint import COMPILER
from .recorded import Recorded

__all__ = ["NumbaError", "refuse_compiled", "refuse_foreign", "refuse_modules"]

OWN = ("numba.", *COMPILER)
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
    context = cpu_target.typing_context
    context.refresh()
    for place, value in recorded.reach.others:
        implementation = context._lookup_global(value)
        if implementation is not None:
            templates = getattr(implementation, "templates", ())
            if templates and not any(_is_own(template) for template in templates):
                raise DomainError(place, value, f"{HELPER}, not an implementation for numba")
        elif not isinstance(value, FunctionType | type) and _has_type(value):
            raise DomainError(place, value, VALUES)


def _has_type(value) -> bool:
    try:
        return typeof(value, Purpose.constant) is not None
    except Exception:  # whatever an unknown object makes of it
        return False


def _is_own(template) -> bool:
    """Tell whether an implementation of a function is numba's or geomint's own."""
    of = vars(template)
    function = of.get("_overload_func") or of.get("_definition_func") or of.get("generic")
    functions = _with_closure(getattr(function, "__func__", function))
    homes = [home_of(f) for f in functions]
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
