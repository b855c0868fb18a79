"""Section 4.2, Time reparametrization: the multiplier, Theorem 5, the Dirac bracket."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from .algebra import Array, inner, null_space, project, rank, wedge
from .calculus import derivative, gradient, nested_gradient
from .claim import Section, Sides
from .claims_measure import log_mu
from .claims_reduction import extended_energy, true_rates
from .equations import ham_flow, hamiltonian, hamiltonian_tau, multiplier, ro, split, u_of
from .forms import (
    canonical,
    canonical_bracket,
    dirac_bracket,
    dirac_brackets,
    dirac_field,
    on_tangents,
    tangent_basis,
)
from .points import Point

__all__ = ["claim", "flow_in_tau", "to_tau"]

claim = Section("4.2 Time reparametrization")


def printed_ham0(point: Point, y: Array) -> Any:
    """Return H of eq. (ham0)."""
    gamma, p = split(y)
    D, a = point.D, point.a
    inside = wedge(gamma / a, p) - wedge(gamma, a * p) / D
    return inner(wedge(gamma, p), inside) / (2.0 * D * u_of(point, gamma))


@claim("ham0", "H = ⟨γ∧p, A⁻¹γ∧p − γ∧Ap/D⟩/(2D(γ, A⁻¹γ))", "938–943")
def ham0(point: Point) -> Sides:
    return printed_ham0(point, point.state), extended_energy(point, point.special, point.state)


@claim("hamiltonian", "on (phi): H = (D(γ, A⁻¹γ)(p, p) − (p, Ap))/(2D²(γ, A⁻¹γ))", "944–949")
def hamiltonian_on_manifold(point: Point) -> Sides:
    value = hamiltonian(point, point.state)
    return [value] * 2, [
        printed_ham0(point, point.state),
        extended_energy(point, point.special, point.state),
    ]


@claim("text:multiplier-guess", "μ = 𝒩^(n−2) with 𝒩 proportional to 1/√(γ, A⁻¹γ)", "951–955")
def multiplier_guess(point: Point) -> Sides:
    u = u_of(point, point.gamma)
    return (1.0 / np.sqrt(u)) ** (point.n - 2), np.exp(log_mu(point, point.state))


def to_tau(point: Point, y: Array) -> Array:
    """Return (γ, p̃) of (γ, p), eq. (mapping)."""
    gamma, p = split(y)
    return np.concatenate([gamma, multiplier(point, gamma) * p])


def flow_in_tau(point: Point, y: Array, rate: Array) -> Array:
    """Return d/dτ of (γ, p̃) for a rate d/dt of (γ, p): d/dτ = 𝒩⁻¹ d/dt."""
    return np.asarray(
        derivative(lambda z: to_tau(point, z), y, rate) / multiplier(point, split(y)[0])
    )


@claim(
    "main",
    "Theorem 5: with dτ = 𝒩dt and p̃ = 𝒩p, (ro1), (ro2) is the Hamiltonian flow of (hamiltonian*)",
    "957–975",
)
def main(point: Point) -> Sides:
    y = point.state
    left = flow_in_tau(point, y, np.concatenate(true_rates(point, point.special)))
    z = to_tau(point, y)
    return left, dirac_field(lambda w: hamiltonian_tau(point, w), z)


@claim(
    "text:geodesic", "the Hamiltonian (hamiltonian*) is a metric: positive on T*S^(n−1)", "968–973"
)
def geodesic(point: Point) -> Sides:
    """Check that the eigenvalues of the quadratic form on p̃ ⟂ γ are positive."""
    D, u = point.D, u_of(point, point.gamma)
    basis = tangent_basis(np.concatenate([point.gamma, 0.0 * point.p]))[:, point.n :]
    form = basis @ (D * u * np.eye(point.n) - np.diag(point.a)) @ basis.T
    values = np.linalg.eigvalsh(form)
    return float(np.sum(values > 1e-12)), float(point.n - 1)


@claim(
    "CM",
    "dτ = 𝒩dt, 𝒩 = 1/(D√(A⁻¹γ, γ)), is a reducing multiplier: γ′ as (hamiltonian*) has it",
    "959–962",
)
def cm(point: Point) -> Sides:
    y = point.state
    rate = flow_in_tau(point, y, ro(point, y))
    return rate[: point.n], dirac_field(lambda w: hamiltonian_tau(point, w), to_tau(point, y))[
        : point.n
    ]


@claim("mapping", "p̃ = p/(D√(γ, A⁻¹γ)): p̃′ as (hamiltonian*) has it", "963–967")
def mapping(point: Point) -> Sides:
    y = point.state
    rate = flow_in_tau(point, y, ro(point, y))
    return rate[point.n :], dirac_field(lambda w: hamiltonian_tau(point, w), to_tau(point, y))[
        point.n :
    ]


@claim(
    "hamiltonian*",
    "H(γ, p̃) = ½(D(γ, A⁻¹γ)(p̃, p̃) − (p̃, Ap̃)) is (hamiltonian) under (mapping)",
    "970–973, 1001–1002",
    everywhere=True,
)
def hamiltonian_star(point: Point) -> Sides:
    return hamiltonian_tau(point, to_tau(point, point.state)), hamiltonian(point, point.state)


claim.unchecked("psi", "ψ_1 = (γ, γ) = 1, ψ_2 = (γ, p̃) = 0", "977–982", "definition")


def test_functions(point: Point) -> list[Any]:
    """Return three functions of y without any meaning."""
    rows = point.normal("f", 3, 2 * point.n)
    return [lambda y, row=row: np.sin(row @ y) + (row @ (y * y)) for row in rows]


@claim("text:dirac", "{·,·}_d as printed is the bracket of dp̃∧dγ on T*S^(n−1)", "984–999")
def dirac_is_canonical(point: Point) -> Sides:
    """Its fields are those of dp∧dγ: ω(·, X_f) = df."""
    y, (f, *_) = point.state, test_functions(point)
    basis = tangent_basis(y)
    X = dirac_field(f, y)
    return [canonical(y, Y, X) for Y in basis], basis @ gradient(f, y)


@claim(
    "text:casimirs",
    "ψ_1 and ψ_2 are Casimir functions of {·,·}_d on R̂²ⁿ",
    "996–999",
    everywhere=True,
)
def casimirs(point: Point) -> Sides:
    n, y, (f, *_) = point.n, point.state, test_functions(point)
    first, size = dirac_bracket(f, lambda z: z[:n] @ z[:n], y)
    second, other = dirac_bracket(f, lambda z: z[:n] @ z[n:], y)
    return [first, second], [0.0, 0.0], min(size, other)


@claim(
    "text:jacobi",
    "{·,·}_d satisfies the Jacobi identity on R̂²ⁿ",
    "996–999",
    n=range(2, 5),
    everywhere=True,
)
def jacobi(point: Point) -> Sides:
    """Sum the cyclic {f, {g, h}_d}_d of linear functions, {y_i, y_j}_d = Π_ij."""
    y, n = point.state, point.n

    def tensor(z: Array) -> Array:
        gamma, p = z[:n], z[n:]
        g2 = gamma @ gamma
        free = np.eye(n) - np.outer(gamma, gamma) / g2
        lower = (np.outer(p, gamma) - np.outer(gamma, p)) / g2
        return np.block([[np.zeros((n, n)), free], [-free, lower]])

    printed = dirac_brackets(lambda z: z, y)[0]
    slope = nested_gradient(tensor, y)  # ∂_l Π_jk on the last axis
    terms = np.einsum("il,jkl->ijk", printed, slope)
    total = terms + np.einsum("ijk->jki", terms) + np.einsum("ijk->kij", terms)
    left = [*np.ravel(printed), *np.ravel(total)]
    return left, [*np.ravel(tensor(y)), *np.zeros(total.size)]


@claim(
    "hamiltonian-flow",
    "γ_i′ = {γ_i, H}_d, p̃_i′ = {p̃_i, H}_d is the geodesic flow: (ham_q), (ham_p)",
    "1003–1010",
    everywhere=True,
)
def hamiltonian_flow(point: Point) -> Sides:
    y = point.state
    return dirac_field(lambda w: hamiltonian_tau(point, w), y), ham_flow(point, y)


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
    y = point.state
    gamma, p = split(y)
    lam, mu = multipliers(point, y)
    slope = gradient(lambda z: hamiltonian_tau(point, z), y)
    first = slope[point.n :] - mu * gamma
    second = -slope[: point.n] + 2 * lam * gamma + mu * p
    return [gamma @ first, first @ p + gamma @ second], [0.0, 0.0], abs(p @ slope[point.n :])


def with_multipliers(point: Point) -> Array:
    """Return ∂H*/∂p̃ and −∂H*/∂γ with the multipliers."""
    gamma, p = split(point.state)
    lam, mu = multipliers(point, point.state)
    slope = gradient(lambda z: hamiltonian_tau(point, z), point.state)
    return np.concatenate(
        [slope[point.n :] - mu * gamma, -slope[: point.n] + 2 * lam * gamma + mu * p]
    )


@claim(
    "ham_q",
    "γ′ = D(A⁻¹γ, γ)p̃ − Ap̃ + (γ, Ap̃)γ/(γ, γ) − D(γ, A⁻¹γ)(p̃, γ)γ/(γ, γ)",
    "1037–1039",
    everywhere=True,
)
def ham_q(point: Point) -> Sides:
    return ham_flow(point, point.state)[: point.n], with_multipliers(point)[: point.n]


@claim(
    "ham_p",
    "p̃′ = −D(p̃, p̃)A⁻¹γ + (p̃, Ap̃)γ/(γ, γ) − (γ, Ap̃)p̃/(γ, γ) + D(γ, A⁻¹γ)(p̃, γ)p̃/(γ, γ)",
    "1040–1045",
    everywhere=True,
)
def ham_p(point: Point) -> Sides:
    return ham_flow(point, point.state)[point.n :], with_multipliers(point)[point.n :]


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
