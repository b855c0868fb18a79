"""Printed equations that several claims use, character by character; misprints are the claims'."""

from __future__ import annotations

from typing import Any

import numpy as np

from .algebra import Array, inner, skew, wedge
from .calculus import derivative
from .points import Point

__all__ = [
    "extended_energy",
    "extended_field",
    "extended_xi",
    "flow_in_tau",
    "ham_flow",
    "hamiltonian",
    "hamiltonian_tau",
    "log_mu",
    "log_rho",
    "multiplier",
    "ro",
    "special_omega",
    "split",
    "to_tau",
    "u_of",
    "veselova",
    "veselova_hamiltonian",
]


def split(y: Array) -> tuple[Array, Array]:
    """Return γ and p of y = (γ, p)."""
    n = len(y) // 2
    return y[:n], y[n:]


def u_of(point: Point, gamma: Array) -> Any:
    """Return U = (γ, A⁻¹γ)."""
    return gamma @ (gamma / point.a)


def multiplier(point: Point, gamma: Array) -> Any:
    """Return 𝒩 = 1/(D √(A⁻¹γ, γ)), eq. (CM)."""
    return 1.0 / (point.D * np.sqrt(u_of(point, gamma)))


def extended_xi(point: Point, inertia: Array, y: Array) -> tuple[Array, Array]:
    """Return ξ and ω = I⁻¹(γ∧ξ) with p = ξ − D I⁻¹(γ∧ξ)γ, eq. (veza), for any γ and p."""
    gamma, p = split(y)
    n = len(gamma)
    inverse = np.linalg.inv(inertia)

    def omega(xi: Array) -> Array:
        return skew(inverse @ wedge(gamma, xi)[np.triu_indices(n, 1)], n)

    matrix = np.array([e - point.D * (omega(e) @ gamma) for e in np.eye(n)]).T
    xi = np.linalg.solve(matrix, p)
    return xi, omega(xi)


def special_omega(point: Point, y: Array) -> Array:
    """Return ω = (A⁻¹γ∧p − γ∧Ap/D)/(D(γ, A⁻¹γ)), after eq. (xi)."""
    gamma, p = split(y)
    top = wedge(gamma / point.a, p) - wedge(gamma, point.a * p) / point.D
    return np.asarray(top / (point.D * u_of(point, gamma)))


def ro(point: Point, y: Array) -> Array:
    """Return the right-hand sides of eqs. (ro1), (ro2)."""
    gamma, p = split(y)
    D, a = point.D, point.a
    u, b, ap = u_of(point, gamma), gamma / a, a * p
    first = (
        p / D
        - (p @ gamma) / (D * u) * b
        + (gamma @ ap) / (D**2 * u) * gamma
        - (gamma @ gamma) / (D**2 * u) * ap
    )
    second = (
        (p @ b) / (D * u) * p
        - (p @ p) / (D * u) * b
        + (p @ ap) / (D**2 * u) * gamma
        - (p @ gamma) / (D**2 * u) * ap
    )
    return np.concatenate([first, second])


def hamiltonian(point: Point, y: Array) -> Any:
    """Return H(γ, p), eq. (hamiltonian)."""
    gamma, p = split(y)
    D, u = point.D, u_of(point, gamma)
    return (D * u * (p @ p) - p @ (point.a * p)) / (2.0 * D**2 * u)


def hamiltonian_tau(point: Point, y: Array) -> Any:
    """Return H(γ, p̃), eq. (hamiltonian*)."""
    gamma, p = split(y)
    return 0.5 * (point.D * u_of(point, gamma) * (p @ p) - p @ (point.a * p))


def ham_flow(point: Point, y: Array) -> Array:
    """Return the right-hand sides of eqs. (ham_q), (ham_p)."""
    gamma, p = split(y)
    D, a = point.D, point.a
    u, g2 = u_of(point, gamma), gamma @ gamma
    du, ap = D * u, a * p
    first = du * p - ap + (gamma @ ap) / g2 * gamma - du * (p @ gamma) / g2 * gamma
    second = (
        -D * (p @ p) * (gamma / a)
        + (p @ ap) / g2 * gamma
        - (gamma @ ap) / g2 * p
        + du * (p @ gamma) / g2 * p
    )
    return np.concatenate([first, second])


def veselova(point: Point, y: Array, corrected: bool = True) -> Array:
    """Return the right-hand sides of eqs. (extended1), (extended2), the latter's sign corrected."""
    gamma, p = split(y)
    u, ap = u_of(point, gamma), point.a * p
    first = (-(p @ (point.a * gamma)) * gamma + (gamma @ gamma) * ap) / u
    second = ((p @ ap) * gamma - (p @ gamma) * ap) / u
    return np.concatenate([first, -second if corrected else second])


def veselova_hamiltonian(point: Point, y: Array) -> Any:
    """Return 𝓗(γ, p̃) = D²/2 (Ap̃, p̃), eq. (ham:ves)."""
    p = split(y)[1]
    return 0.5 * point.D**2 * (p @ (point.a * p))


def log_rho(point: Point, inertia: Array, gamma: Array) -> Any:
    """Return log 1/√det(I + D pr), eq. (mu)."""
    return -0.5 * np.log(np.linalg.det(point.metric(inertia, gamma)))


def extended_field(point: Point, inertia: Array, y: Array) -> Array:
    """Return the right-hand sides of eqs. (r1), (r2), with ξ by eq. (veza) for any γ, p."""
    omega = extended_xi(point, inertia, y)[1]
    gamma, p = split(y)
    return np.concatenate([-omega @ gamma, -omega @ p])


def extended_energy(point: Point, inertia: Array, y: Array) -> Any:
    """Return H of eq. (red:ham), with ξ by eq. (veza) for any γ, p."""
    return 0.5 * inner(wedge(*split(y)), extended_xi(point, inertia, y)[1])


def log_mu(point: Point, y: Array) -> Any:
    """Return log μ of eq. (DENSITY)."""
    return -0.5 * (point.n - 2) * np.log(u_of(point, y[: point.n]))


def to_tau(point: Point, y: Array) -> Array:
    """Return (γ, p̃) of (γ, p), eq. (mapping)."""
    gamma, p = split(y)
    return np.concatenate([gamma, multiplier(point, gamma) * p])


def flow_in_tau(point: Point, y: Array, rate: Array) -> Array:
    """Return d/dτ of (γ, p̃) for a rate d/dt of (γ, p): d/dτ = 𝒩⁻¹ d/dt."""
    return np.asarray(
        derivative(lambda z: to_tau(point, z), y, rate) / multiplier(point, split(y)[0])
    )
