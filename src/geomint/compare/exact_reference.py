"""Exact motions: what problems offer that can be solved without stepping, and their use as references.

A problem with `Problem.make_exact` gives an `ExactMotion` through every state. Its error does not
come from steps: what grows with time is the phase that the rounding of the initial state costs.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from ..arguments import Array
from ..problems.problem import Problem
from .confirmation import confirm
from .reference_record import SMALL, Reference

__all__ = ["ExactMotion", "exact_reference"]


class ExactMotion(Protocol):
    """The motion through one state, at any time; times are numbers or arrays."""

    def __call__(self, t: Any) -> Array:
        """Return states at physical times."""

    def at_tau(self, tau: Any) -> Array:
        """Return states at times τ of the problem, or of whatever makes its angles linear."""

    def time(self, tau: Any) -> Array:
        """Return physical time at times τ."""

    def tau(self, t: Any) -> Array:
        """Return τ at physical times."""

    def phase_error(self, tau: Any) -> Array:
        """Return an estimate of the error of the angles at times τ, in radians."""

    def time_error(self, tau: Any) -> Array:
        """Return an estimate of the error of physical time at times τ, as an angle in radians."""


def exact_reference(problem: Problem, y0: Array, end: dict[str, float]) -> Reference:
    """Return the state at an end, ``{"t_end": …}`` or ``{"tau_end": …}``, by the exact motion.

    A second method confirms it (`geomint.compare.confirmation`).

    Raises
    ------
    FormError
        If the problem has no exact motion.
    DomainError
        If there is none through this state.
    UnknownReferenceError
        If its estimated error, or the second method, leaves more than a tenth of errors of 1e-5
        uncertain.
    """
    motion: ExactMotion = problem.exact(y0)
    in_tau = problem.time == "tau"
    if "tau_end" in end:
        tau = float(end["tau_end"])
        y, own, physical = motion.at_tau(tau), tau, float(motion.time(tau))
    else:
        physical = float(end["t_end"])
        tau = float(motion.tau(physical))
        y, own = motion(physical), tau if in_tau else physical

    def first(at: float) -> Array:
        state = np.asarray(motion.at_tau(at) if in_tau else motion(at))
        return state if problem.clock is None else np.append(state, motion.time(at))

    return Reference(
        own_end=own,
        physical_end=physical,
        y=np.asarray(y),
        error=float(motion.phase_error(tau) + motion.time_error(tau)),
        steps=(),
        method="exact flow",
        confirmation=confirm(problem, y0, own, first),
    ).for_errors(SMALL)
