"""Momenta of a moving ball with their rates, and a convention that several claims turn on."""

from __future__ import annotations

from .algebra import Array, apply, wedge
from .points import Point

__all__ = ["CONVENTION", "contact_momentum", "space_momentum"]

CONVENTION = "i_X w = −dH with dp∧dq as in (OMEGA); as printed with the convention i_X w = w(·, X)"


def space_momentum(
    point: Point, inertia: Array, omega: Array, omega_dot: Array
) -> tuple[Array, Array]:
    """Return M = Ad_g(Iω) and Ṁ, by the product rule alone."""
    g, g_dot = point.g, point.g @ omega
    body, body_dot = apply(inertia, omega), apply(inertia, omega_dot)
    rate = g_dot @ body @ g.T + g @ body_dot @ g.T + g @ body @ g_dot.T
    return g @ body @ g.T, rate


def contact_momentum(
    point: Point, inertia: Array, omega: Array, omega_dot: Array
) -> tuple[Array, Array]:
    """Return k = Iω + D(ωγ)∧γ and k̇, with γ̇ from γ = g⁻¹Γ and ġ = gω."""
    gamma, gamma_dot = point.gamma, (point.g @ omega).T @ point.Gamma
    u, u_dot = omega @ gamma, omega_dot @ gamma + omega @ gamma_dot
    k = apply(inertia, omega) + point.D * wedge(u, gamma)
    return k, apply(inertia, omega_dot) + point.D * (wedge(u_dot, gamma) + wedge(u, gamma_dot))
