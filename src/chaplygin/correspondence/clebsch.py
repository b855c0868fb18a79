"""The Hamiltonised Veselova problem is Neumann's system, the Hamiltonised sphere Clebsch's.

Both in any dimension. In spheroconical coordinates the flows in τ live on −4λPμ² = R(λ), those of the
Neumann family on 4P μ² = −N(λ): where N(0) = 0, N = λR, the differentials λ^j dλ/√(−λPR) of the
angles are the same, and so are the rates of the commuting flows r_j and N_j. So, with q = γ and the
constant σ = (p̃, Ap̃),

    v = Ap̃ − (γ, Ap̃)γ,   p̃ = A⁻¹v − ((γ, A⁻¹v)/U) A⁻¹γ

takes the level (p̃, Ap̃) = σ of T*S^(n−1) to the level N_0 = 0 of Neumann's family with that σ, the
Veselova flow to Neumann's in the time D²τ, and the flow of the sphere, which is
½(−1)ⁿDr_0/Πa − ½r_(n−2), to Clebsch's with weights x = −1, y = D in the time τ itself. For Veselova
this is Knörrer's theorem on the Gauss map of geodesics.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi

from ..ball.sphere import ChaplyginSphere
from ..integrable import factors
from ..manifold import Array
from ..related.clebsch import clebsch_problem, neumann_problem
from ..veselova.body import Veselova
from .correspondence import Correspondence

__all__ = ["to_clebsch", "to_neumann"]


@gi.observable
def own_time(params: Any, t: Any, y: Any, work: Any) -> Any:
    """1: the times are the same."""
    return 1.0 + 0.0 * y[0]


@gi.observable
def squared_time(params: Any, t: Any, y: Any, work: Any) -> Any:
    """D²."""
    D, _, _ = factors(params, len(y) // 2)
    return D[0] * D[0] + 0.0 * y[0]


def to_neumann(body: Veselova, y: Any) -> Correspondence:
    """Return the correspondence of the Hamiltonised Veselova problem and Neumann's system.

    Parameters
    ----------
    body : Veselova
    y : array_like
        A state (γ, p̃); its (p̃, Ap̃) becomes the strength σ, and only states with the same correspond.
    """
    source = body.hamiltonized()
    forward, backward, sigma = _maps(source, y)
    target = neumann_problem(body.a, sigma)
    return Correspondence("neumann", source, target, forward, backward, squared_time)


def to_clebsch(sphere: ChaplyginSphere, y: Any) -> Correspondence:
    """Return the correspondence of the Hamiltonised sphere and Clebsch's system.

    Parameters
    ----------
    sphere : ChaplyginSphere
        With the special operator.
    y : array_like
        A state (γ, p̃); its (p̃, Ap̃) becomes the strength σ, and only states with the same correspond.

    Raises
    ------
    geomint.DomainError
        For a sphere whose operator is not the special one.
    """
    source = sphere.hamiltonized()
    forward, backward, sigma = _maps(source, y)
    target = clebsch_problem(source.parameters["a"], sigma, -1.0, sphere.D)
    return Correspondence("clebsch", source, target, forward, backward, own_time)


def _maps(source: gi.Problem, y: Any) -> tuple[Any, Any, float]:
    """Return Φ, its inverse and σ at that state."""
    a = np.array(source.parameters["a"])
    n = len(a)

    def forward(state: Array) -> Array:
        gamma, ap = state[:n], a * state[n:]
        return np.concatenate([gamma, ap - (gamma @ ap) * gamma])

    def backward(state: Array) -> Array:
        gamma, bv = state[:n], state[n:] / a
        b = gamma / a
        return np.concatenate([gamma, bv - (gamma @ bv) / (gamma @ b) * b])

    p = source.canonical(y)[n:]
    return forward, backward, float(p @ (a * p))
