"""Section 5.3, Integrability of the reduced problem; spheroconical coordinates."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from .algebra import Array, null_space, rank
from .calculus import gradient
from .claim import Section, Sides
from .equations import (
    flow_in_tau,
    hamiltonian_tau,
    ro,
    split,
    to_tau,
    u_of,
    veselova,
    veselova_hamiltonian,
)
from .integrals import integral_polynomial, relative_brackets, slopes_on_tangents, together
from .points import Point
from .two_forms import canonical, dirac_field, tangent_basis

__all__ = ["claim"]

claim = Section("5.3 Integrability")


@claim(
    "CH-VP",
    "Theorem 8 (i): n − 1 independent commuting integrals r_k of (ham_q), (ham_p); H "
    "is one of their combinations",
    "1392–1394",
)
def integrable(point: Point) -> Sides:
    y = point.state
    values = relative_brackets(together(point, integral_polynomial, hamiltonian_tau), y)
    independent = rank(slopes_on_tangents(partial(integral_polynomial, point), y))
    return [*np.ravel(values), independent - point.n + 1], np.zeros(values.size + 1), 1.0


@claim(
    "CH-VP:ii",
    "Theorem 8 (ii): the reduced ball and the reduced Veselova problem have the same tori",
    "1396–1401",
    cites=("extended2",),
)
def same_tori(point: Point) -> Sides:
    """Both fields in t are tangent to the levels of all r_k."""
    y = point.state
    z = to_tau(point, y)
    slope = gradient(lambda x: integral_polynomial(point, x), z)
    left = []
    for field in (ro(point, y), veselova(point, y)):
        X = flow_in_tau(point, y, field)
        left.append(slope @ X / np.max(np.abs(slope) @ np.abs(X)))
    return left, np.zeros((2, point.n - 1)), 1.0


@claim(
    "CH-VP:iii",
    "Theorem 8 (iii): both are linear on the tori after the same dτ = 𝒩dt",
    "1403–1414",
    cites=("extended2",),
)
def same_angles(point: Point) -> Sides:
    """X/𝒩 of both are Hamiltonian, with Hamiltonians that commute with all r_k: φ′ = ω(r)."""
    y = point.state
    z = to_tau(point, y)
    basis = tangent_basis(z)
    left, right = [], []
    for field, h in ((ro, hamiltonian_tau), (veselova, veselova_hamiltonian)):
        X = flow_in_tau(point, y, field(point, y))
        left += [canonical(z, Y, X) for Y in basis]
        right += list(basis @ gradient(partial(h, point), z))
    functions = together(point, hamiltonian_tau, veselova_hamiltonian, integral_polynomial)
    values = np.ravel(relative_brackets(functions, z)[:2])
    return [*left, *values], [*right, *np.zeros(values.size)]


@claim(
    "linearizacija",
    "φ̇_k = ω_k/(D√(A⁻¹γ, γ)): the angles' rates in t are 𝒩 times those in τ",
    "1407–1413",
)
def linear(point: Point) -> Sides:
    """𝒩 = 1/(D√U), and γ̇ = 𝒩γ′ for both problems."""
    y, n = point.state, point.n
    z = to_tau(point, y)
    factor = 1.0 / (point.D * np.sqrt(u_of(point, point.gamma)))
    primes = [
        dirac_field(partial(h, point), z)[:n] for h in (hamiltonian_tau, veselova_hamiltonian)
    ]
    return factor * np.array(primes), [ro(point, y)[:n], veselova(point, y)[:n]]


def joachimsthal(point: Point, y: Array) -> Any:
    """Return K(γ, p̃) = D²(A⁻¹γ, γ)(p̃, p̃), eq. (kk)."""
    gamma, p = split(y)
    return point.D**2 * u_of(point, gamma) * (p @ p)


@claim("kk", "K = D²(A⁻¹γ, γ)(p̃, p̃)", "1416–1421")
def kk(point: Point) -> Sides:
    gamma, p = point.gamma, point.p
    k = (gamma @ gamma) * (p @ p) - (gamma @ p) ** 2
    return joachimsthal(point, to_tau(point, point.state)), k


@claim("text:H-K", "H = K/(2D) − 𝓗/D²", "1422–1428")
def combination(point: Point) -> Sides:
    y = point.state
    right = joachimsthal(point, y) / (2 * point.D) - veselova_hamiltonian(point, y) / point.D**2
    return hamiltonian_tau(point, y), right


@claim("komutiranje", "{H, K}_d = {H, 𝓗}_d = {𝓗, K}_d = 0 on T*S^(n−1)", "1430–1434")
def commute(point: Point) -> Sides:
    functions = together(point, hamiltonian_tau, joachimsthal, veselova_hamiltonian)
    return relative_brackets(functions, point.state), 0.0, 1.0


def elliptic(point: Point) -> Array:
    """Return random λ_1 … λ_(n−1) between the a_i, and μ_1 … μ_(n−1)."""
    n = point.n
    share = point.uniform("lambda", 0.2, 0.8, n - 1)
    places = point.a[:-1] + share * np.diff(point.a)
    return np.concatenate([places, point.normal("mu", n - 1)])


def sphere_of(point: Point, places: Array) -> Array:
    """Return γ of λ by eq. (S_n), all γ_i > 0."""
    a = point.a
    squares = [np.prod(a[i] - places) / np.prod(a[i] - np.delete(a, i)) for i in range(point.n)]
    return np.asarray(np.sqrt(np.array(squares)))


def from_elliptic(point: Point, x: Array) -> Array:
    """Return (γ, p̃) of (λ, μ): p̃ ⟂ γ with (∂γ/∂λ_k, p̃) = μ_k."""
    n = point.n
    places, momenta = x[: n - 1], x[n - 1 :]
    gamma = sphere_of(point, places)
    # ∂γ_i/∂λ_k = −½ γ_i/(a_i − λ_k)
    slope = np.array([-0.5 * gamma / (point.a - place) for place in places])
    p = np.linalg.solve(np.vstack([slope, gamma]), np.append(momenta, 0.0))
    return np.concatenate([gamma, p])


@claim(
    "S_n",
    "γ_i² = Π_k(a_i − λ_k)/Π_{j≠i}(a_i − a_j) with a_1 < λ_1 < a_2 < … < a_n are "
    "coordinates on S^(n−1)",
    "1436–1444",
)
def spheroconical(point: Point) -> Sides:
    x = elliptic(point)[: point.n - 1]
    gamma = sphere_of(point, x)
    independent = rank(gradient(lambda z: sphere_of(point, z), x))
    # back: Σ γ_i²/(a_i − λ) = 0 at the eigenvalues of A on γ^⊥, which interlace
    plane = null_space(point.gamma)
    roots = np.linalg.eigvalsh(plane @ (point.a * plane).T)
    inside = np.all((point.a[:-1] < roots) & (roots < point.a[1:]))
    left = [gamma @ gamma, independent, float(inside), *sphere_of(point, roots) ** 2]
    return left, [1.0, point.n - 1, 1.0, *point.gamma**2]


@claim("text:S_n-canonical", "Σ dp̃_i∧dγ_i = Σ dμ_k∧dλ_k", "1444–1451")
def elliptic_canonical(point: Point) -> Sides:
    x = elliptic(point)
    rows, one = gradient(lambda z: from_elliptic(point, z), x).T, np.eye(len(x))
    left = [[canonical(rows[0], Y, Z) for Z in rows] for Y in rows]
    right = [[canonical(one[0], Y, Z) for Z in one] for Y in one]
    return left, right


def separated(point: Point, x: Array, power: int) -> Any:
    """Return −4 Σ_k Π_i(λ_k − a_i) λ_k^power μ_k²/Π_{s≠k}(λ_k − λ_s)."""
    n = point.n
    places, momenta = x[: n - 1], x[n - 1 :]
    total = 0.0
    for k in range(n - 1):
        top = np.prod(places[k] - point.a) * places[k] ** power
        total = total + top / np.prod(places[k] - np.delete(places, k)) * momenta[k] ** 2
    return -4.0 * total


def elliptic_norm(point: Point, power: int) -> Sides:
    """Compare (A^power p̃, p̃) with its separated form."""
    x = elliptic(point)
    p = split(from_elliptic(point, x))[1]
    return p @ (point.a**power * p), separated(point, x, power)


claim("text:S_n-pp", "(p̃, p̃) = −4 Σ_k Π_i(λ_k − a_i)/Π_{s≠k}(λ_k − λ_s) μ_k²", "1452–1457")(
    partial(elliptic_norm, power=0)
)


@claim("text:S_n-U", "(γ, A⁻¹γ) = λ_1…λ_(n−1)/(a_1…a_n)", "1458")
def elliptic_u(point: Point) -> Sides:
    places = elliptic(point)[: point.n - 1]
    return u_of(point, sphere_of(point, places)), np.prod(places) / np.prod(point.a)


claim("text:S_n-pAp", "(Ap̃, p̃) = −4 Σ_k Π_i(λ_k − a_i) λ_k/Π_{s≠k}(λ_k − λ_s) μ_k²", "1459–1463")(
    partial(elliptic_norm, power=1)
)


@claim(
    "text:staeckel",
    "𝓗 has the Stäckel form: R(λ_k) = −4λ_kP(λ_k)μ_k² with the commuting integrals as coefficients",
    "1465–1471",
)
def staeckel(point: Point) -> Sides:
    n, x = point.n, elliptic(point)
    y = from_elliptic(point, x)
    r = integral_polynomial(point, y)
    left = np.array([np.polyval(r[::-1], place) for place in x[: n - 1]])
    pairs = np.reshape(x, (2, n - 1)).T
    right = np.array([-4 * z * np.prod(z - point.a) * mu**2 for z, mu in pairs])
    size, leading = np.max(np.abs(right)), point.D**2 / 2 * r[-1]
    return [*(left / size), leading], [*(right / size), veselova_hamiltonian(point, y)]


@claim("proof:CH-VP:K", "K and H commute with F_1 … F_(n−1)", "1473–1486")
def k_commutes(point: Point) -> Sides:
    functions = together(point, joachimsthal, hamiltonian_tau, integral_polynomial)
    return relative_brackets(functions, point.state)[:2], 0.0, 1.0
