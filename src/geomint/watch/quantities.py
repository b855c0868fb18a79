"""Names of quantities: what they stand for, their groups, and their kinds."""

from __future__ import annotations

from collections.abc import Iterable

from ..errors import DomainError, nearest
from ..problems.problem import Problem
from .functions import diagnostic
from .kinds import KINDS, Kind
from .registry import OWN, plugged, registered
from .watcher import Watcher

__all__ = [
    "GROUPS",
    "KINDS",
    "Kind",
    "expanded",
    "has_quantity",
    "kind_of",
    "quantities_of",
    "watcher_of",
]

GROUPS = ("invariants", "constraints", "observables", "all")


def quantities_of(problem: Problem) -> list[str]:
    """Return the names of what a problem has of its own: what the group ``"all"`` stands for."""
    own = [name for name, watcher in OWN.items() if not watcher.obstacle(problem)]
    return list(dict.fromkeys([*problem.diagnostics, *own]))


def has_quantity(problem: Problem, name: str) -> bool:
    """Tell whether something of that name can be watched along runs of a problem."""
    watcher = diagnostic(problem, name) or registered(name)
    return watcher is not None and not watcher.obstacle(problem)


def watcher_of(problem: Problem, name: str) -> Watcher:
    """Return what watches a quantity: the problem's own first, then what is registered.

    Raises
    ------
    DomainError
        For a name that is not known, and for a watcher that the problem does not allow.
    """
    watcher = diagnostic(problem, name) or registered(name)
    if watcher is None:
        known = [*quantities_of(problem), *GROUPS, *plugged()]
        raise DomainError("observe", name, f"a quantity of the problem.{nearest(name, known)}")
    obstacle = watcher.obstacle(problem)
    if obstacle:
        raise DomainError("observe", name, f"one of {quantities_of(problem)}: {obstacle}")
    return watcher


def kind_of(name: str, *problems: Problem) -> str:
    """Return the kind, a key of `KINDS`, of a quantity that one of the problems has."""
    kinds = {watcher_of(p, name).kind for p in problems if has_quantity(p, name)}
    return next((kind for kind in KINDS if kind in kinds), "others")


def expanded(problem: Problem, wanted: Iterable[str]) -> Iterable[str]:
    """Yield the names of quantities, those of `GROUPS` in place of these."""
    for name in wanted:
        if name == "all":
            yield from quantities_of(problem)
        elif name in GROUPS:
            yield from getattr(problem, name)
        else:
            yield name
