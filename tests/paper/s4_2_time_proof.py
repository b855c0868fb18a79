"""Section 4.2, Time reparametrization, end: the proof of Theorem 5 and the remarks after it."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from .algebra import Array, null_space, project, rank, wedge
from .calculus import derivative, gradient
from .claim import Section, Sides, half
from .equations import (
    flow_in_tau,
    ham_flow,
    hamiltonian_tau,
    multiplier,
    ro,
    split,
    to_tau,
    u_of,
)
from .points import Point
from .two_forms import canonical, canonical_bracket, on_tangents

__all__ = ["claim"]

claim = Section("4.2 Time reparametrization")


def multipliers(point: Point, y: Array) -> tuple[Any, Any]:
    """Return λ and μ as printed."""
    gamma, p = split(y)
    g2, u = gamma @ gamma, u_of(point, gamma)
    ap = point.a * p
    return (ap @ p) / (2 * g2), (point.D * u * (p @ gamma) - ap @ gamma) / g2


@claim(
    "proof:main:equations",
    "γ′ = ∂H*/∂p̃, p̃′ = −∂H*/∂γ, H* = H − λψ_1 − μψ_2, and both lines after it",
    "1012–1028",
    everywhere=True,
)
def multiplier_equations(point: Point) -> Sides:
    y = point.state
    gamma, p = split(y)
    D, a, u = point.D, point.a, u_of(point, gamma)
    lam, mu = multipliers(point, y)

    def star(z: Array) -> Any:
        x, w = split(z)
        return hamiltonian_tau(point, z) - lam * (x @ x) - mu * (x @ w)

    slope = gradient(star, y)
    first = D * u * p - a * p - mu * gamma
    second = -D * (p @ p) * (gamma / a) + 2 * lam * gamma + mu * p
    return np.concatenate([slope[point.n :], -slope[: point.n]]), np.concatenate([first, second])


@claim(
    "proof:main:lambda",
    "λ = (Ap̃, p̃)/(2(γ, γ)), μ = (D(γ, A⁻¹γ)(p̃, γ) − (Ap̃, γ))/(γ, γ): ψ_1, ψ_2 are integrals",
    "1026–1036",
    everywhere=True,
)
def multipliers_keep_constraints(point: Point) -> Sides:
    gamma, p = split(point.state)
    first, second, slope = starred_flow(point)
    return [gamma @ first, first @ p + gamma @ second], [0.0, 0.0], abs(p @ slope[point.n :])


def starred_flow(point: Point) -> tuple[Array, Array, Array]:
    """Return ∂H*/∂p̃ and −∂H*/∂γ with the multipliers as printed, and the gradient of H."""
    gamma, p = split(point.state)
    lam, mu = multipliers(point, point.state)
    slope = gradient(lambda z: hamiltonian_tau(point, z), point.state)
    first = slope[point.n :] - mu * gamma
    return first, -slope[: point.n] + 2 * lam * gamma + mu * p, slope


def with_multipliers(point: Point) -> Sides:
    """Compare (ham_q), (ham_p) with ∂H*/∂p̃ and −∂H*/∂γ."""
    return ham_flow(point, point.state), np.concatenate(starred_flow(point)[:2])


claim(
    "ham_q",
    "γ′ = D(A⁻¹γ, γ)p̃ − Ap̃ + (γ, Ap̃)γ/(γ, γ) − D(γ, A⁻¹γ)(p̃, γ)γ/(γ, γ)",
    "1037–1039",
    everywhere=True,
)(half(with_multipliers, 0))
claim(
    "ham_p",
    "p̃′ = −D(p̃, p̃)A⁻¹γ + (p̃, Ap̃)γ/(γ, γ) − (γ, Ap̃)p̃/(γ, γ) + D(γ, A⁻¹γ)(p̃, γ)p̃/(γ, γ)",
    "1040–1045",
    everywhere=True,
)(half(with_multipliers, 1))


def star(point: Point, y: Array) -> Array:
    """Return γ̇ of eq. (*)."""
    gamma, p = split(y)
    D, u, g2, ap = point.D, u_of(point, gamma), gamma @ gamma, point.a * p
    first = p / D - ap / (D**2 * u)
    return np.asarray(
        first + (gamma @ ap) / (D**2 * u * g2) * gamma - (p @ gamma) / (D * g2) * gamma
    )


@claim(
    "proof:main:inverse",
    "γ̇·D√(γ, A⁻¹γ) = (1/(D√(γ, A⁻¹γ)))(D(A⁻¹γ, γ)p − Ap + …)",
    "1047–1055",
    everywhere=True,
)
def inverse_mapping(point: Point) -> Sides:
    y = point.state
    gamma, p = split(y)
    D, u, g2, ap = point.D, u_of(point, gamma), gamma @ gamma, point.a * p
    inside = D * u * p - ap + (gamma @ ap) / g2 * gamma - D * u * (p @ gamma) / g2 * gamma
    right = inside / (D * np.sqrt(u))
    return ham_flow(point, to_tau(point, y))[: point.n], right


@claim(
    "*",
    "γ̇ = p/D − Ap/(D²U) + (γ, Ap)γ/(D²U(γ, γ)) − (p, γ)γ/(D(γ, γ)) from (ham_q)",
    "1056–1060",
    everywhere=True,
)
def eq_star(point: Point) -> Sides:
    y = point.state
    rate = ham_flow(point, to_tau(point, y))[: point.n]
    return star(point, y), multiplier(point, point.gamma) * rate


@claim("text:coincide", "(*) coincides with (ro1) on T*S^(n−1)", "1061–1062")
def coincide(point: Point) -> Sides:
    return star(point, point.state), ro(point, point.state)[: point.n]


@claim(
    "***", "dp̃/dτ = ṗ − p(A⁻¹γ, γ̇)/(γ, A⁻¹γ), with the steps before", "1062–1072", everywhere=True
)
def eq_three_stars(point: Point) -> Sides:
    """For any rate (γ̇, ṗ)."""
    n, y, rate = point.n, point.state, point.normal("rate", 2 * point.n)
    gamma, p = split(y)
    u = u_of(point, gamma)
    left = flow_in_tau(point, y, rate)[n:]
    root = derivative(lambda z: 1.0 / np.sqrt(u_of(point, z)), gamma, rate[:n])
    middle = (p * root + rate[n:] / np.sqrt(u)) * np.sqrt(u)
    right = rate[n:] - p * ((gamma / point.a) @ rate[:n]) / u
    return [left, middle], [right, right]


def two_stars(point: Point, y: Array) -> Array:
    """Return ṗ of eq. (**)."""
    gamma, p = split(y)
    D, u, g2, ap, b = point.D, u_of(point, gamma), gamma @ gamma, point.a * p, gamma / point.a
    first = -(p @ p) / (D * u) * b + (p @ ap) / (D**2 * u * g2) * gamma
    return np.asarray(first + (p @ b) / (D * u) * p - (gamma @ p) / (D**2 * u**2) * p)


@claim(
    "**",
    "ṗ = −(p, p)A⁻¹γ/(DU) + (p, Ap)γ/(D²U(γ, γ)) + (p, A⁻¹γ)p/(DU) − (γ, p)p/(D²U²)",
    "1074–1081",
    everywhere=True,
)
def eq_two_stars(point: Point) -> Sides:
    y, n = point.state, point.n
    gamma, p = split(y)
    rate = ham_flow(point, to_tau(point, y))[n:]
    swing = ((gamma / point.a) @ star(point, y)) / u_of(point, gamma)
    return two_stars(point, y), rate + p * swing


@claim("proof:main:coincide", "(ro2) and (**) coincide on φ_1 = 1, φ_2 = 0", "1083–1085")
def coincide_again(point: Point) -> Sides:
    return two_stars(point, point.state), ro(point, point.state)[point.n :]


@claim("text:differ", "(ro2) and (**) are different off T*S^(n−1)", "1083–1085", negative=True)
def differ(point: Point) -> Sides:
    place = point.off
    return two_stars(place, place.state), ro(place, place.state)[place.n :]


@claim(
    "remark:referee",
    "λ = {H, ψ_2}/{ψ_1, ψ_2}, μ = −{H, ψ_1}/{ψ_1, ψ_2}",
    "1087–1093",
    everywhere=True,
)
def referee_multipliers(point: Point) -> Sides:
    n, y = point.n, point.state

    def h(z: Array) -> Any:
        return hamiltonian_tau(point, z)

    def one(z: Array) -> Any:
        return z[:n] @ z[:n]

    def two(z: Array) -> Any:
        return z[:n] @ z[n:]

    c = canonical_bracket(one, two, y)
    left = canonical_bracket(h, two, y) / c, -canonical_bracket(h, one, y) / c
    return left, multipliers(point, y)


@claim(
    "referee",
    "w = Σ_{i,j} (dp_i∧dγ_i − p_i a_j⁻¹γ_j/(γ, A⁻¹γ) dγ_j∧dγ_i) on T*S^(n−1)",
    "1094–1101",
    misprint="w = Σ_i dp_i∧dγ_i − Σ_{i,j} p_i a_j⁻¹γ_j/(γ, A⁻¹γ) dγ_j∧dγ_i: the double sum "
    "counts the first term n times",
)
def referee(point: Point, corrected: bool) -> Sides:
    n, y = point.n, point.state

    def form(y: Array, Y: Array, Z: Array) -> Any:
        total = 0.0
        for i in range(n):
            for j in range(n):
                first = Y[n + i] * Z[i] - Z[n + i] * Y[i]
                factor = y[n + i] * y[j] / point.a[j] / u_of(point, y[:n])
                total += first / (n if corrected else 1) - factor * (Y[j] * Z[i] - Z[j] * Y[i])
        return total

    def nova(y: Array, Y: Array, Z: Array) -> Any:
        slope = gradient(lambda g: np.log(multiplier(point, g)), y[:n])
        extra = (slope @ Y[:n]) * (y[n:] @ Z[:n]) - (slope @ Z[:n]) * (y[n:] @ Y[:n])
        return canonical(y, Y, Z) + extra

    return on_tangents(form, y), on_tangents(nova, y)


@claim(
    "remark:hochgerner",
    "among the operators diagonal in E_i∧E_j the special ones are those with w_0 "
    "conformally symplectic: locally, n = 4, 5",
    "1103–1124",
    n=(4, 5),
)
def hochgerner(point: Point) -> Sides:
    """Check that the linearised condition at a special operator has the n ∂/∂a_i as its kernel."""
    i, j = point.pairs
    entries = (point.D - point.a[i] * point.a[j]) / (point.a[i] * point.a[j] * point.D)
    spots = point.normal("spots", 3, point.n)
    vectors = [v / np.sqrt(v @ v) for v in spots]
    slope = np.vstack([gradient(partial(conformal_defect, point, v), entries) for v in vectors])
    # c_ij = 1/(a_i a_j) − 1/D, so that ∂c_ij/∂ log a_i is −1/(a_i a_j)
    along = np.array([[-(k in pair) for pair in zip(i, j, strict=True)] for k in range(point.n)])
    along = along / (point.a[i] * point.a[j])
    kernel = len(entries) - rank(slope)
    moved = slope @ along.T
    return [kernel, *np.ravel(moved)], [point.n, *np.zeros(moved.size)], np.max(np.abs(slope))


def conformal_defect(point: Point, gamma: Array, entries: Array) -> Array:
    """Return how far w_0 of I⁻¹ = diag(entries) is from conformally symplectic at γ.

    The part of d(𝒩w_0) with one dp vanishes if the part in so(n−1)^γ of ω, at k = γ∧π, is θ∧π for
    all π ⟂ γ, with θ ⟂ γ the same for all: θ = −d ln 𝒩/D.
    """
    n = point.n
    parts = []
    basis = null_space(gamma)
    for direction in basis:
        omega = point.omega_of(np.diag(1.0 / entries), wedge(gamma, direction), gamma)
        parts.append(omega - project(omega, gamma))
    theta = sum(part @ v for part, v in zip(parts, basis, strict=True)) / (n - 2)
    rest = [part - wedge(theta, v) for part, v in zip(parts, basis, strict=True)]
    return np.ravel(rest)
