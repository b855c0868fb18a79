"""The almost symplectic forms on T*SO(n), left-trivialised, and what reduces from them.

A tangent vector at (g, k) is (η, κ) with η = g⁻¹δg and κ = δk. With Ω = dp∧dq,

    Ω(Y, Z) = ⟨κ_Y, η_Z⟩ − ⟨κ_Z, η_Y⟩ − ⟨k, [η_Y, η_Z]⟩.

The form of momentum and curvature is Ξ(Y, Z) = −D(ωγ, [η_Y, η_Z]γ); its truncation to one that
vanishes on the directions of SO(n−1) is Ξ̃(Y, Z) = D(η_Zγ, ωη_Yγ).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .algebra import Array, bracket, inner, project
from .calculus import gradient, slope_at_zero
from .equations import extended_energy
from .momenta import true_rates
from .motion import zero_momentum_motion
from .points import Point
from .two_forms import canonical, tangent_basis

__all__ = [
    "CONVENTION",
    "Vector",
    "almost_hamiltonian_on_bundle",
    "canonical_group_form",
    "closed_form",
    "curvature_form",
    "energy_slope",
    "group_exterior_derivative",
    "reduced_form",
    "truncated_form",
]

CONVENTION = "i_X w = −dH with dp∧dq as in (OMEGA); as printed with the convention i_X w = w(·, X)"

Vector = tuple[Array, Array]


def canonical_group_form(k: Array, Y: Vector, Z: Vector) -> Any:
    """Return Ω(Y, Z)."""
    return inner(Y[1], Z[0]) - inner(Z[1], Y[0]) - inner(k, bracket(Y[0], Z[0]))


def curvature_form(point: Point, omega: Array, Y: Vector, Z: Vector) -> Any:
    """Return Ξ(Y, Z)."""
    gamma = point.gamma
    return -point.D * ((omega @ gamma) @ (bracket(Y[0], Z[0]) @ gamma))


def truncated_form(D: float, gamma: Array, omega: Array, Y: Vector, Z: Vector) -> Any:
    """Return Ξ̃(Y, Z)."""
    return D * ((Z[0] @ gamma) @ (omega @ (Y[0] @ gamma)))


def closed_form(factor: float, gamma: Array, k: Array, Y: Vector, Z: Vector) -> Any:
    """Return the form factor·⟨k_v, [η_Y, η_Z]⟩ of the vertical part k_v of k."""
    return factor * inner(k - project(k, gamma), bracket(Y[0], Z[0]))


def reduced_form(D: float, y: Array, omega: Array, Y: Array, Z: Array) -> Any:
    """Return w_0(Y, Z) on T*S^(n−1): dp∧dγ plus what Ξ̃ becomes, with δγ = −ηγ."""
    n = len(y) // 2
    return canonical(y, Y, Z) + D * (Z[:n] @ (omega @ Y[:n]))


def group_exterior_derivative(
    form: Callable[[Array, Array, Vector, Vector], Any],
    g: Array,
    k: Array,
    Y: Vector,
    Z: Vector,
    W: Vector,
) -> tuple[Any, Any]:
    """Return dβ(Y, Z, W) on T*SO(n), for vectors extended as left-invariant fields, and its size."""

    def along(A: Vector, B: Vector, C: Vector) -> Any:
        def moved(s: Any) -> Any:
            return form(g + s * (g @ A[0]), k + s * A[1], B, C)

        turned = (bracket(A[0], B[0]), 0.0 * k)
        return slope_at_zero(moved) - form(g, k, turned, C)

    terms = [along(Y, Z, W), along(Z, W, Y), along(W, Y, Z)]
    return sum(terms), sum(abs(term) for term in terms)


def energy_slope(point: Point, inertia: Array, k: Array, Y: Vector) -> Any:
    """Return dH(Y) of H = ½⟨k, ω(k, γ)⟩ on T*SO(n)."""
    gamma = point.gamma

    def along(s: Any) -> Any:
        momentum, vertical = k + s * Y[1], gamma - s * (Y[0] @ gamma)
        return 0.5 * inner(momentum, point.omega_of(inertia, momentum, vertical))

    return slope_at_zero(along)


def almost_hamiltonian_on_bundle(point: Point, convention: bool) -> tuple[Any, Any]:
    """Return w(X, Y), or w(Y, X) with the convention, and dH(Y) for all tangent Y."""
    y, omega = point.state, zero_momentum_motion(point).omega
    X, basis = np.concatenate(true_rates(point, point.general)), tangent_basis(y)
    left = [reduced_form(point.D, y, omega, *((Y, X) if convention else (X, Y))) for Y in basis]
    slope = gradient(lambda z: extended_energy(point, point.general, z), y)
    return left, basis @ slope
