"""What numba would compile in, though nobody can tell from which source it is: refused.

A function that numba has compiled by itself (``njit``, ``vectorize``, an overload, an intrinsic, a
``jitclass``) keeps the values that its globals had then, for every type of argument those of another
moment. numba's own, of which the version is known, and those of the kernel layer are welcome.
"""

from __future__ import annotations

from types import FunctionType
from typing import Any

from numba.core.registry import cpu_target
from numba.core.typing.typeof import Purpose, typeof

from .fingerprint import KERNELS, home_of
from .recorded import Recorded

__all__ = ["ForeignError", "refuse_foreign"]

OWN = ("numba.", KERNELS + ".")
HELPER = "a function recorded by geomint.helper"
VALUES = "numbers, strings, numpy arrays, tuples of them, modules, or recorded functions"


class ForeignError(TypeError):
    """A function that reaches what geomint cannot follow.

    Attributes
    ----------
    place : str
        By what names.
    value : object
    expected : str
        What would be right.
    """

    def __init__(self, place: str, value: Any, expected: str) -> None:
        super().__init__(f"{place} is {value!r}: expected {expected}")
        self.place, self.value, self.expected = place, value, expected


def refuse_foreign(recorded: Recorded) -> None:
    """Raise a `ForeignError` if numba would compile what the function's fingerprint does not see."""
    for place, value in recorded.reach.compiled:
        raise ForeignError(place, value, f"{HELPER}: numba keeps what a function saw when compiled")
    context = cpu_target.typing_context
    context.refresh()
    for place, value in recorded.reach.others:
        implementation = context._lookup_global(value)
        if implementation is not None:
            templates = getattr(implementation, "templates", ())
            if templates and not any(_is_own(template) for template in templates):
                raise ForeignError(place, value, f"{HELPER}, not an implementation for numba")
        elif not isinstance(value, FunctionType | type) and _has_type(value):
            raise ForeignError(place, value, VALUES)


def _has_type(value: Any) -> bool:
    try:
        return typeof(value, Purpose.constant) is not None
    except Exception:  # whatever an unknown object makes of it
        return False


def _is_own(template: Any) -> bool:
    """Tell whether an implementation of a function is numba's or the kernel layer's."""
    function = vars(template).get("_overload_func")
    if function is not None:
        homes = [home_of(function.__func__)]
    else:
        made = vars(template).get("generic")  # closes over the typing function of `type_callable`
        cells = (made.__closure__ or ()) if isinstance(made, FunctionType) else ()
        inside = [cell.cell_contents for cell in cells]
        homes = [template.__module__, *(home_of(f) for f in inside if isinstance(f, FunctionType))]
    return all(f"{home}.".startswith(OWN) for home in homes)
