"""Exact motions: what a problem offers that can be solved without stepping.

`Problem.make_exact` makes one through every state, and `geomint.solve` follows it with
``method="exact"``.
"""

from typing import Any, Protocol

from ..arguments import Array


class ExactMotion(Protocol):
    """The motion through one state, at any time; times are numbers or arrays, from 0 at that state on.

    Some have more that is used: `frequencies`, angular ones in τ, and `mean_frequencies`, the same in
    physical time, say how densely events are looked for.
    """

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
