"""Watchers by name: geomint's own, and those that packages register through entry points.

A package registers under ``[project.entry-points."geomint.watchers"]`` a class that inherits from
`geomint.Watcher`, or one of its values, for every name.
"""

import functools
from importlib.metadata import EntryPoint
from typing import Any

from ..arguments import whole
from ..errors import DomainError, loaded, offered
from ..problems.problem import GROUPS
from .kinds import KINDS
from .measure import InvariantMeasure
from .symplectic import SymplecticDefect
from .watcher import Watcher

# What problems have beside their functions: the group ``"all"`` means these as well.
OWN = {w.name: w for w in (InvariantMeasure(), SymplecticDefect())}


@functools.cache
def plugged() -> dict[str, EntryPoint]:
    """Return the watchers of other packages by name; none of them is imported."""
    return offered("geomint.watchers", (*OWN, *GROUPS))


def registered(name: str) -> Watcher | None:
    """Return the watcher of a name, None if there is none.

    Raises
    ------
    MissingCodeError, DomainError
        For an entry point that is broken.
    """
    if name in OWN:
        return OWN[name]
    point = plugged().get(name)
    if point is None:
        return None
    where = f"entry point {name!r} of the group geomint.watchers"
    return checked_watcher(where, loaded(point))


def checked_watcher(where: str, given: Any) -> Watcher:
    """Return a watcher, made if `given` is its class; or raise `DomainError`."""
    if isinstance(given, type) and issubclass(given, Watcher):
        given = given()
    if not isinstance(given, Watcher):
        raise DomainError(where, given, "a geomint.Watcher")
    if given.kind not in KINDS:
        raise DomainError(f"{where}: kind", given.kind, f"one of {list(KINDS)}")
    if given.steps is not None:
        whole(f"{where}: steps", given.steps, 1)
    return given
