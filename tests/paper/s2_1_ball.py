"""Sections 2.1 and 2.2, Chaplygin sphere: kinematics and dynamics."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from .algebra import (
    Array,
    apply,
    bracket,
    coordinates,
    inner,
    null_space,
    project,
    rank,
    skew,
    wedge,
)
from .calculus import derivative, gradient
from .claim import Section, Sides
from .equations import log_rho
from .momenta import contact_momentum, space_momentum
from .motion import general_motion
from .points import Point, horizontal_rotation

__all__ = ["claim"]

claim = Section("2.1, 2.2 Kinematics and dynamics")

claim.unchecked("text:velocities", "ω = g⁻¹ġ, Ω = ġg⁻¹, V = ṙ", "305–307", "definition")


@claim("KF", "⟨X, Y⟩ = −½ tr XY: invariant, and E_i∧E_j is orthonormal", "309–314")
def killing_form(point: Point) -> Sides:
    X, Y, g = point.skew("X"), point.skew("Y"), point.g
    n = point.n
    basis = [skew(e, n) for e in np.eye(n * (n - 1) // 2)]
    gram = [[-0.5 * np.trace(e @ f) for f in basis] for e in basis]
    left = -0.5 * np.trace((g @ X @ g.T) @ (g @ Y @ g.T))
    return [left, *np.ravel(gram)], [-0.5 * np.trace(X @ Y), *np.ravel(np.eye(len(basis)))]


@claim(
    "ch-lagr",
    "L = ½κ((ω̇, V̇), (ω̇, V̇)) = ½⟨Iω, ω⟩ + ½m(V, V)",
    "316–325",
    misprint="L = ½κ((ω, V), (ω, V)), without dots",
)
def lagrangian(point: Point, corrected: bool) -> Sides:
    """κ is the kinetic energy of the ball's mass points, twice: Iω = Jω + ωJ, J = Σ m y yᵀ."""
    n, count = point.n, point.n + 2
    body = point.normal("points", count, n)
    body -= body.mean(axis=0)
    mass = point.m / count
    J = mass * body.T @ body

    def kappa(omega: Array, V: Array) -> Any:
        return mass * sum(np.sum((V + point.g @ omega @ y) ** 2) for y in body)

    moving = general_motion(point)
    omega, V = moving.omega, moving.V
    left = kappa(omega, V) if corrected else kappa(moving.omega_dot, moving.V_dot)
    return 0.5 * left, 0.5 * inner(J @ omega + omega @ J, omega) + 0.5 * point.m * (V @ V)


@claim("ch-constr", "V − ρΩΓ = 0: the velocity of the contact point vanishes", "327–334")
def rolling(point: Point) -> Sides:
    """Compare: the material point at r − ρΓ has the velocity ġX + ṙ with gX = −ρΓ."""
    X = -point.rho * (point.g.T @ point.Gamma)
    V = point.normal("V", point.n)
    return (point.g @ point.omega) @ X + V, V - point.rho * (point.Omega @ point.Gamma)


@claim("text:right-invariance", "𝒟 = {V = ρ Ad_g(ω)Γ} is right-invariant", "336–342")
def right_invariance(point: Point) -> Sides:
    h = np.linalg.qr(point.normal("h", point.n, point.n))[0]
    moved = point.g @ h
    omega = h.T @ point.omega @ h
    left = moved @ omega @ moved.T @ point.Gamma
    return point.rho * left, point.rho * (point.Omega @ point.Gamma)


@claim("text:components", "ṙ_i = ρΩ_in, i < n, ṙ_n = 0, with Ω_ij = ⟨Ω, E_i∧E_j⟩", "344–350")
def components(point: Point) -> Sides:
    Omega, E = point.Omega, np.eye(point.n)
    right = [point.rho * inner(Omega, wedge(E[i], E[-1])) for i in range(point.n - 1)]
    return point.rho * (Omega @ point.Gamma), [*right, 0.0]


def lagrangian_on_constraints(point: Point, inertia: Array, omega: Array) -> Any:
    """Return L of (ch-lagr) with V from (ch-constr)."""
    V = point.rho * (point.g @ omega @ point.g.T @ point.Gamma)
    return 0.5 * inner(apply(inertia, omega), omega) + 0.5 * point.m * (V @ V)


@claim("red:lag", "L_red = ½⟨Iω, ω⟩ + ½mρ²|Ad_g(ω)Γ|² = ½⟨κ_red ω, ω⟩", "352–361")
def reduced_lagrangian(point: Point) -> Sides:
    spinning = 0.5 * inner(apply(point.general, point.omega), point.omega)
    printed = spinning + 0.5 * point.D * np.sum((point.Omega @ point.Gamma) ** 2)
    kappa = apply(point.metric(point.general, point.gamma), point.omega)
    actual = lagrangian_on_constraints(point, point.general, point.omega)
    return [printed, printed], [actual, 0.5 * inner(kappa, point.omega)]


