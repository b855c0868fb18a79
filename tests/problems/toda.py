"""Toda's lattice: particles on a ring, exponential springs, as many integrals as particles."""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi
from geomint.arguments import Array

__all__ = ["initial", "problem"]


@gi.helper
def spring(params: Any, q: Any, k: int) -> Any:
    """e^(ρ (q_k − q_(k+1))), from the last particle to the first."""
    n = len(q)
    return gi.exp(params[0] * (q[k] - q[(k + 1) % n]))


@gi.field
def force(params: Any, t: Any, q: Any, out: Any, work: Any) -> None:
    """q̈_k = e^(ρ (q_(k−1) − q_k)) − e^(ρ (q_k − q_(k+1)))."""
    n = len(q)
    before = spring(params, q, n - 1)
    for k in range(n):
        after = spring(params, q, k)
        out[k] = before - after
        before = after


@gi.field
def motion(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """q̇ = p, ṗ by the springs."""
    n = len(y) // 2
    for k in range(n):
        out[k] = 1.0 * y[n + k]
    force(params, t, gi.part(y, 0, n), gi.part(out, n, n), work)


@gi.field
def momentum(params: Any, t: Any, y: Any, work: Any) -> Any:
    """Σ p_k."""
    n = len(y) // 2
    total = y[n] + y[n + 1]
    for k in range(2, n):
        total += y[n + k]
    return total


@gi.field
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """H = Σ (½ p_k² + e_k/ρ), e_k = e^(ρ (q_k − q_(k+1)))."""
    n = len(y) // 2
    total = 0.0 * y[0]
    for k in range(n):
        total += 0.5 * y[n + k] * y[n + k] + spring(params, gi.part(y, 0, n), k) / params[0]
    return total


@gi.field
def cubic(params: Any, t: Any, y: Any, work: Any) -> Any:
    """Σ (ρ p_k³ + 3 e_k (p_k + p_(k+1))): a multiple of tr L³ of Flaschka's matrix."""
    n, rho = len(y) // 2, params[0]
    total = 0.0 * y[0]
    for k in range(n):
        p, after = y[n + k], y[n + (k + 1) % n]
        total += rho * p * p * p + 3.0 * spring(params, gi.part(y, 0, n), k) * (p + after)
    return total


@gi.field
def quartic(params: Any, t: Any, y: Any, work: Any) -> Any:
    """Σ (ρ² p_k⁴ + 4ρ e_k (p_k² + p_k p_(k+1) + p_(k+1)²) + 2 e_k² + 4 e_k e_(k+1)): of tr L⁴."""
    n, rho = len(y) // 2, params[0]
    total = 0.0 * y[0]
    for k in range(n):
        p, after, e = y[n + k], y[n + (k + 1) % n], spring(params, gi.part(y, 0, n), k)
        total += rho * rho * p * p * p * p + 4.0 * rho * e * (p * p + p * after + after * after)
        total += 2.0 * e * e + 4.0 * e * spring(params, gi.part(y, 0, n), (k + 1) % n)
    return total


def initial(n: int = 3) -> Array:
    """Return a state without momentum in all."""
    q, p = 0.5 * np.sin(1.0 + 1.7 * np.arange(n)), np.cos(0.4 + 2.3 * np.arange(n))
    return np.concatenate([q, p - p.mean()])


def problem(n: int = 3, stiffness: float = 1.0) -> gi.Problem:
    """Return n ≥ 3 particles of mass 1 on a ring, H = Σ (½ p_k² + e^(ρ (q_k − q_(k+1)))/ρ).

    Integrable: traces of powers of Flaschka's periodic Jacobi matrix L with diagonal √ρ p_k and
    e_k^½ beside it are conserved, so that no motion is chaotic and all Lyapunov exponents are 0.
    Parameter: ρ. Forms: ODE and splitting.

    References
    ----------
    M. Toda, J. Phys. Soc. Japan 22 (1967) 431; M. Hénon, Phys. Rev. B 9 (1974) 1921; H. Flaschka,
    Phys. Rev. B 9 (1974) 1924.
    """
    integrals = {"energy": energy, "momentum": momentum, "cubic": cubic, "quartic": quartic}
    return gi.Problem(
        name=f"toda-{n}",
        pieces=(("q", n), ("p", n)),
        params=np.array([stiffness]),
        field=motion,
        splitting=gi.natural_in_space(force),
        invariants=integrals,
        measure=gi.Measure(),
        symplectic_form=gi.SymplecticForm(),
        parameters={"n": n, "stiffness": stiffness},
    )
