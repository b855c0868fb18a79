"""The double spherical pendulum: two constraints, unequal masses."""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi

__all__ = ["INITIAL", "problem"]

# Unequal masses 1 and 1/2: velocities (0.3, 0.5, 0) ⟂ x and (0.3, 0.5, 0) + (0, 0.4, 0.3) below.
INITIAL = np.array([0.0, 0.0, -1.0, 0.0, 0.6, -1.8, 0.3, 0.5, 0.0, 0.15, 0.45, 0.15])


@gi.helper
def named(params: Any) -> Any:
    """Return m, M and g: the parameters, in the order of those of `problem`."""
    return params[0], params[1], params[2]


@gi.helper
def product(y: Any, i: int, j: int) -> Any:
    """(y_i, y_j) of two 3-vectors in a block."""
    return y[i] * y[j] + y[i + 1] * y[j + 1] + y[i + 2] * y[j + 2]


@gi.field
def motion(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """ẋ = p_x/m, ẇ = p_w/M; ṗ_x = −mg e₃ − λx + μd, ṗ_w = −Mg e₃ − μd with d = w − x.

    The second derivatives of ½|x|² and ½|d|² along the motion vanish, which gives λ and μ.
    """
    m, M, gravity = named(params)
    for i in range(3):
        work[i] = y[3 + i] - y[i]  # d
        work[3 + i] = y[6 + i] / m  # velocity of x
        work[6 + i] = y[9 + i] / M - y[6 + i] / m  # velocity of d
        work[9 + i] = 1.0 * y[i]
    xx, xd, dd = product(work, 9, 9), product(work, 9, 0), product(work, 0, 0)
    # (x, ẍ) + |ẋ|² = 0 and (d, d̈) + |ḋ|² = 0; gravity accelerates both points alike.
    a11, a12 = xx / m, -xd / m
    a21, a22 = -xd / m, dd / m + dd / M
    b1 = product(work, 3, 3) - gravity * y[2]
    b2 = product(work, 6, 6)
    determinant = a11 * a22 - a12 * a21
    lam = (b1 * a22 - a12 * b2) / determinant
    mu = (a11 * b2 - a21 * b1) / determinant
    for i in range(3):
        out[i] = y[6 + i] / m
        out[3 + i] = y[9 + i] / M
        out[6 + i] = mu * work[i] - lam * y[i]
        out[9 + i] = -mu * work[i]
    out[8] = out[8] - m * gravity
    out[11] = out[11] - M * gravity


@gi.field
def gradients(params: Any, t: Any, q: Any, p: Any, dq: Any, dp: Any, work: Any) -> None:
    """∂H/∂q = g (m e₃, M e₃), ∂H/∂p = (p_x/m, p_w/M)."""
    m, M, gravity = named(params)
    for i in range(3):
        dq[i] = 0.0 * q[i]
        dq[3 + i] = 0.0 * q[i]
        dp[i] = p[i] / m
        dp[3 + i] = p[3 + i] / M
    dq[2] = dq[2] + m * gravity
    dq[5] = dq[5] + M * gravity


@gi.field
def rods(params: Any, q: Any, g: Any, G: Any, work: Any) -> None:
    """½(|x|² − 1), ½(|w − x|² − 1) and their Jacobian."""
    first, second = -1.0 + 0.0 * q[0], -1.0 + 0.0 * q[0]
    for i in range(3):
        d = q[3 + i] - q[i]
        first += q[i] * q[i]
        second += d * d
        G[i] = 1.0 * q[i]
        G[3 + i] = 0.0 * q[i]
        G[6 + i] = -d
        G[9 + i] = d
    g[0] = 0.5 * first
    g[1] = 0.5 * second


@gi.field
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """H = |p_x|²/2m + |p_w|²/2M + g (m x₃ + M w₃)."""
    m, M, gravity = named(params)
    kinetic = 0.5 * (product(y, 6, 6) / m + product(y, 9, 9) / M)
    return kinetic + gravity * (m * y[2] + M * y[5])


@gi.field
def angular_momentum(params: Any, t: Any, y: Any, work: Any) -> Any:
    """Angular momentum about the vertical."""
    return (y[0] * y[7] - y[1] * y[6]) + (y[3] * y[10] - y[4] * y[9])


@gi.field
def upper_rod(params: Any, t: Any, y: Any, work: Any) -> Any:
    """|x|² − 1."""
    return product(y, 0, 0) - 1.0


@gi.field
def lower_rod(params: Any, t: Any, y: Any, work: Any) -> Any:
    """|w − x|² − 1."""
    total = -1.0 + 0.0 * y[0]
    for i in range(3):
        total += (y[3 + i] - y[i]) * (y[3 + i] - y[i])
    return total


@gi.field
def log_density(params: Any, t: Any, y: Any, work: Any) -> Any:
    """Log det(G M⁻¹ Gᵀ): the symplectic volume is det{c_i, c_j}^½ δ(c) dq dp, c = (g, G M⁻¹ p)."""
    m, M, _ = named(params)
    xx, dd, xd = 0.0 * y[0], 0.0 * y[0], 0.0 * y[0]
    for i in range(3):
        d = y[3 + i] - y[i]
        xx += y[i] * y[i]
        xd += y[i] * d
        dd += d * d
    return gi.log(xx * dd * (1.0 / m + 1.0 / M) / m - xd * xd / (m * m))


@gi.field
def manifold(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """½(|x|² − 1), ½(|w − x|² − 1) and their rates."""
    m, M, _ = named(params)
    first, second = 0.0 * y[0], 0.0 * y[0]
    for i in range(3):
        velocity = y[6 + i] / m
        first += y[i] * velocity
        second += (y[3 + i] - y[i]) * (y[9 + i] / M - velocity)
    out[0] = 0.5 * upper_rod(params, t, y, work)
    out[1] = 0.5 * lower_rod(params, t, y, work)
    out[2] = first
    out[3] = second


def problem(upper: float = 1.0, lower: float = 0.5, gravity: float = 1.0) -> gi.Problem:
    """Return two points x, w with |x| = |w − x| = 1 and masses m, M in constant gravity.

    State: ``x``, ``w`` (3,) and their momenta ``px``, ``pw``. H = |p_x|²/2m + |p_w|²/2M +
    g (m x₃ + M w₃). Conserved: the energy and the angular momentum about the vertical. Forms: ODE
    and Hamiltonian, with two constraints.

    References
    ----------
    J. E. Marsden, J. Scheurle, Z. Angew. Math. Phys. 44 (1993) 17.
    """
    return gi.Problem(
        name="double-spherical-pendulum",
        pieces=(("x", 3), ("w", 3), ("px", 3), ("pw", 3)),
        params=np.array([upper, lower, gravity]),
        field=motion,
        hamiltonian=gi.Hamiltonian(gradients, rods, 2, separable=True),
        work=12,
        invariants={"energy": energy, "angular-momentum": angular_momentum},
        constraints={"upper-rod": upper_rod, "lower-rod": lower_rod},
        measure=gi.Measure(log_density, manifold, 4),
        parameters={"upper": upper, "lower": lower, "gravity": gravity},
    )