@claim(
    "remark:rubber", "the no-twist constraints Ω_ij = 0, i < j < n, are right-invariant", "363–369"
)
def rubber(point: Point) -> Sides:
    h = np.linalg.qr(point.normal("h", point.n, point.n))[0]
    omega, moved = h.T @ point.omega @ h, point.g @ h
    i, j = np.triu_indices(point.n - 1, 1)
    return (moved @ omega @ moved.T)[i, j], point.Omega[i, j]


@claim("c1", "Ṁ = −ρ Λ∧Γ, M = Ad_g(Iω)", "371–383")
def c1(point: Point) -> Sides:
    moving = general_motion(point)
    rate = space_momentum(point, point.general, moving)[1]
    return rate, -point.rho * wedge(moving.Lambda, point.Gamma), moving.size


@claim("c2", "m V̇ = Λ", "377")
def c2(point: Point) -> Sides:
    moving = general_motion(point)
    return point.m * moving.V_dot, moving.Lambda, moving.size


@claim("c3", "ġ = Ω·g", "378")
def c3(point: Point) -> Sides:
    return point.g @ point.omega, point.Omega @ point.g


claim.unchecked("c4", "ṙ = V", "379", "definition of V")


def omega_space_dot(point: Point) -> Array:
    """Return Ω̇ = d/dt(gωg⁻¹) by the product rule."""
    moving = general_motion(point)
    g, g_dot = point.g, point.g @ moving.omega
    turned = g_dot @ moving.omega @ g.T + g @ moving.omega @ g_dot.T
    return np.asarray(turned + g @ moving.omega_dot @ g.T)


@claim("text:Lambda", "Λ = mρ Ω̇Γ", "385–386")
def reaction(point: Point) -> Sides:
    moving = general_motion(point)
    right = point.m * point.rho * (omega_space_dot(point) @ point.Gamma)
    return moving.Lambda, right, moving.size


@claim("ch", "Λ∧Γ = mρ(Ω̇Γ)∧Γ = mρ(Ω̇ Γ⊗Γ + Γ⊗Γ Ω̇) = mρ pr_𝔥(Ω̇)", "387–394")
def ch(point: Point) -> Sides:
    Omega_dot, Gamma = omega_space_dot(point), point.Gamma
    square, factor = np.outer(Gamma, Gamma), point.m * point.rho
    basis = [coordinates(wedge(e, Gamma)) for e in np.eye(point.n)[:-1]]
    orthogonal = skew(np.array(basis).T @ (np.array(basis) @ coordinates(Omega_dot)), point.n)
    left = wedge(general_motion(point).Lambda, Gamma)
    right = [
        wedge(Omega_dot @ Gamma, Gamma),
        Omega_dot @ square + square @ Omega_dot,
        orthogonal,
    ]
    return np.stack([left] * 3), factor * np.stack(right), general_motion(point).size


@claim("text:projection", "pr_𝔥(ξ) = (ξΓ)∧Γ is the orthogonal projection onto 𝔥 = Rⁿ∧Γ", "395–398")
def projection(point: Point) -> Sides:
    X, Y, Gamma = point.skew("X"), point.skew("Y"), point.Gamma
    P, Q = project(X, Gamma), project(Y, Gamma)
    inside = wedge(point.normal("x", point.n), Gamma)
    left = [*coordinates(project(P, Gamma)), *coordinates(project(inside, Gamma)), inner(P, Y)]
    return left, [*coordinates(P), *coordinates(inside), inner(X, Q)]


@claim("hg", "Ad_{g⁻¹}(𝔥) = Rⁿ∧γ", "404–408")
def hg(point: Point) -> Sides:
    rows = [coordinates(point.g.T @ wedge(e, point.Gamma) @ point.g) for e in np.eye(point.n)]
    others = [coordinates(wedge(e, point.gamma)) for e in np.eye(point.n)]
    return [rank([*rows, *others]), rank(rows)], [rank(others), point.n - 1]


@claim("oO", "ω̇ = Ad_{g⁻¹}(Ω̇)", "410–413")
def oO(point: Point) -> Sides:  # noqa: N802 - the label
    moving = general_motion(point)
    return moving.omega_dot, point.g.T @ omega_space_dot(point) @ point.g, moving.size


@claim("text:euler", "Iω̇ = [Iω, ω] − mρ²(ω̇ γ⊗γ + γ⊗γ ω̇)", "414–422")
def euler(point: Point) -> Sides:
    moving, gamma = general_motion(point), point.gamma
    I_omega = apply(point.general, moving.omega)
    square = np.outer(gamma, gamma)
    right = bracket(I_omega, moving.omega)
    right = right - point.D * (moving.omega_dot @ square + square @ moving.omega_dot)
    return apply(point.general, moving.omega_dot), right, moving.size


def kinetic_momentum(point: Point, inertia: Array, omega: Array, gamma: Array) -> Array:
    """Return k of eq. (K)."""
    square = np.outer(gamma, gamma)
    return np.asarray(apply(inertia, omega) + point.D * (omega @ square + square @ omega))


