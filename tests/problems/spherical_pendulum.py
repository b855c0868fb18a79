"""The spherical pendulum: a point on the unit sphere in constant gravity."""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi

__all__ = ["INITIAL", "problem"]

INITIAL = np.array([0.6, 0.0, -0.8, 0.2, 0.9, 0.15])


@gi.field
def motion(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """q̇ = p, ṗ = −g e₃ − λq, λ = ((p, p) − g q₃)/(q, q)."""
    q2 = y[0] * y[0] + y[1] * y[1] + y[2] * y[2]
    p2 = y[3] * y[3] + y[4] * y[4] + y[5] * y[5]
    multiplier = (p2 - params[0] * y[2]) / q2
    for i in range(3):
        out[i] = 1.0 * y[3 + i]
        out[3 + i] = -multiplier * y[i]
    out[5] = out[5] - params[0]


@gi.field
def gradients(params: Any, t: Any, q: Any, p: Any, dq: Any, dp: Any, work: Any) -> None:
    """∂H/∂q = g e₃, ∂H/∂p = p."""
    for i in range(3):
        dq[i] = 0.0 * q[i]
        dp[i] = 1.0 * p[i]
    dq[2] = dq[2] + params[0]


@gi.field
def potential_gradient(params: Any, t: Any, q: Any, out: Any, work: Any) -> None:
    """∂V/∂q = g e₃."""
    out[0] = 0.0 * q[0]
    out[1] = 0.0 * q[0]
    out[2] = params[0] + 0.0 * q[0]


@gi.field
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """H = ½(p, p) + g q₃."""
    return 0.5 * (y[3] * y[3] + y[4] * y[4] + y[5] * y[5]) + params[0] * y[2]


@gi.field
def angular_momentum(params: Any, t: Any, y: Any, work: Any) -> Any:
    """q₁p₂ − q₂p₁."""
    return y[0] * y[4] - y[1] * y[3]


def problem(gravity: float = 1.0) -> gi.Problem:
    """Return the spherical pendulum, H = ½(p, p) + g q₃ on |q| = 1, unit mass and length.

    Conserved: the energy and the angular momentum about the vertical, which is quadratic. Forms:
    ODE, Hamiltonian (separable) and splitting.

    References
    ----------
    E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, 2nd ed., VII.1.2.
    """
    space = gi.TangentSphere(3, ("q", "p"))
    return gi.Problem(
        name="spherical-pendulum",
        space=space,
        params=np.array([gravity]),
        field=motion,
        hamiltonian=space.hamiltonian(gradients, separable=True),
        splitting=gi.natural_on_sphere(potential_gradient),
        invariants={"energy": energy, "angular-momentum": angular_momentum},
        measure=gi.Measure(),
        parameters={"gravity": gravity},
    )
