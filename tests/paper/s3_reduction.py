"""Section 3, Reduced system in redundant coordinates: T*S^(n−1), multipliers, the homogeneous ball."""

from __future__ import annotations

from typing import Any

import numpy as np

from .algebra import Array, apply, bracket, coordinates, inner, null_space, project, rank, wedge
from .calculus import derivative, gradient
from .claim import Section, Sides, half
from .equations import extended_energy, extended_field, extended_xi, multiplier, ro, split
from .momenta import contact_momentum, space_momentum, true_rates
from .motion import ball_motion, general_motion, zero_momentum_motion
from .points import Point
from .reduction import CONVENTION, almost_hamiltonian_on_bundle, reduced_form
from .two_forms import (
    canonical,
    conserved,
    exterior_derivative,
    symplectic_divergence,
    tangent_basis,
)

__all__ = ["claim"]

claim = Section("3 Reduced system in redundant coordinates")


@claim(
    "cl",
    "d/dt pr_so(n−1) M = d/dt pr_so(n−1) Ad_g(Iω + D pr ω) = d/dt pr_so(n−1) Ad_g k = 0",
    "530–540",
    n=range(3, 8),
)
def conservation(point: Point) -> Sides:
    def vertical(X: Array) -> Array:
        return X - project(X, point.Gamma)

    moving, g = general_motion(point), point.g
    M, M_dot = space_momentum(point, point.general, moving)
    k = contact_momentum(point, point.general, moving)[0]
    same = vertical(M) - vertical(g @ k @ g.T)
    return [vertical(M_dot), same], np.zeros((2, point.n, point.n)), np.max(np.abs(M_dot)), M


@claim("text:area", "n = 3: the integral is F_1 = (k⃗, γ⃗) = (Iω⃗, γ⃗)", "542–545", n=(3,))
def area(point: Point) -> Sides:
    moving = general_motion(point)
    k, rate = contact_momentum(point, point.general, moving)
    to_vector = np.array([[0, 0, -1], [0, 1, 0], [-1, 0, 0]])
    k_vector, I_vector, k_dot = (
        to_vector @ coordinates(X) for X in (k, apply(point.general, moving.omega), rate)
    )
    gamma_dot = -moving.omega @ point.gamma
    change = k_dot @ point.gamma + k_vector @ gamma_dot
    space = point.g @ k @ point.g.T
    return (
        [k_vector @ point.gamma, change, -space[0, 1]],
        [I_vector @ point.gamma, 0.0, k_vector @ point.gamma],
        k,
    )


@claim(
    "zero",
    "pr_so(n−1) Ad_g(Iω) = pr_so(n−1) Ad_g k = pr_so(n−1)^γ (Iω) = pr_so(n−1)^γ k = "
    "0 are one condition",
    "549–559",
    n=range(3, 8),
)
def zero(point: Point) -> Sides:
    omega = zero_momentum_motion(point).omega
    I_omega = apply(point.general, omega)
    k = I_omega + point.D * project(omega, point.gamma)
    left = [X - project(X, point.gamma) for X in (I_omega, k)]
    turned = [point.g @ X @ point.g.T for X in (I_omega, k)]
    left += [X - project(X, point.Gamma) for X in turned]
    return np.stack(left), np.zeros_like(np.stack(left)), k


