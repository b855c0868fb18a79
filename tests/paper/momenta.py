"""Momenta with their rates along the true motion: of the ball, and of the Veselova problem."""

from __future__ import annotations

import numpy as np

from .algebra import Array, apply, null_space, wedge
from .motion import BallMotion, ball_motion, constrained_rotation, zero_momentum_motion
from .points import Point

__all__ = ["contact_momentum", "space_momentum", "true_rates", "veselova_rates"]


def space_momentum(point: Point, inertia: Array, moving: BallMotion) -> tuple[Array, Array]:
    """Return M = Ad_g(Iω) and Ṁ, by the product rule alone."""
    omega, omega_dot = moving.omega, moving.omega_dot
    g, g_dot = point.g, point.g @ omega
    body, body_dot = apply(inertia, omega), apply(inertia, omega_dot)
    rate = g_dot @ body @ g.T + g @ body_dot @ g.T + g @ body @ g_dot.T
    return g @ body @ g.T, rate


def contact_momentum(point: Point, inertia: Array, moving: BallMotion) -> tuple[Array, Array]:
    """Return k = Iω + D(ωγ)∧γ and k̇, with γ̇ from γ = g⁻¹Γ and ġ = gω."""
    omega, omega_dot = moving.omega, moving.omega_dot
    gamma, gamma_dot = point.gamma, (point.g @ omega).T @ point.Gamma
    u, u_dot = omega @ gamma, omega_dot @ gamma + omega @ gamma_dot
    k = apply(inertia, omega) + point.D * wedge(u, gamma)
    return k, apply(inertia, omega_dot) + point.D * (wedge(u_dot, gamma) + wedge(u, gamma_dot))


def true_rates(point: Point, inertia: Array) -> tuple[Array, Array]:
    """Return (γ̇, ṗ) of the rolling ball at k = γ∧p, from d'Alembert's principle."""
    if inertia is point.general or inertia is point.special:
        moving = zero_momentum_motion(point, inertia is point.special)
    else:
        omega = point.omega_of(inertia, wedge(point.gamma, point.p), point.gamma)
        moving = ball_motion(point, inertia, omega)
    gamma_dot = (point.g @ moving.omega).T @ point.Gamma
    k, k_dot = contact_momentum(point, inertia, moving)
    return gamma_dot, -k_dot @ point.gamma - k @ gamma_dot


def veselova_rates(point: Point) -> Array:
    """Return (γ̇, ṗ) of the LR system with r = 1 and the operator (inertia_tensor), from d'Alembert.

    γ = e_1, so the rotation is turned to have the point's γ as its first row; p = ∂L/∂γ̇.
    """
    g = np.roll(point.g, 1, axis=0)
    n, E = point.n, np.eye(point.n)
    turned = point.with_(g=g)
    inertia = point.special_veselova
    # p = −(𝓘w)γ for w = γ∧γ̇; here γ̇ is found from p by a solve, not by the paper's formula
    basis = null_space(point.gamma)
    images = np.array([-apply(inertia, wedge(point.gamma, v)) @ point.gamma for v in basis])
    gamma_dot = np.linalg.lstsq(images.T, point.p, rcond=None)[0] @ basis
    w = wedge(point.gamma, gamma_dot)
    forms = [wedge(E[i], E[j]) for i in range(1, n) for j in range(i + 1, n)]
    rate = constrained_rotation(turned, inertia, w, forms)[0]
    p_dot = -apply(inertia, rate) @ point.gamma - apply(inertia, w) @ gamma_dot
    return np.concatenate([gamma_dot, p_dot])
