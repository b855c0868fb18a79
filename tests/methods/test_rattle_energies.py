"""RATTLE where kinetic energies are not quadratic in p, and where constraints are in odd units."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import geomint as gi

Array = Any
Q0, P0 = np.array([0.6, 0.0, 0.8]), np.array([0.8, 1.0, -0.6])


@gi.helper
def quartic(params, t, q, p, dq, dp, work):
    """H = |p|²/2 + |p|⁴/40 + q₃."""
    s = 1.0 + 0.1 * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
    for i in range(3):
        dq[i] = 0.0 * q[i]
        dp[i] = s * p[i]
    dq[2] = 1.0 + 0.0 * q[2]


@gi.helper
def relativistic(params, t, q, p, dq, dp, work):
    """H = √(1 + |p|²) + q₃."""
    s = 1.0 / gi.sqrt(1.0 + p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
    for i in range(3):
        dq[i] = 0.0 * q[i]
        dp[i] = s * p[i]
    dq[2] = 1.0 + 0.0 * q[2]


@gi.helper
def plain(params, t, q, p, dq, dp, work):
    """H = |p|²/2 + q₃."""
    for i in range(3):
        dq[i] = 0.0 * q[i]
        dp[i] = p[i]
    dq[2] = 1.0 + 0.0 * q[2]


@gi.helper
def scaled_sphere(params, q, g, G, work):
    g[0] = 0.5 * params[0] * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] - 1.0)
    for i in range(3):
        G[i] = params[0] * q[i]


FACTORS = {
    quartic: lambda p: 1.0 + 0.1 * (p @ p),
    relativistic: lambda p: 1.0 / np.sqrt(1.0 + p @ p),
    plain: lambda p: 1.0,
}


def pendulum(energy: Any, scale: float = 1.0, separable: bool = False) -> gi.Problem:
    form = gi.Hamiltonian(energy, scaled_sphere, 1, separable=separable)
    return gi.Problem("top-of-a-rod", (("q", 3), ("p", 3)), params=[scale], hamiltonian=form)


def truth(energy: Any, p0: Array, t: float) -> Array:
    """Return the state by SciPy: q̇ = s p, ṗ = −e₃ + (q₃ − s|p|²) q where (q, p) = 0."""
    factor = FACTORS[energy]

    def rate(t: float, y: Array) -> Array:
        q, p = y[:3], y[3:]
        s = factor(p)
        return np.concatenate([s * p, (q[2] - s * (p @ p)) * q - [0.0, 0.0, 1.0]])

    start = np.concatenate([Q0, p0])
    return solve_ivp(rate, (0.0, t), start, "DOP853", rtol=1e-13, atol=1e-15).y[:, -1]


@pytest.mark.parametrize("energy", [quartic, relativistic], ids=["quartic", "relativistic"])
@pytest.mark.parametrize("p0", [P0, 0.0 * P0], ids=["moving", "at rest"])
@pytest.mark.parametrize(("method", "order"), [("rattle-2", 2), ("rattle-4", 4)])
def test_order_in_q_and_p(energy: Any, p0: Array, method: str, order: int) -> None:
    """Both have it, and p stays tangent: (q, ∂H/∂p) = 0 to rounding."""
    exact = truth(energy, p0, 1.0)
    errors = []
    for step in (0.05, 0.025):
        y0 = np.concatenate([Q0, p0])
        run = gi.solve(pendulum(energy), y0, t_end=1.0, step=step, method=method, compiled=False)
        y = run.y[-1]
        assert abs(y[:3] @ y[3:]) < 1e-15
        errors.append([np.abs(y - exact)[:3].max(), np.abs(y - exact)[3:].max()])
    found = np.log2(errors[0]) - np.log2(errors[1])
    assert found == pytest.approx([order] * 2, abs=0.35), (found, errors)


@pytest.mark.parametrize("separable", [True, False])
@pytest.mark.parametrize("scale", [1e-300, 1e-160, 1e-100, 1e100, 1e152, 1e154, 1e160, 1e300])
def test_a_constraint_in_any_unit_holds_or_is_refused(scale: float, separable: bool) -> None:
    """Numbers that overflow or underflow are an error, never a motion without the constraint."""
    y0 = np.concatenate([Q0, P0])
    problem = pendulum(plain, scale, separable)
    try:
        run = gi.solve(problem, y0, t_end=0.2, step=0.02, method="rattle-2", compiled=False)
    except gi.StepError:
        assert not 1e-110 < scale < 1e110
        return
    assert np.linalg.norm(run.y[-1, :3]) == pytest.approx(1.0, abs=1e-14)
