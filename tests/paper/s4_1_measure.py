"""Section 4.1, Invariant measure of the reduced system with the special operator."""

from __future__ import annotations

import numpy as np

from .algebra import Array
from .calculus import derivative, gradient, nested
from .claim import Section, Sides
from .classical import iop1, three_moments
from .equations import log_mu, log_rho, ro, split, u_of
from .points import Point
from .two_forms import canonical, conserved, divergence, symplectic_divergence

__all__ = ["claim"]

claim = Section("4.1 Invariant measure")


def spherical(n: int, theta: Array) -> Array:
    """Return the unit vector with the standard spherical angles θ_1 … θ_(n−1)."""
    rows, sines = [], 1.0 + 0.0 * theta[0]
    for i in range(n - 1):
        rows.append(sines * np.cos(theta[i]))
        sines = sines * np.sin(theta[i])
    return np.array([*rows, sines])


def spherical_slope(n: int, place: Array) -> Array:
    """Return ∂γ/∂(θ, r), rows γ, at γ = r u(θ)."""
    theta, r = place[:-1], place[-1]
    u = spherical(n, theta)
    columns = []
    for j in range(n - 1):
        turned = np.where(np.arange(n) > j, u / np.tan(theta[j]), 0.0 * u)
        turned[j] = -u[j] * np.tan(theta[j])
        columns.append(r * turned)
    return np.array([*columns, u]).T


def from_spherical(n: int, x: Array) -> Array:
    """Return (γ, p) of x = (θ, r, π_θ, π_r): γ = r u(θ), π = (∂γ/∂(θ, r))ᵀ p."""
    place, momenta = x[:n], x[n:]
    gamma = place[n - 1] * spherical(n, place[: n - 1])
    return np.concatenate([gamma, np.linalg.solve(spherical_slope(n, place).T, momenta)])


def spherical_rates(point: Point, x: Array, field: Array) -> Array:
    """Return (θ̇, ṙ, π̇_θ, π̇_r) of a vector (γ̇, ṗ) at x, by the chain rule."""
    n = point.n
    slope = spherical_slope(n, x[:n])
    moving = np.linalg.solve(slope, field[:n])
    turned = nested(lambda z: spherical_slope(n, z), x[:n], moving)
    p = np.linalg.solve(slope.T, x[n:])
    return np.concatenate([moving, turned.T @ p + slope.T @ field[n:]])


def spherical_point(point: Point) -> Array:
    """Return random (θ, r, π_θ, π_r), away from the poles."""
    n = point.n
    place = [*point.uniform("theta", 0.6, 2.4, n - 1), float(point.uniform("r", 0.6, 1.6))]
    return np.concatenate([place, point.normal("pi", n)])


def spherical_jacobian(point: Point) -> tuple[Array, Array]:
    """Return x and ∂(γ, p)/∂x."""
    x, n = spherical_point(point), point.n
    return x, gradient(lambda z: from_spherical(n, z), x)


@claim(
    "text:spherical",
    "Σ dp_i∧dγ_i = Σ dπ_i∧dθ_i + dπ_r∧dr; on T*S^(n−1) it is Σ dπ_i∧dθ_i",
    "837–845, 855–858",
)
def spherical_canonical(point: Point) -> Sides:
    slope, one = spherical_jacobian(point)[1], np.eye(2 * point.n)
    forms = [[canonical(one[0], Y, Z) for Z in rows] for rows in (slope.T, one) for Y in rows]
    return forms[: 2 * point.n], forms[2 * point.n :]


@claim(
    "VOLUME", "Ω = Π dp_i∧dγ_i = (Π dπ_i∧dθ_i)∧dp_r∧dr, r = |γ|, p_r = π_r = (γ, p)/|γ|", "847–855"
)
def volume(point: Point) -> Sides:
    x, slope = spherical_jacobian(point)
    n = point.n
    gamma, p = split(from_spherical(n, x))
    size = np.sqrt(gamma @ gamma)
    return [np.linalg.det(slope), size, gamma @ p / size], [1.0, x[n - 1], x[-1]]


@claim("redLR", "Proposition 4: (ro1), (ro2) on T*S^(n−1) have an invariant measure", "866–872")
def density(point: Point) -> Sides:
    y = point.state
    value, size = symplectic_divergence(lambda z: ro(point, z), y)
    return value, -derivative(lambda z: log_mu(point, z), y, ro(point, y)), size


claim("DENSITY", "μσ = (A⁻¹γ, γ)^(−(n−2)/2) σ is invariant", "869–871")(density)


