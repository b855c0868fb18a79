"""Two orthonormal vectors in a changing field: three constraints, unequal masses."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

import geomint as gi

from .double_pendulum import angular_momentum, product

__all__ = ["initial", "problem"]

FRAMES = gi.Stiefel(3, 2)

# q = (x, w), p = (p_x, p_w)


@gi.helper
def named(params: Any) -> Any:
    """Return m, M, weight, stiffness and ε: the parameters, in the order of those of `problem`."""
    return params[0], params[1], params[2], params[3], params[4]


@gi.helper
def pulls(params: Any, t: Any, q: Any) -> Any:
    """∂V/∂x₃ and ∂V/∂w₃; the other derivatives of V are 0."""
    _, _, weight, stiffness, season = named(params)
    return weight * (1.0 + season * gi.cos(2.0 * t)), stiffness * q[5]


@gi.field
def motion(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """ẋ = p_x/m, ẇ = p_w/M, ṗ_x = −∂V/∂x − λx − νw, ṗ_w = −∂V/∂w − μw − νx.

    The second derivatives of ½|x|², ½|w|² and (x, w) vanish; x and w being orthonormal, each gives
    one multiplier.
    """
    m, M, _, _, _ = named(params)
    fx, fw = pulls(params, t, y)
    lam = product(y, 6, 6) / m - fx * y[2]
    mu = product(y, 9, 9) / M - fw * y[5]
    both = 2.0 * product(y, 6, 9) / (m * M) - fx * y[5] / m - fw * y[2] / M
    nu = both / (1.0 / m + 1.0 / M)
    for i in range(3):
        out[i] = y[6 + i] / m
        out[3 + i] = y[9 + i] / M
        out[6 + i] = -(lam * y[i] + nu * y[3 + i])
        out[9 + i] = -(mu * y[3 + i] + nu * y[i])
    out[8] = out[8] - fx
    out[11] = out[11] - fw


@gi.field
def gradients(params: Any, t: Any, q: Any, p: Any, dq: Any, dp: Any, work: Any) -> None:
    """∂H/∂q = ∂V/∂q, ∂H/∂p = (p_x/m, p_w/M)."""
    m, M, _, _, _ = named(params)
    for i in range(3):
        dq[i] = 0.0 * q[i]
        dq[3 + i] = 0.0 * q[i]
        dp[i] = p[i] / m
        dp[3 + i] = p[3 + i] / M
    fx, fw = pulls(params, t, q)
    dq[2] = dq[2] + fx
    dq[5] = dq[5] + fw


@gi.field
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """H = |p_x|²/2m + |p_w|²/2M + V."""
    m, M, _, _, _ = named(params)
    kinetic = 0.5 * (product(y, 6, 6) / m + product(y, 9, 9) / M)
    fx, fw = pulls(params, t, y)
    return kinetic + fx * y[2] + 0.5 * fw * y[5]


@gi.field
def manifold(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """½(|x|² − 1), ½(|w|² − 1), (x, w) and their rates: det(G M⁻¹ Gᵀ) is constant there."""
    m, M, _, _, _ = named(params)
    out[0] = 0.5 * (product(y, 0, 0) - 1.0)
    out[1] = 0.5 * (product(y, 3, 3) - 1.0)
    out[2] = product(y, 0, 3)
    out[3] = product(y, 0, 6) / m
    out[4] = product(y, 3, 9) / M
    out[5] = product(y, 3, 6) / m + product(y, 0, 9) / M


def initial(
    problem: gi.Problem, spin: tuple[float, float, float] = (0.3, -0.4, 0.9)
) -> npt.NDArray[np.float64]:
    """Return a state whose frame turns with the angular velocity `spin`."""
    x, w = np.array([0.6, 0.0, -0.8]), np.array([0.0, 1.0, 0.0])
    m, M, _, _, _ = problem.params
    return np.concatenate([x, w, m * np.cross(spin, x), M * np.cross(spin, w)])


def problem(
    first: float = 1.0,
    second: float = 0.6,
    weight: float = 0.8,
    stiffness: float = 1.3,
    season: float = 0.4,
    separable: bool = True,
) -> gi.Problem:
    """Return orthonormal vectors x, w with masses m, M in a field along the vertical.

    ::

        H = |p_x|²/2m + |p_w|²/2M + weight (1 + ε cos 2t) x₃ + ½ stiffness w₃²

    on the Stiefel manifold V(3, 2). Conserved: the angular momentum about the vertical, and with
    ε = 0 the energy. Forms: ODE and Hamiltonian, with three constraints.

    Parameters
    ----------
    separable : bool
        Whether the Hamiltonian form says that it is separable, as it is.

    References
    ----------
    E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, 2nd ed., VII.5.5, on rigid
    bodies by constraints.
    """
    numbers = {"first": first, "second": second, "weight": weight, "stiffness": stiffness}
    numbers["season"] = season
    invariants = {"angular-momentum": angular_momentum}
    return gi.Problem(
        name="frame-in-field",
        pieces=(("x", 3), ("w", 3), ("px", 3), ("pw", 3)),
        params=np.array(list(numbers.values())),
        field=motion,
        hamiltonian=gi.Hamiltonian(gradients, FRAMES.constraint, FRAMES.conditions, separable),
        invariants=invariants if season else {**invariants, "energy": energy},
        constraints=FRAMES.constraints,
        measure=gi.Measure(manifold=manifold, conditions=6),
        parameters={**numbers, "separable": separable},
    )
