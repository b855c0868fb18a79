"""Section 5.2, end: the Veselova problem with r = 1 on T*S^(n−1), and the ellipsoid."""

from __future__ import annotations

from typing import Any

import numpy as np

from .algebra import Array, null_space, wedge
from .calculus import derivative, gradient
from .claim import Section, Sides
from .equations import flow_in_tau, split, to_tau, u_of, veselova, veselova_hamiltonian
from .momenta import veselova_rates
from .points import Point
from .stiefel import stiefel_rates
from .two_forms import canonical, tangent_basis

__all__ = ["claim"]

claim = Section("5.2 Veselova problem with r = 1", n=range(3, 7))


@claim(
    "text:r1",
    "r = 1: (dot_P) with 𝓘 general is the Veselova problem reduced to T*S^(n−1)",
    "1349–1350",
    n=range(3, 8),
)
def reducible(point: Point) -> Sides:
    return stiefel_rates(point.with_(seed=(*point.seed[:-1], 0)))


@claim(
    "inertia_tensor",
    "Φ_1 = γ∧γ̇ = γ∧Ap/(γ, A⁻¹γ) for 𝓘(E_i∧E_j) = a_i⁻¹a_j⁻¹ E_i∧E_j",
    "1352–1360",
)
def inertia_tensor(point: Point) -> Sides:
    gamma_dot = veselova_rates(point)[: point.n]
    left = wedge(point.gamma, point.a * point.p) / u_of(point, point.gamma)
    return left, wedge(point.gamma, gamma_dot)


@claim("extended1", "γ̇ = −Φ_1γ = (−(p, Aγ)γ + (γ, γ)Ap)/(γ, A⁻¹γ)", "1363–1366")
def extended1(point: Point) -> Sides:
    return veselova(point, point.state)[: point.n], veselova_rates(point)[: point.n]


@claim(
    "extended2",
    "ṗ = −Φ_1p = ((p, Ap)γ − (p, γ)Ap)/(γ, A⁻¹γ)",
    "1367–1369",
    misprint="ṗ = −Φ_1p = (−(p, Ap)γ + (p, γ)Ap)/(γ, A⁻¹γ)",
)
def extended2(point: Point, corrected: bool) -> Sides:
    return veselova(point, point.state, corrected)[point.n :], veselova_rates(point)[point.n :]


@claim(
    "ham:ves",
    "by (CM), (mapping) the reduced system becomes the flow of 𝓗 = D²/2 (Ap̃, p̃) on T*S^(n−1)",
    "1371–1378",
    cites=("extended2",),
)
def ham_ves(point: Point) -> Sides:
    """ω(·, X) = d𝓗 on the tangent space."""
    y = point.state
    z, X = to_tau(point, y), flow_in_tau(point, y, veselova_rates(point))
    basis = tangent_basis(z)
    slope = gradient(lambda x: veselova_hamiltonian(point, x), z)
    return [canonical(z, Y, X) for Y in basis], basis @ slope


@claim(
    "elipsoid",
    "γ = Ax/|Aγ| along geodesics of (x, Ax) = 1 gives the reduced Veselova system in another time",
    "1380–1386",
    n=range(3, 8),
    misprint="γ = Ax/|Ax|; the ellipsoid (x, Ax) = 1 is right, (x, A⁻¹x) = 1 is not",
)
def ellipsoid(point: Point, corrected: bool) -> Sides:
    """Both γ are unit vectors with the same path: γ̈ agrees modulo γ̇ and γ at the same γ̇."""
    return gauss_map_defect(point, point.a, corrected)


def gauss_map_defect(point: Point, B: Array, corrected: bool = True) -> Sides:
    """Return γ̈ of a mapped geodesic of (x, Bx) = 1 and of (extended1), both modulo γ and γ̇."""
    n = point.n
    x, v = point.normal("x", n), point.normal("v", n)
    x = x / np.sqrt(x @ (B * x))
    v = v - (v @ (B * x)) / np.sum((B * x) ** 2) * (B * x)
    pull = -(v @ (B * v)) / np.sum((B * x) ** 2) * (B * x)  # ẍ

    def unit(t: Array) -> Array:
        normal = B * (x + t * v + 0.5 * t * t * pull)
        return np.asarray(normal / np.sqrt(normal @ normal))

    gamma = unit(np.zeros(1))
    printed = B * x / np.sqrt(np.sum((B * (x if corrected else gamma)) ** 2))
    rate = derivative(unit, np.zeros(1), np.ones(1))
    bent = second(unit)
    # p ⟂ γ with γ̇ of (extended1) equal to the rate: p = U A⁻¹γ̇ + cA⁻¹γ
    u = u_of(point, gamma)
    b = gamma / point.a
    p = u * (rate / point.a) - (rate @ b) * b
    y = np.concatenate([gamma, p])
    field = veselova(point, y)
    other = derivative(lambda z: split(veselova(point, z))[0], y, field)
    across = null_space([gamma, rate])
    return [*printed, *field[:n], *(across @ bent)], [*gamma, *rate, *(across @ other)], bent


def second(f: Any) -> Array:
    """Return f″(0) of a function of one variable, by Cauchy's formula."""
    nodes = np.exp(2j * np.pi * (np.arange(32) + 0.5) / 32)
    total = sum(f(0.1 * node * np.ones(1)) / node**2 for node in nodes)
    return np.asarray(2.0 * np.real(total) / (32 * 0.1**2))


@claim(
    "text:ellipsoid:inverse",
    "not: the same for the ellipsoid (x, A⁻¹x) = 1",
    "1380–1386",
    n=range(3, 8),
    negative=True,
)
def other_ellipsoid(point: Point) -> Sides:
    return gauss_map_defect(point, 1.0 / point.a)