@claim(
    "K",
    "k = Iω + D(ω γ⊗γ + γ⊗γ ω) = κ_red ω, the momentum of L_red and that about the contact point",
    "424–433",
)
def contact(point: Point) -> Sides:
    omega, inertia = point.omega, point.general
    k = kinetic_momentum(point, inertia, omega, point.gamma)
    slope = gradient(
        lambda w: lagrangian_on_constraints(point, inertia, skew(w, point.n)), coordinates(omega)
    )
    # About the contact point: Ad_g(Iω) plus m V∧(r − contact), r − contact = ρΓ.
    V = point.rho * (point.g @ omega @ point.gamma)
    about = point.g @ apply(inertia, omega) @ point.g.T + point.m * wedge(
        V, point.rho * point.Gamma
    )
    return np.stack([k, k]), np.stack([skew(slope, point.n), point.g.T @ about @ point.g])


@claim("PE", "γ̇ = −ωγ", "435–438")
def poisson(point: Point) -> Sides:
    return (point.g @ point.omega).T @ point.Gamma, -point.omega @ point.gamma


@claim("text:identity", "d/dt(ωγ⊗γ + γ⊗γω) = ω̇γ⊗γ + γ⊗γω̇ + [ωγ⊗γ + γ⊗γω, ω]", "439–442")
def identity(point: Point) -> Sides:
    omega, omega_dot, gamma = point.omega, point.skew("rate"), point.gamma
    square = np.outer(gamma, gamma)
    turned = -np.outer(omega @ gamma, gamma) - np.outer(gamma, omega @ gamma)
    left = omega_dot @ square + omega @ turned + turned @ omega + square @ omega_dot
    inside = omega @ square + square @ omega
    return left, omega_dot @ square + square @ omega_dot + bracket(inside, omega)


@claim("ch-red", "k̇ = [k, ω]", "444–449")
def ch_red(point: Point) -> Sides:
    moving = general_motion(point)
    k, rate = contact_momentum(point, point.general, moving)
    return rate, bracket(k, moving.omega), moving.size


claim.unchecked("ch-red2", "ġ = g·ω", "450", "definition of ω")


@claim("text:kinetic-energy", "H_red = ½⟨κ_red⁻¹k, k⟩ = ½⟨k, ω(k)⟩ is the energy", "452–454")
def kinetic_energy(point: Point) -> Sides:
    k = kinetic_momentum(point, point.general, point.omega, point.gamma)
    inverse = np.linalg.inv(point.metric(point.general, point.gamma))
    omega = point.omega_of(point.general, k, point.gamma)
    energy = lagrangian_on_constraints(point, point.general, point.omega)
    return [0.5 * inner(apply(inverse, k), k), 0.5 * inner(k, omega)], [energy, energy]


def ball_divergence(point: Point, on_group: bool = False) -> Sides:
    """Compare div of k̇ = [k, ω] and of ġ = gω, or of γ̇ = −ωγ, with −log ϱ along the flow."""
    n, inertia = point.n, point.general
    gamma, k = point.gamma, kinetic_momentum(point, inertia, point.omega, point.gamma)
    size = len(inertia)

    def velocity(x: Array, gamma: Array) -> Array:
        return point.omega_of(inertia, skew(x, n), gamma)

    def k_dot(x: Array) -> Array:
        return coordinates(bracket(skew(x, n), velocity(x, gamma)))

    x = coordinates(k)
    terms = [derivative(k_dot, x, e)[i] for i, e in enumerate(np.eye(size))]
    if on_group:  # the derivative of ω_i along the left-invariant field of E_i: γ ↦ γ − E_iγ
        for i, e in enumerate(np.eye(size)):
            moved = derivative(lambda z: coordinates(velocity(x, z)), gamma, -skew(e, n) @ gamma)
            terms.append(moved[i])
    else:
        plane = null_space(gamma)
        terms += [t @ derivative(lambda z: -velocity(x, z) @ z, gamma, t) for t in plane]
    turning = -point.omega_of(inertia, k, gamma) @ gamma
    rate = derivative(lambda z: log_rho(point, inertia, z), gamma, turning)
    return sum(terms), -rate, np.sum(np.abs(terms)) + np.linalg.norm(point.omega)


claim(
    "mu", "1/√det(κ_red) Ω^d = 1/√det(I + D pr) Ω^d is an invariant measure on T*SO(n)", "456–464"
)(partial(ball_divergence, on_group=True))


@claim(
    "SO(n-1):red",
    "(k, γ) are coordinates of (T*SO(n))/SO(n−1) = so(n)*×S^(n−1)",
    "466–473",
    n=range(3, 8),
)
def left_reduction(point: Point) -> Sides:
    turned = horizontal_rotation(point) @ point.g
    n = point.n
    size = n * (n - 1) // 2
    left = [*(turned.T @ point.Gamma), size + n - 1]
    return left, [*(point.g.T @ point.Gamma), 2 * size - (n - 1) * (n - 2) // 2]


claim("mu*", "1/√det(I + D pr) Ω_so(n)* ∧ Ω_S^(n−1) is invariant in (k, γ)", "475–483")(
    ball_divergence
)
