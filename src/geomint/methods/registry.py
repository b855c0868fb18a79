"""Methods by name."""

import functools
from collections.abc import Mapping
from importlib.metadata import EntryPoint
from typing import Any

from ..errors import MOST_NAMES, MethodError, closest, loaded, nearest, offered, quoted
from ..problems.problem import Problem
from ..tableaux import (
    COMMUTATOR_FREE,
    COMPOSITIONS,
    DEFAULT_COMPOSITION,
    MAX_LOBATTO_STAGES,
    RUNGE_KUTTA,
)
from .adaptive import Adaptive
from .commutator_free import CommutatorFree
from .composition import Compose
from .exact import NO_STEPS, Exact
from .explicit import RungeKutta
from .gauss import Gauss
from .lobatto import Lobatto
from .method import FITTING, Method, checked_method
from .rattle import Rattle
from .rkmk import RKMK
from .splitting import Verlet

_EXACT = Exact()
DEFAULT = "gauss-8"
AUTO = "auto"  # a method that a tolerance chooses
_FAMILIES = ("rattle", "verlet")  # of order 2, and by its number that of the best composition
_MOST_SCHEMES = 4  # each raises the order, and none of them goes beyond 10


@functools.cache
def methods() -> dict[str, Method]:
    """Return all named methods: the tableaux', implicit ones, splittings, those of entry points.

    Any symmetric method with the name of a composition appended, such as
    ``gauss-1-suzuki-4``, is a method too.
    """
    own: list[Method] = [RungeKutta(name) for name in RUNGE_KUTTA]
    own += [RKMK(name) for name in RUNGE_KUTTA]
    own += [RKMK(name, "cayley") for name in RUNGE_KUTTA]
    for name in (name for name, table in RUNGE_KUTTA.items() if table.b_hat is not None):
        own += [Adaptive(RungeKutta(name)), Adaptive(RKMK(name)), Adaptive(RKMK(name, "cayley"))]
    own += [CommutatorFree(name) for name in COMMUTATOR_FREE]
    own += [Gauss(s) for s in range(1, 17)]
    own += [Lobatto(s) for s in range(3, MAX_LOBATTO_STAGES + 1)]
    for base in (Rattle(), Verlet()):
        own += [base, *(Compose(base, order) for order in DEFAULT_COMPOSITION)]
    found = {method.name: method for method in own}

    def method_of(point: EntryPoint) -> dict[str, Method]:
        method = checked_method("entry point", loaded(point))
        if method.name != point.name:
            raise MethodError(f"its name is {method.name!r}")
        if _parts(method.name, found)[1]:
            raise MethodError("geomint composes a method of that name")
        return {method.name: method}

    names = [*found, _EXACT.name, AUTO]
    return found | offered("geomint.methods", names, method_of, "a geomint.Method of that name")


def method_names() -> list[str]:
    """Return the names of all methods, compositions by suffix aside."""
    return list(methods())


def find_solver(name: str | Method | None, problem: Any = None) -> Method:
    """Return what solves a problem: a method, the exact flow among them.

    For None it is the first of those that fit the first form of the problem (`FITTING`): gauss-8 for
    fields, and where no problem is given.
    """
    if name is None:
        other = isinstance(problem, Problem) and problem.field is None
        name = FITTING[problem.forms[0]].split(",")[0] if other else DEFAULT
    return _EXACT if _is_exact(name) else find_method(name)


def _is_exact(name: Any) -> bool:
    return name == _EXACT.name if isinstance(name, str) else isinstance(name, Exact)


def find_method(name: str | Method) -> Method:
    """Return the method of that name, or raise `MethodError` saying what may have been meant.

    A method takes steps: ``"exact"``, which takes none, is for `geomint.solve` and
    `geomint.poincare_section`.
    """
    if _is_exact(name):
        raise MethodError(f"method = {quoted(name)}: it {NO_STEPS}")
    if not isinstance(name, str):
        return checked_method("method", name, "a name or a geomint method")
    known = methods()
    if name in known:
        return known[name]
    base, schemes = _parts(name, known)
    if base not in known:
        raise MethodError(f"method = {quoted(name)}: no such method.{_hint(name, known)}")
    method = known[base]
    for scheme in reversed(schemes):
        method = Compose(method, scheme)
    return method


def _parts(name: str, known: Mapping[str, Method]) -> tuple[str, list[str]]:
    """Return which known method a name begins with, and what it is composed by, the last first."""
    base, schemes = name, list[str]()
    while base not in known and (scheme := _last_scheme(base)) and len(schemes) < _MOST_SCHEMES:
        base = base.removesuffix(f"-{scheme}")
        schemes.append(scheme)
        base = f"{base}-2" if base in _FAMILIES else base
    return (base, schemes) if base in known else (name, [])


def _hint(name: str, known: Mapping[str, Method]) -> str:
    """Return what may have been meant: of a family without a number its default, and its members."""
    stem = name.casefold()
    if not any(map(str.isdigit, name)) and (close := closest(name, known)):
        stem = close.rpartition("-")[0]
    family = [other for other in known if other.startswith(f"{stem}-")] if stem else []
    if not family:
        return nearest(name, [*known, _EXACT.name], "`geomint methods`")
    usual = DEFAULT if DEFAULT in family else family[0]
    return f" Did you mean {usual!r}? The family: {', '.join(family[:MOST_NAMES])}."


def _last_scheme(name: str) -> str:
    """Return the composition that a method's name ends in, or an empty string."""
    return next((scheme for scheme in COMPOSITIONS if name.endswith(f"-{scheme}")), "")