@claim("text:complement", "so(n−1)^γ = Ad_{g⁻¹} so(n−1) = (Rⁿ∧γ)^⊥", "557–559", n=range(3, 8))
def complement(point: Point) -> Sides:
    n = point.n
    E = np.eye(n)
    rows = [
        point.g.T @ wedge(E[i], E[j]) @ point.g for i in range(n - 1) for j in range(i + 1, n - 1)
    ]
    others = [wedge(e, point.gamma) for e in E]
    products = [inner(X, Y) for X in rows for Y in others]
    return (
        [*products, len(rows) + rank([coordinates(Y) for Y in others])],
        [0.0] * len(products) + [n * (n - 1) // 2],
        1.0,
    )


claim.unchecked("uslovi", "(γ, p) = (γ, ξ) = 0", "561–566", "definition of p and ξ; see smene")


@claim("smene", "at zero momentum k = γ∧p and ω = I⁻¹(γ∧ξ) with p, ξ ⟂ γ", "566–571")
def new_variables(point: Point) -> Sides:
    I_omega, k, gamma = zero_momentum_pair(point)
    p, xi = -k @ gamma, -I_omega @ gamma
    left = [wedge(gamma, p), wedge(gamma, xi)]
    return [*np.ravel(left), p @ gamma, xi @ gamma], [*np.ravel(k), *np.ravel(I_omega), 0.0, 0.0]


def zero_momentum_pair(point: Point) -> tuple[Array, Array, Array]:
    """Return Iω, k and γ at a state with zero momentum, k random in Rⁿ∧γ."""
    k = project(point.skew("k"), point.gamma)
    omega = point.omega_of(point.general, k, point.gamma)
    return apply(point.general, omega), k, point.gamma


@claim("veza", "Lemma 1: p = ξ − D I⁻¹(γ∧ξ)γ", "573–582")
def veza(point: Point) -> Sides:
    I_omega, k, gamma = zero_momentum_pair(point)
    xi = -I_omega @ gamma
    omega = apply(np.linalg.inv(point.general), wedge(gamma, xi))
    return -k @ gamma, xi - point.D * (omega @ gamma)


@claim("text:unique-xi", "ξ ⟂ γ is uniquely determined by p and γ", "584–585")
def unique_xi(point: Point) -> Sides:
    inverse, basis = np.linalg.inv(point.general), null_space(point.gamma)
    images = [e - point.D * (apply(inverse, wedge(point.gamma, e)) @ point.gamma) for e in basis]
    return [rank(images), rank([*images, point.gamma])], [point.n - 1, point.n]


claim.unchecked(
    "phi",
    "φ_1 = (γ, γ) = 1, φ_2 = (γ, p) = 0",
    "587–594",
    "definition of the embedding of T*S^(n−1)",
)


@claim(
    "T1", "Theorem 2: the reduced problem on T*S^(n−1) = Φ⁻¹(0)/SO(n−1) is (r1), (r2)", "596–604"
)
def theorem_t1(point: Point) -> Sides:
    actual = np.concatenate(true_rates(point, point.general))
    return extended_field(point, point.general, point.state), actual


claim("r1", "γ̇ = −ωγ = −I⁻¹(γ∧ξ)γ", "600")(half(theorem_t1, 0))
claim("r2", "ṗ = −ωp = −I⁻¹(γ∧ξ)p", "601–602")(half(theorem_t1, 1))


@claim("proof:T1", "γ̇∧p + γ∧ṗ = [γ∧p, ω] ⇒ … ⇒ γ∧ṗ = ωpγᵀ + γpᵀω = (ωp)∧γ, ṗ = −ωp + λγ", "606–620")
def proof_t1(point: Point) -> Sides:
    gamma, p = point.gamma, point.p
    gamma_dot, p_dot = true_rates(point, point.general)
    omega = extended_xi(point, point.general, point.state)[1]
    k = wedge(gamma, p)
    first = wedge(gamma_dot, p) + wedge(gamma, p_dot)
    second = -np.outer(omega @ gamma, p) - np.outer(p, -omega @ gamma) + wedge(gamma, p_dot)
    expanded = np.outer(gamma, p) @ omega - np.outer(p, gamma) @ omega
    expanded = expanded - omega @ np.outer(gamma, p) + omega @ np.outer(p, gamma)
    third = np.outer(omega @ p, gamma) + np.outer(gamma, p) @ omega
    left = [first, second, wedge(gamma, p_dot), third]
    right = [bracket(k, omega), expanded, third, wedge(omega @ p, gamma)]
    return left, right, zero_momentum_motion(point).size


@claim("proof:T1:lambda", "φ̇_2 = (−ωγ, p) + (γ, −ωp) + λ(γ, γ) = λ", "622–627")
def proof_t1_lambda(point: Point) -> Sides:
    omega, gamma, p = point.omega, point.gamma, point.p
    lam = float(point.normal("lambda"))
    left = (-omega @ gamma) @ p + gamma @ (-omega @ p) + lam * (gamma @ gamma)
    return left, lam, np.linalg.norm(omega @ gamma) * np.linalg.norm(p)


@claim("red:ham", "H = ½⟨k, ω⟩ = ½⟨γ∧p, I⁻¹(γ∧ξ)⟩ is the energy", "630–634")
def reduced_energy(point: Point) -> Sides:
    omega = zero_momentum_motion(point).omega
    V = point.rho * (point.g @ omega @ point.gamma)
    actual = 0.5 * inner(apply(point.general, omega), omega) + 0.5 * point.m * (V @ V)
    return extended_energy(point, point.general, point.state), actual


claim.unchecked("hat", "R̂²ⁿ = R²ⁿ ∖ {γ = 0}", "636–639", "definition")


def preserved(point: Point, f: Any) -> Sides:
    """Return X(f) and 0 for the extended system of a general operator."""
    return conserved(f, extended_field(point, point.general, point.state), point.state)


@claim(
    "text:extended:phi",
    "the extended system preserves φ_1 and φ_2 on R̂²ⁿ",
    "641–643",
    everywhere=True,
)
def preserves_phi(point: Point) -> Sides:
    n = point.n
    first = preserved(point, lambda y: y[:n] @ y[:n])
    second = preserved(point, lambda y: y[:n] @ y[n:])
    return [first[0], second[0]], [0.0, 0.0], min(first[2], second[2])


@claim(
    "text:extended:H",
    "the extended system (r1), (r2) preserves (red:ham) on R̂²ⁿ, ξ from (veza)",
    "641–644",
    everywhere=True,
)
def preserves_energy(point: Point) -> Sides:
    return preserved(point, lambda y: extended_energy(point, point.general, y))


@claim(
    "IK", "K = ⟨γ∧p, γ∧p⟩ = (γ, γ)(p, p) − (γ, p)² is preserved on R̂²ⁿ", "641–647", everywhere=True
)
def preserves_k(point: Point) -> Sides:
    def printed(y: Array) -> Any:
        gamma, p = split(y)
        return (gamma @ gamma) * (p @ p) - (gamma @ p) ** 2

    k = wedge(point.gamma, point.p)
    value, zero, size = preserved(point, printed)
    return [value, inner(k, k)], [zero, printed(point.state)], size


claim(
    "text:almost-hamiltonian",
    "i_X(w) = dH on T*S^(n−1) with w = ω + semi-basic",
    "650–655",
    restriction=CONVENTION,
    finding="red:eq",
)(almost_hamiltonian_on_bundle)


@claim("text:nondegenerate", "w is non-degenerate", "652–653")
def nondegenerate(point: Point) -> Sides:
    y, omega = point.state, zero_momentum_motion(point).omega
    basis = tangent_basis(y)
    return rank(
        [[reduced_form(point.D, y, omega, Y, Z) for Z in basis] for Y in basis]
    ), 2 * point.n - 2


claim.unchecked("OMEGA", "ω = dp_1∧dγ_1 + … + dp_n∧dγ_n on T*S^(n−1)", "655–657", "definition")


@claim("text:multiplier", "i_X w = dH, ω̃ = 𝒩w, X̃ = X/𝒩 ⇒ i_X̃ ω̃ = dH", "660–675")
def multiplier_identity(point: Point) -> Sides:
    y, omega = point.state, zero_momentum_motion(point).omega
    X, Y = np.concatenate(true_rates(point, point.general)), tangent_basis(y)[0]
    factor = multiplier(point, point.gamma)
    plain = reduced_form(point.D, y, omega, Y, X)
    return factor * reduced_form(point.D, y, omega, Y, X / factor), plain


def arbitrary_multiplier(point: Point, gamma: Array) -> Any:
    """Return a positive function 𝒩(γ) without any meaning."""
    return np.exp(0.3 * np.sin(gamma @ point.normal("slope", point.n)))


@claim("2-form", "Σ dp̃_i∧dγ_i = 𝒩ω + Σ p_i d𝒩∧dγ_i for p̃ = 𝒩p, any 𝒩", "677–692", everywhere=True)
def two_form(point: Point) -> Sides:
    n, y = point.n, point.state
    Y, Z = point.normal("Y", 2 * n), point.normal("Z", 2 * n)

    def mapped(z: Array) -> Array:
        return np.concatenate([z[:n], arbitrary_multiplier(point, z[:n]) * z[n:]])

    left = canonical(mapped(y), derivative(mapped, y, Y), derivative(mapped, y, Z))
    return left, conformal_form(point, lambda gamma: arbitrary_multiplier(point, gamma), y, Y, Z)


def conformal_form(point: Point, factor: Any, y: Array, Y: Array, Z: Array) -> Any:
    """Return (𝒩ω + Σ p_i d𝒩∧dγ_i)(Y, Z)."""
    n = point.n
    slope = gradient(factor, y[:n])
    extra = (slope @ Y[:n]) * (y[n:] @ Z[:n]) - (slope @ Z[:n]) * (y[n:] @ Y[:n])
    return factor(y[:n]) * canonical(y, Y, Z) + extra


@claim(
    "IM",
    "L_X̃(ω̃^(n−1)) = 0 ⇔ L_X(𝒩^(n−2) ω^(n−1)) = 0, X̃ = X/𝒩; and both hold for the special ball",
    "698–705",
)
def liouville(point: Point) -> Sides:
    """ω̃^(n−1) = 𝒩^(n−1) ω^(n−1), so both sides are div X plus (n − 2) X(log 𝒩), over 𝒩."""
    n, y = point.n, point.state

    def tilde(z: Array) -> Array:
        return np.asarray(ro(point, z) / multiplier(point, z[:n]))

    def rate(field: Array, power: int) -> Any:
        return power * derivative(lambda z: np.log(multiplier(point, z[:n])), y, field)

    value, size = symplectic_divergence(tilde, y)
    plain, other = symplectic_divergence(lambda z: ro(point, z), y)
    left = value + rate(tilde(y), n - 1)
    right = (plain + rate(ro(point, y), n - 2)) / multiplier(point, point.gamma)
    return [left, right], [right, 0.0], max(size, other / multiplier(point, point.gamma))


@claim(
    "nova",
    "w = ω + Σ p_i d ln 𝒩∧dγ_i for the special ball: the reduced form, and d(𝒩w) = 0",
    "705–709",
    n=range(3, 8),
)
def nova(point: Point) -> Sides:
    n, y = point.n, point.state
    basis = point.normal("mix", 3, 2 * n - 2) @ tangent_basis(y)

    def printed(z: Array, Y: Array, Z: Array) -> Any:
        u_slope = -(z[:n] / point.a) / (z[:n] @ (z[:n] / point.a))  # d ln 𝒩
        extra = (u_slope @ Y[:n]) * (z[n:] @ Z[:n]) - (u_slope @ Z[:n]) * (z[n:] @ Y[:n])
        return canonical(z, Y, Z) + extra

    omega = point.omega_of(point.special, wedge(point.gamma, point.p), point.gamma)
    actual = reduced_form(point.D, y, omega, basis[0], basis[1])
    value, size = exterior_derivative(
        lambda z, Y, Z: multiplier(point, z[:n]) * printed(z, Y, Z), y, *basis
    )
    return [printed(y, basis[0], basis[1]), value], [actual, 0.0], size


def homogeneous(point: Point) -> tuple[float, Array]:
    """Return s and I = s·1."""
    s = float(point.uniform("s", 0.4, 1.5))
    return s, s * np.eye(len(point.general))


@claim("text:homogeneous-xi", "I = s: ξ = s p/(s + D)", "717–721")
def homogeneous_xi(point: Point) -> Sides:
    s, inertia = homogeneous(point)
    return extended_xi(point, inertia, point.state)[0], s * point.p / (s + point.D)


@claim(
    "sphere",
    "I = s: γ̇ = p/(s + D), ṗ = −(p, p)γ/(s + D), geodesics of the round metric times s + D",
    "721–726",
)
def sphere(point: Point) -> Sides:
    s, inertia = homogeneous(point)
    p, total = point.p, s + point.D
    printed = np.concatenate([p / total, -(p @ p) / total * point.gamma])
    actual = np.concatenate(true_rates(point, inertia))
    # The metric (s + D)(γ̇, γ̇) has the momenta (s + D)γ̇ and the energy (p, p)/(2(s + D)).
    energy = extended_energy(point, inertia, point.state)
    left = [*printed, p @ p / (2 * total), *(total * actual[: point.n])]
    return left, [*actual, energy, *p]


@claim("text:homogeneous-omega", "I = s: ω = (γ∧ξ)/s = (γ∧p)/(s + D), constant", "726–731")
def homogeneous_omega(point: Point) -> Sides:
    s, inertia = homogeneous(point)
    xi, omega = extended_xi(point, inertia, point.state)
    gamma_dot, p_dot = true_rates(point, inertia)
    change = wedge(gamma_dot, point.p) + wedge(point.gamma, p_dot)
    printed = [wedge(point.gamma, xi) / s, wedge(point.gamma, point.p) / (s + point.D)]
    return [*printed, change], [omega, omega, 0.0 * change]


@claim(
    "text:homogeneous-any",
    "I = s, any momentum: pr_𝔥(sΩ̇ + DΩ̇) = 0, pr_𝔥^⊥(sΩ̇) = 0, Ω̇ = 0, ω̇ = V̇ = 0",
    "731–743",
)
def homogeneous_any(point: Point) -> Sides:
    moving = ball_motion(point, homogeneous(point)[1], point.omega)
    rates = [*np.ravel(point.g @ moving.omega_dot @ point.g.T), *moving.V_dot]
    return rates, np.zeros(len(rates)), moving.omega
