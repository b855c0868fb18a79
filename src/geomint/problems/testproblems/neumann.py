"""Carl Neumann's system: a point on a sphere in a quadratic potential."""

from collections import namedtuple
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...arguments import Array
from ...kernels.compiling.recorded import Recorded, field, helper
from ...kernels.numbers.blocks import REST, packed, section
from ...kernels.numbers.circular import cos
from ..forms import Measure
from ..natural import natural_on_sphere
from ..problem import Problem
from ..spaces.tangent_bundle import TangentSphere

__all__ = ["initial", "problem"]

Neumann = namedtuple("Neumann", "season a")
LAYOUT = Neumann(season=1, a=REST)  # of the parameters; y = (q, p)


@helper
def strength(params: Any, t: Any) -> Any:
    """φ = 1 + ε cos 2t."""
    return 1.0 + section(params, LAYOUT, "season")[0] * cos(2.0 * t)


@field
def motion(params, t, y, out, work):
    """q̇ = p, ṗ = −φAq + λq, λ = (φ(q, Aq) − (p, p))/(q, q), φ = 1 + ε cos 2t."""
    n = len(y) // 2
    phi, a = strength(params, t), section(params, LAYOUT, "a")
    qq, qaq, pp = y[0] * y[0], a[0] * y[0] * y[0], y[n] * y[n]
    for i in range(1, n):
        qq += y[i] * y[i]
        qaq += a[i] * y[i] * y[i]
        pp += y[n + i] * y[n + i]
    multiplier = (phi * qaq - pp) / qq
    for i in range(n):
        out[i] = 1.0 * y[n + i]
        out[n + i] = (multiplier - phi * a[i]) * y[i]


@field
def potential_gradient(params, t, q, out, work):
    """∂V/∂q = φAq."""
    phi, a = strength(params, t), section(params, LAYOUT, "a")
    for i in range(len(q)):
        out[i] = phi * a[i] * q[i]


@field
def gradients(params, t, q, p, dq, dp, work):
    """∂H/∂q = φAq, ∂H/∂p = p."""
    phi, a = strength(params, t), section(params, LAYOUT, "a")
    for i in range(len(q)):
        dq[i] = phi * a[i] * q[i]
        dp[i] = 1.0 * p[i]


@field
def energy(params, t, y, work):
    """H = ½((p, p) + φ(q, Aq)); with ε = 0 it is ½ Σ a_k F_k on T*S^(n−1)."""
    n, a = len(y) // 2, section(params, LAYOUT, "a")
    kinetic, potential = y[n] * y[n], a[0] * y[0] * y[0]
    for i in range(1, n):
        kinetic += y[n + i] * y[n + i]
        potential += a[i] * y[i] * y[i]
    return 0.5 * (kinetic + strength(params, t) * potential)


def uhlenbeck(k: int) -> Recorded:
    """F_k = q_k² + Σ_{j≠k} (q_k p_j − q_j p_k)²/(a_k − a_j)."""

    @field
    def integral(params, t, y, work):
        n, a = len(y) // 2, section(params, LAYOUT, "a")
        total = y[k] * y[k]
        for j in range(n):
            if j != k:
                momentum = y[k] * y[n + j] - y[j] * y[n + k]
                total += momentum * momentum / (a[k] - a[j])
        return total

    return integral


def initial(n: int = 3) -> Array:
    """Return a state on T*S^(n−1)."""
    q = np.cos(0.4 + 1.3 * np.arange(n))
    q /= np.linalg.norm(q)
    p = np.sin(1.0 + 2.1 * np.arange(n))
    return np.concatenate([q, p - q * (q @ p)])


def problem(a: Sequence[float] = (0.5, 1.3, 2.6), season: float = 0.0) -> Problem:
    """Return the system of Neumann, H = ½(p, p) + ½φ(t)(q, Aq) on |q| = 1, A = diag(a).

    φ = 1 + ε cos 2t. Conserved with ε = 0: H and the n integrals F_k of K. Uhlenbeck, quadratic in
    p, with Σ F_k = 1 on T*S^(n−1); a_1, …, a_n are different. Forms: ODE, Hamiltonian (separable),
    splitting.

    Parameters
    ----------
    a : sequence of n ≥ 2 numbers
    season : float
        ε.

    References
    ----------
    C. Neumann, J. reine angew. Math. 56 (1859) 46; J. Moser, *Geometry of quadrics and spectral
    theory*, The Chern Symposium 1979, Springer 1980, 147.
    """
    n, space = len(a), TangentSphere(len(a), ("q", "p"))
    integrals = {"energy": energy, **{f"F{k + 1}": uhlenbeck(k) for k in range(n)}}
    return Problem(
        name=f"neumann-{n}",
        space=space,
        params=packed(LAYOUT, season=season, a=a).data,
        field=motion,
        hamiltonian=space.hamiltonian(gradients, separable=True),
        splitting=natural_on_sphere(potential_gradient),
        invariants={} if season else integrals,
        measure=Measure(),
        parameters={"a": list(a), "season": season},
    )
