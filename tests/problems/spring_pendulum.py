"""A pendulum on a stiff spring: fast vibrations and a slow swing."""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi

__all__ = ["INITIAL", "problem"]

INITIAL = np.array([0.606, -0.808, 0.4, 0.3])  # |q| = 1.01, turning


@gi.field
def force(params: Any, t: Any, q: Any, out: Any, work: Any) -> None:
    """−∂V/∂q = −ω² (|q| − 1) q/|q| − g e₂."""
    length = gi.sqrt(q[0] * q[0] + q[1] * q[1])
    pull = params[0] * params[0] * (1.0 - 1.0 / length)
    out[0] = -pull * q[0]
    out[1] = -pull * q[1] - params[1]


@gi.field
def motion(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """q̇ = p, ṗ = −∂V/∂q."""
    out[0] = 1.0 * y[2]
    out[1] = 1.0 * y[3]
    force(params, t, gi.part(y, 0, 2), gi.part(out, 2, 2), work)


@gi.field
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """H = ½|p|² + ½ ω² (|q| − 1)² + g q₂."""
    stretched = params[0] * (gi.sqrt(y[0] * y[0] + y[1] * y[1]) - 1.0)
    return 0.5 * (y[2] * y[2] + y[3] * y[3] + stretched * stretched) + params[1] * y[1]


def problem(stiffness: float = 100.0, gravity: float = 1.0) -> gi.Problem:
    """Return a point on a stiff spring in the plane, H = ½|p|² + ½ ω² (|q| − 1)² + g q₂.

    The spring vibrates at ω, ``stiffness``, while the pendulum swings at about √g; as ω → ∞ the
    motion without vibrations is that of the pendulum. Conserved: the energy. Forms: ODE and
    splitting.

    References
    ----------
    U. M. Ascher, S. Reich, in *Computational Molecular Dynamics*, Springer 1999, 281; E. Hairer,
    C. Lubich, G. Wanner, *Geometric Numerical Integration*, 2nd ed., XIII.
    """
    return gi.Problem(
        name="spring-pendulum",
        pieces=(("q", 2), ("p", 2)),
        params=np.array([stiffness, gravity]),
        field=motion,
        splitting=gi.natural_in_space(force),
        invariants={"energy": energy},
        measure=gi.Measure(),
        symplectic_form=gi.SymplecticForm(),
        parameters={"stiffness": stiffness, "gravity": gravity},
    )
