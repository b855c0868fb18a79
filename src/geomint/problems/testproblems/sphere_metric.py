"""A point on a sphere whose mass depends on time, place and direction: T*S^(n−1), not separable."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ...kernels.compiling.recorded import field
from ...kernels.numbers.arithmetic import cos, sin
from ..forms import Hamiltonian
from ..problem import Problem
from ..spaces.sphere import Sphere

__all__ = ["initial", "problem"]

# params = [ε, δ, ψ, b_1 …, b_n, c_1 …, c_n]
HEADER = 3


@field
def gradients(params: Any, t: Any, q: Any, p: Any, dq: Any, dp: Any, work: Any) -> None:
    """∂H/∂q = ½|p|² ∂φ/∂q + (1 + ½ sin 2t) c, ∂H/∂p = φp + ψ(b, p) b."""
    n = len(q)
    bq, bp, pp = params[HEADER] * q[0], params[HEADER] * p[0], p[0] * p[0]
    for i in range(1, n):
        bq += params[HEADER + i] * q[i]
        bp += params[HEADER + i] * p[i]
        pp += p[i] * p[i]
    phi = 1.0 + params[0] * cos(t) + params[1] * bq * bq
    slope = params[1] * bq * pp
    pull = 1.0 + 0.5 * sin(2.0 * t)
    for i in range(n):
        dq[i] = slope * params[HEADER + i] + pull * params[HEADER + n + i]
        dp[i] = phi * p[i] + params[2] * bp * params[HEADER + i]


@field
def motion(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """q̇ = v = ∂H/∂p, ṗ = f − λq with f = −∂H/∂q and λ from d(q, v)/dt = 0.

    ::

        λ (φ(q, q) + ψ(b, q)²) = (v, v) + φ̇ (q, p) + φ(q, f) + ψ(b, f)(b, q)
    """
    n = len(y) // 2
    bq, bp, pp = params[HEADER] * y[0], params[HEADER] * y[n], y[n] * y[n]
    qq, qp, bb = y[0] * y[0], y[0] * y[n], params[HEADER] * params[HEADER]
    cq, bc = params[HEADER + n] * y[0], params[HEADER + n] * params[HEADER]
    for i in range(1, n):
        b, c, q, p = params[HEADER + i], params[HEADER + n + i], y[i], y[n + i]
        bq += b * q
        bp += b * p
        pp += p * p
        qq += q * q
        qp += q * p
        bb += b * b
        cq += c * q
        bc += b * c
    phi = 1.0 + params[0] * cos(t) + params[1] * bq * bq
    psi = params[2]
    slope = params[1] * bq * pp
    pull = 1.0 + 0.5 * sin(2.0 * t)
    b_velocity = (phi + psi * bb) * bp
    velocity2 = phi * phi * pp + psi * bp * bp * (2.0 * phi + psi * bb)
    phi_dot = 2.0 * params[1] * bq * b_velocity - params[0] * sin(t)
    q_force = -(slope * bq + pull * cq)
    b_force = -(slope * bb + pull * bc)
    right = velocity2 + phi_dot * qp + phi * q_force + psi * b_force * bq
    multiplier = right / (phi * qq + psi * bq * bq)
    for i in range(n):
        b, c = params[HEADER + i], params[HEADER + n + i]
        out[i] = phi * y[n + i] + psi * bp * b
        out[n + i] = -(slope * b + pull * c) - multiplier * y[i]


@field
def tangency(params: Any, t: Any, y: Any, work: Any) -> Any:
    """(q, ∂H/∂p)."""
    n = len(y) // 2
    bq, bp, qp = params[HEADER] * y[0], params[HEADER] * y[n], y[0] * y[n]
    for i in range(1, n):
        bq += params[HEADER + i] * y[i]
        bp += params[HEADER + i] * y[n + i]
        qp += y[i] * y[n + i]
    phi = 1.0 + params[0] * cos(t) + params[1] * bq * bq
    return phi * qp + params[2] * bp * bq


def problem(n: int = 3, pulse: float = 0.3, bend: float = 0.7, pull: float = 0.5) -> Problem:
    """Return a Hamiltonian on T*S^(n−1) that is neither separable nor autonomous.

    ::

        H(t, q, p) = ½ φ(t, q) (p, p) + ½ ψ (b, p)² + (1 + ½ sin 2t) (c, q),   |q| = 1,
        φ(t, q) = 1 + ε cos t + δ (b, q)²

    The hidden constraint (q, ∂H/∂p) = φ (q, p) + ψ (b, p)(b, q) = 0 is not (q, p) = 0, and changes
    with time. Nothing else is conserved. Parameters: ε, δ, ψ. Forms: ODE and Hamiltonian.
    """
    (b, c), sphere = _vectors(n), Sphere(n, "q")
    return Problem(
        name=f"sphere-metric-{n}",
        pieces=(("q", n), ("p", n)),
        params=np.concatenate([[pulse, bend, pull], b, c]),
        field=motion,
        hamiltonian=Hamiltonian(gradients, sphere.constraint, sphere.conditions),
        constraints={**sphere.constraints, "tangency": tangency},
        parameters={"n": n, "pulse": pulse, "bend": bend, "pull": pull},
    )


def _vectors(n: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    b = np.sin(0.7 + 1.1 * np.arange(n))
    c = np.cos(0.3 + 0.8 * np.arange(n))
    return b / np.linalg.norm(b), 0.6 * c


def initial(problem: Problem) -> npt.NDArray[np.float64]:
    """Return a state of a problem of this module that meets both constraints at time 0."""
    n = problem.rows // 2
    q = np.cos(1.0 + 1.9 * np.arange(n))
    q /= np.linalg.norm(q)
    p = np.sin(0.4 + 2.3 * np.arange(n))
    b = problem.params[HEADER : HEADER + n]
    phi = 1.0 + problem.params[0] + problem.params[1] * (b @ q) ** 2
    normal = phi * q + problem.params[2] * (b @ q) * b
    p -= q * (normal @ p) / (normal @ q)
    return np.concatenate([q, p])
