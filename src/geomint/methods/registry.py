"""Methods by name."""

from __future__ import annotations

import functools
from importlib.metadata import entry_points

from ..errors import MethodError, nearest, quoted
from ..tableaux import COMMUTATOR_FREE, COMPOSITIONS, RUNGE_KUTTA
from .commutator_free import CommutatorFree
from .composition import Compose
from .explicit import RungeKutta
from .gauss import Gauss
from .method import Method
from .rattle import Rattle
from .rkmk import RKMK
from .splitting import Verlet

__all__ = ["find_method", "method_names", "methods"]

_FAMILIES = ("rattle", "verlet")  # of order 2, and by its number that of the best composition


@functools.cache
def methods() -> dict[str, Method]:
    """Return all named methods: the tableaux', Gauss, RATTLE, Verlet, and those of entry points.

    Any symmetric method with the name of a composition appended, such as
    ``gauss-1-suzuki-4``, is a method too.
    """
    named = [RungeKutta(name) for name in RUNGE_KUTTA]
    named += [RKMK(name) for name in RUNGE_KUTTA]
    named += [RKMK(name, coordinates="cayley") for name in RUNGE_KUTTA]
    for name in (name for name, table in RUNGE_KUTTA.items() if table.b_hat is not None):
        named += [RungeKutta(name, adaptive=True), RKMK(name, adaptive=True)]
        named += [RKMK(name, coordinates="cayley", adaptive=True)]
    named += [CommutatorFree(name) for name in COMMUTATOR_FREE]
    named += [Gauss(s) for s in range(1, 17)]
    named += [Rattle(), Verlet()]
    found = {method.name: method for method in named}
    for family in _FAMILIES:
        for order in (4, 6, 8, 10):
            name = f"{family}-{order}"
            found[name] = _named(Compose(found[f"{family}-2"], order), name)
    for point in entry_points(group="geomint.methods"):
        found[point.name] = _named(point.load(), point.name)
    return found


def _named(method: Method, name: str) -> Method:
    from dataclasses import replace

    return replace(method, name=name)


def method_names() -> list[str]:
    """Return the names of all methods, compositions by suffix aside."""
    return list(methods())


def _base(name: str) -> Method:
    """Return the method that a composition is made of; compositions of compositions there are none."""
    full = f"{name}-2" if name in _FAMILIES else name
    if full not in methods() and any(full.endswith(f"-{suffix}") for suffix in COMPOSITIONS):
        raise MethodError(f"method = {quoted(name)}: a composition cannot be composed again")
    return find_method(full)


def find_method(name: str | Method) -> Method:
    """Return the method of that name, or raise `MethodError` saying what may have been meant."""
    if isinstance(name, Method):
        return name
    if not isinstance(name, str):
        raise MethodError(f"method = {quoted(name)}: expected a name or a geomint method")
    known = methods()
    if name in known:
        return known[name]
    for composition in COMPOSITIONS:
        base = name.removesuffix(f"-{composition}")
        if base != name:
            return Compose(_base(base), composition)
    hint = nearest(name, known, "`geomint methods`")
    raise MethodError(f"method = {quoted(name)}: no such method.{hint}")
