"""A point on a sphere whose mass depends on time, place and direction: T*S^(n−1), not separable."""

from collections import namedtuple
from typing import Any

import numpy as np

from ...arguments import Array
from ...kernels.compiling.recorded import field, helper
from ...kernels.numbers.blocks import Block, packed, part, sections
from ...kernels.numbers.circular import cos, sin
from ..forms import Hamiltonian
from ..problem import Problem
from ..spaces.sphere import Sphere

__all__ = ["initial", "problem"]

Metric = namedtuple("Metric", "epsilon delta psi b c")


@helper
def metric_rows(n: int) -> Metric:
    """Return the layout of the parameters."""
    return Metric(epsilon=1, delta=1, psi=1, b=n, c=n)


@helper
def named(params: Any, n: int) -> Any:
    """Return the blocks of ε, δ, ψ, b and c."""
    return sections(params, metric_rows(n))


@helper
def inner(n: int, x: Any, z: Any) -> Any:
    """Return (x, z) over the first n rows."""
    total = x[0] * z[0]
    for i in range(1, n):
        total += x[i] * z[i]
    return total


@field
def gradients(params, t, q, p, dq, dp, work):
    """∂H/∂q = ½|p|² ∂φ/∂q + (1 + ½ sin 2t) c, ∂H/∂p = φp + ψ(b, p) b."""
    n = len(q)
    epsilon, delta, psi, b, c = named(params, n)
    bq, bp, pp = inner(n, b, q), inner(n, b, p), inner(n, p, p)
    phi = 1.0 + epsilon[0] * cos(t) + delta[0] * bq * bq
    slope = delta[0] * bq * pp
    pull = 1.0 + 0.5 * sin(2.0 * t)
    for i in range(n):
        dq[i] = slope * b[i] + pull * c[i]
        dp[i] = phi * p[i] + psi[0] * bp * b[i]


@field
def motion(params, t, y, out, work):
    """q̇ = v = ∂H/∂p, ṗ = f − λq with f = −∂H/∂q and λ from d(q, v)/dt = 0.

    ::

        λ (φ(q, q) + ψ(b, q)²) = (v, v) + φ̇ (q, p) + φ(q, f) + ψ(b, f)(b, q)
    """
    n = len(y) // 2
    epsilon, delta, psi, b, c = named(params, n)
    p = part(y, n, n)
    bq, bp, pp = inner(n, b, y), inner(n, b, p), inner(n, p, p)
    qq, qp, bb = inner(n, y, y), inner(n, y, p), inner(n, b, b)
    cq, bc = inner(n, c, y), inner(n, b, c)
    phi = 1.0 + epsilon[0] * cos(t) + delta[0] * bq * bq
    slope = delta[0] * bq * pp
    pull = 1.0 + 0.5 * sin(2.0 * t)
    b_velocity = (phi + psi[0] * bb) * bp
    velocity2 = phi * phi * pp + psi[0] * bp * bp * (2.0 * phi + psi[0] * bb)
    phi_dot = 2.0 * delta[0] * bq * b_velocity - epsilon[0] * sin(t)
    q_force = -(slope * bq + pull * cq)
    b_force = -(slope * bb + pull * bc)
    right = velocity2 + phi_dot * qp + phi * q_force + psi[0] * b_force * bq
    multiplier = right / (phi * qq + psi[0] * bq * bq)
    for i in range(n):
        bi, ci = b[i], c[i]
        out[i] = phi * p[i] + psi[0] * bp * bi
        out[n + i] = -(slope * bi + pull * ci) - multiplier * y[i]


@field
def tangency(params, t, y, work):
    """(q, ∂H/∂p)."""
    n = len(y) // 2
    epsilon, delta, psi, b, _ = named(params, n)
    p = part(y, n, n)
    bq, bp, qp = inner(n, b, y), inner(n, b, p), inner(n, y, p)
    phi = 1.0 + epsilon[0] * cos(t) + delta[0] * bq * bq
    return phi * qp + psi[0] * bp * bq


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
        params=packed(metric_rows(n), epsilon=pulse, delta=bend, psi=pull, b=b, c=c).data,
        field=motion,
        hamiltonian=Hamiltonian(gradients, sphere.constraint, sphere.conditions),
        constraints={**sphere.constraints, "tangency": tangency},
        parameters={"n": n, "pulse": pulse, "bend": bend, "pull": pull},
    )


def _vectors(n: int) -> tuple[Array, Array]:
    b = np.sin(0.7 + 1.1 * np.arange(n))
    c = np.cos(0.3 + 0.8 * np.arange(n))
    return b / np.linalg.norm(b), 0.6 * c


def initial(problem: Problem) -> Array:
    """Return a state of a problem of this module that meets both constraints at time 0."""
    n = problem.rows // 2
    q = np.cos(1.0 + 1.9 * np.arange(n))
    q /= np.linalg.norm(q)
    p = np.sin(0.4 + 2.3 * np.arange(n))
    epsilon, delta, psi, b, _ = (part.data for part in named(Block(problem.params), n))
    phi = 1.0 + epsilon + delta * (b @ q) ** 2
    normal = phi * q + psi * (b @ q) * b
    p -= q * (normal @ p) / (normal @ q)
    return np.concatenate([q, p])
