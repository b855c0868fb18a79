"""geomint's own cases: all built-in scenes and all test problems."""

from __future__ import annotations

from . import state_cases, step_cases
from .case import StressCase

__all__ = ["cases"]


def cases() -> list[StressCase]:
    """Return all cases of this package."""
    return [*step_cases.steps(), *state_cases.cases()]
