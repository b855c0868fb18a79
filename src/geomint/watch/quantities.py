"""Names of quantities: what they stand for, their groups, and their kinds."""

from collections.abc import Iterable

from ..errors import DomainError, nearest
from ..problems.problem import GROUPS, Problem
from .functions import ENERGY, Function
from .kinds import KINDS
from .registry import OWN, plugged, registered
from .watcher import Watcher


def quantities_of(problem: Problem) -> list[str]:
    """Return the names of what a problem has of its own: what the group ``"all"`` stands for."""
    own = [name for name, w in OWN.items() if w.in_all and not w.obstacle(problem)]
    return list(dict.fromkeys([*problem.diagnostics, *own]))


def find_watcher(problem: Problem, name: str) -> Watcher | None:
    """Return what watches a quantity, None if the problem has none of that name.

    Its own functions come before watchers that are registered.
    """
    if name in problem.invariants:
        return Function(problem.invariants[name], "energy" if name == ENERGY else "integrals")
    if name in problem.constraints:
        return Function(problem.constraints[name], "constraints")
    if name in problem.observables:
        return Function(problem.observables[name])
    watcher = registered(name)
    return None if watcher is None or watcher.obstacle(problem) else watcher


def watcher_of(problem: Problem, name: str) -> Watcher:
    """Return what watches a quantity.

    Raises
    ------
    DomainError
        For a name that is not known, and for a watcher that the problem does not allow.
    """
    watcher = find_watcher(problem, name)
    if watcher is None:
        own, other = quantities_of(problem), registered(name)
        close = nearest(name, [*own, *GROUPS, *plugged()])
        expected = f"a quantity of the problem.{close}"
        if other is not None:
            known = f"one of {own}" if own else "another name"
            expected = f"{known}: {other.obstacle(problem)}"
        raise DomainError("observe", name, expected)
    return watcher


def kind_of(name: str, *problems: Problem) -> str:
    """Return the kind, a key of `KINDS`, of a quantity that one of the problems has."""
    found = (find_watcher(problem, name) for problem in problems)
    kinds = {watcher.kind for watcher in found if watcher is not None}
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
