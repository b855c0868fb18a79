"""Warnings as values: shown at the line of the user, and kept by what they are told of."""

from __future__ import annotations

import functools
import sys
import warnings
from collections.abc import Callable
from contextvars import ContextVar
from importlib.metadata import entry_points
from typing import Any, ParamSpec, TypeVar

from .errors import GeomintWarning, StepError

__all__ = ["Gathered", "keeping", "tell"]

P = ParamSpec("P")
R = TypeVar("R")


class Gathered(list[GeomintWarning]):
    """Warnings that are told within, each once; if `quiet`, nobody else sees them."""

    def __init__(self, quiet: bool = False) -> None:
        super().__init__()
        self.quiet = quiet

    def __enter__(self) -> Gathered:
        above = _told.get()
        self.quiet = self.quiet or (above is not None and above.quiet)
        self._token = _told.set(self)
        return self

    def __exit__(self, *of: object) -> None:
        _told.reset(self._token)


_told: ContextVar[Gathered | None] = ContextVar("told", default=None)


def tell(warning: GeomintWarning) -> None:
    """Warn at the line of the first caller outside of geomint and systems; once of the same."""
    told = _told.get()
    if told is not None:
        if warning in told:  # of a run that began anew
            return
        told.append(warning)
        if told.quiet:
            return
    frame, level = sys._getframe(1), 2
    while frame.f_back and str(frame.f_globals.get("__name__")).partition(".")[0] in _packages():
        frame, level = frame.f_back, level + 1
    warnings.warn(warning, stacklevel=level)


@functools.cache
def _packages() -> set[str]:
    """Return geomint and the packages that register systems: a user did not write their lines."""
    return {"geomint", *(p.module.split(".")[0] for p in entry_points(group="geomint.systems"))}


def keeping(function: Callable[P, R]) -> Callable[P, R]:
    """Return a function whose result, or what an error has of it, keeps its `warnings`."""

    @functools.wraps(function)
    def kept(*args: P.args, **named: P.kwargs) -> R:
        with Gathered() as told:
            try:
                found: Any = function(*args, **named)
            except StepError as error:
                if error.partial is not None:
                    error.partial.warnings = tuple(told)
                raise
        found.warnings = tuple(told)
        return found  # type: ignore[no-any-return]

    return kept