@claim(
    "div1",
    "div X = (n−2)((γ, A⁻¹p)/(DU) + (γ, Ap)/(D²U)) + Ψ on R̂²ⁿ, Ψ as printed less a stray bracket",
    "874–888",
    everywhere=True,
)
def div1(point: Point) -> Sides:
    gamma, p = point.gamma, point.p
    D, a, u = point.D, point.a, u_of(point, gamma)
    value, size = divergence(lambda z: ro(point, z), point.state)
    main = (point.n - 2) * (gamma @ (p / a) / (D * u) + gamma @ (a * p) / (D**2 * u))
    psi = 2 * np.sum(gamma**2 / a**2) / (D * u**2) + 2 * (gamma @ gamma) / (D**2 * u**2)
    psi = psi - np.sum(1 / a) / (D * u) - np.sum(a) / (D**2 * u)
    return value, main + psi * (gamma @ p), size


def tangent_of_any_length(point: Point) -> Point:
    """Return a point with φ_2 = 0 and |γ| ≠ 1: the text says φ_2 = 0 only."""
    size = float(point.uniform("length", 0.5, 0.8))
    return point.with_(gamma=size * point.gamma)


@claim("proof:redLR:div", "on φ_2 = 0: div X = (n−2)(γ, A⁻¹γ̇)/(γ, A⁻¹γ) = −μ̇/μ", "890–897")
def proof_divergence(point: Point) -> Sides:
    place = tangent_of_any_length(point)
    y, rate = place.state, ro(place, place.state)
    value, size = divergence(lambda z: ro(place, z), y)
    b = place.gamma / place.a
    middle = (place.n - 2) * (b @ rate[: place.n]) / (b @ place.gamma)
    mu = derivative(lambda z: log_mu(place, z), y, rate)
    return [value, middle], [middle, -mu], size


@claim("div2", "div(μX) = Σ q̇_i ∂μ/∂q_i + μ Σ(∂q̇_i/∂q_i + ∂ṗ_i/∂p_i) = 0 on φ_2 = 0", "898–906")
def div2(point: Point) -> Sides:
    place = tangent_of_any_length(point)

    def weighted(z: Array) -> Array:
        return np.asarray(np.exp(log_mu(place, z)) * ro(place, z))

    value, size = divergence(weighted, place.state)
    return value, 0.0, size


@claim(
    "div3",
    "L_X(μΩ) = L_X(μσ)∧dπ_r∧dr + μσ∧L_X(dπ_r∧dr), in spherical coordinates",
    "908–913",
    n=range(2, 6),
)
def div3(point: Point) -> Sides:
    n, x = point.n, spherical_point(point)

    def weighted(y: Array) -> Array:
        return np.asarray(np.exp(log_mu(point, y)) * ro(point, y))

    def in_spherical(z: Array) -> Array:
        return spherical_rates(point, z, weighted(from_spherical(n, z)))

    parts = np.array([nested(in_spherical, x, e)[i] for i, e in enumerate(np.eye(2 * n))])
    value, size = divergence(weighted, from_spherical(n, x))
    radial = parts[[n - 1, 2 * n - 1]]
    return [value, *radial], [np.sum(parts) - np.sum(radial), 0.0, 0.0], size


@claim(
    "proof:redLR:lie", "L_X dπ_r = L_X dr = 0: X(r) = X(π_r) = 0 on R̂²ⁿ", "915–923", everywhere=True
)
def radial(point: Point) -> Sides:
    n = point.n

    def functions(y: Array) -> Array:
        r = np.sqrt(y[:n] @ y[:n])
        return np.array([r, (y[:n] @ y[n:]) / r])

    return conserved(functions, ro(point, point.state), point.state)


@claim(
    "remark:densities",
    "the densities (mu*) and (DENSITY) are proportional for the special operator",
    "924–932",
)
def proportional(point: Point) -> Sides:
    """At another γ the ratio is the same."""
    other = point.normal("other", point.n)
    other = other / np.sqrt(other @ other)
    ratios = [
        log_rho(point, point.special, gamma) - log_mu(point, gamma)
        for gamma in (point.gamma, other)
    ]
    return np.exp(ratios[0]), np.exp(ratios[1])


@claim(
    "remark:densities:3",
    "n = 3: μ is (mu-ch) times a constant, with a from (IOP1)",
    "932–935",
    n=(3,),
)
def proportional_in_three(point: Point) -> Sides:
    moments, D = three_moments(point)
    ball = point.with_(a=iop1(moments, D), m=D / point.rho**2)
    other = point.normal("other", 3)
    vectors = (point.gamma, other / np.sqrt(other @ other))
    # 1 − D(γ, (I + D)⁻¹γ) = (γ, I(I + D)⁻¹γ) where |γ| = 1, without the cancellation
    chaplygin = [-0.5 * np.log(v @ (moments / (moments + D) * v)) for v in vectors]
    left, right = (np.exp(c - log_mu(ball, v)) for c, v in zip(chaplygin, vectors, strict=True))
    return left, right
