"""Section 4, Hamiltonization: the special operator and its equations."""

from __future__ import annotations

from typing import Any

import numpy as np

from .algebra import Array, apply, inner, wedge
from .claim import Section, Sides, half
from .classical import iop1, tensor_of, three_moments
from .equations import extended_field, extended_xi, ro, special_omega, split, u_of
from .momenta import true_rates
from .points import Point, lagrange_case
from .two_forms import conserved

__all__ = ["claim"]

claim = Section("4 Hamiltonization: the special operator")


@claim(
    "operator",
    "I(E_i∧E_j) = a_i a_j D/(D − a_i a_j) E_i∧E_j is an inertia operator where 0 < "
    "a_i a_j < D, 1 ≤ i, j ≤ n; any n = 3 ball has one",
    "747–754, 764–779",
    n=(3,),
    wider="0 < a_i a_j < D for i ≠ j only: else a_i² < D would exclude balls such as "
    "moments 0.1, 10, 10 with D = 1",
)
def operator(point: Point, corrected: bool) -> Sides:
    """Return the share of random tensors that the condition admits."""
    admitted = []
    for i in range(40):
        moments, D = three_moments(point, f"moments{i}")
        a = iop1(moments, D)
        products = np.outer(a, a)
        chosen = products[~np.eye(3, dtype=bool)] if corrected else products
        admitted.append(np.all((chosen > 0.0) & (chosen < D)))
    return np.mean(admitted), 1.0


def moments_of(point: Point) -> Array:
    """Return the principal moments of the special operator, through the isomorphism (iso)."""
    return np.diag(tensor_of(point.special))


@claim(
    "IOP",
    "n = 3: I_1 = a_2a_3D/(D − a_2a_3), I_2 = a_3a_1D/(D − a_3a_1), I_3 = a_2a_3D/(D − a_2a_3)",
    "764–770",
    n=(3,),
    misprint="I_3 = a_1a_2D/(D − a_1a_2)",
)
def iop(point: Point, corrected: bool) -> Sides:
    a, D = point.a, point.D
    last = a[0] * a[1] if corrected else a[1] * a[2]
    products = np.array([a[1] * a[2], a[2] * a[0], last])
    return products * D / (D - products), moments_of(point)


@claim(
    "IOP1",
    "a_i = √(I_1I_2I_3D) (I_i + D) / (I_i √((I_1 + D)(I_2 + D)(I_3 + D)))",
    "772–779",
    n=(3,),
)
def iop1_inverts(point: Point) -> Sides:
    moments, D = three_moments(point)
    a = iop1(moments, D)
    products = np.array([a[1] * a[2], a[2] * a[0], a[0] * a[1]])
    left = [*iop1(moments_of(point), point.D), *(products * D / (D - products) / moments)]
    return left, [*point.a, 1.0, 1.0, 1.0]


@claim(
    "remark:physical",
    "for n ≥ 4 the operator is in general not Iω = Jω + ωJ",
    "781–784",
    n=range(4, 8),
    negative=True,
)
def not_physical(point: Point) -> Sides:
    """Compare the moments with the nearest of all I_ij = J_i + J_j."""
    i, j = point.pairs
    design = np.zeros((len(i), point.n))
    design[np.arange(len(i)), i] = design[np.arange(len(i)), j] = 1.0
    moments = np.diag(point.special)
    fitted = design @ np.linalg.lstsq(design, moments, rcond=None)[0]
    return fitted, moments


claim.unchecked(
    "sing", "a_1 = a_2 = … = a_(n−1) ≠ a_n", "785–787", "definition of the Lagrange case"
)


def mass_tensor(point: Point) -> Array:
    """Return J of the remark, for a Lagrange case."""
    a, b, D = point.a[0], point.a[-1], point.D
    first = a * a * D / (2.0 * (D - a * a))
    return np.array([first] * (point.n - 1) + [a * b * D / (D - a * b) - first])


@claim(
    "remark:lagrange:J",
    "in the Lagrange case Iω = Jω + ωJ with J = diag(J_1, …, J_1, J_n) as printed",
    "789–797",
    n=range(3, 8),
)
def lagrange_tensor(point: Point) -> Sides:
    case = lagrange_case(point)
    J = np.diag(mass_tensor(case))
    return apply(case.special, case.omega), J @ case.omega + case.omega @ J


@claim(
    "remark:lagrange",
    "J_n > 0 where 2a_nD > a_1a_n + a_1D",
    "788–797",
    n=range(3, 8),
    misprint="2a_nD > a_1²a_n + a_1D",
)
def lagrange_condition(point: Point, corrected: bool) -> Sides:
    """J_n is a positive multiple of the condition's left side less its right side."""
    case = lagrange_case(point)
    a, b, D = case.a[0], case.a[-1], case.D
    positive = a * D / (2.0 * (D - a * b) * (D - a * a))
    term = a * a * b if corrected else a * b
    return mass_tensor(case)[-1], positive * (2 * b * D - term - a * D), positive * (2 * b * D)


def with_q(point: Point, y: Array) -> Array:
    """Return ω of (ro1), (ro2) with q = (γ, γ)p − (γ, p)γ for p; q is p on T*S^(n−1)."""
    gamma, p = split(y)
    q = (gamma @ gamma) * p - (gamma @ p) * gamma
    return special_omega(point, np.concatenate([gamma, q]))


@claim(
    "theorem:ro",
    "Theorem 3: for the special operator the extended equations (r1), (r2) read (ro1), (ro2)",
    "800–811",
    everywhere=True,
    off_manifold="(r1), (r2) with q = p − (γ, p)γ for p in ω, where |γ| = 1",
)
def theorem_ro(point: Point, amended: bool) -> Sides:
    if not amended:
        return ro(point, point.state), extended_field(point, point.special, point.state)
    place = point.with_(gamma=point.gamma / np.sqrt(point.gamma @ point.gamma))
    omega = with_q(place, place.state)
    left = np.concatenate([-omega @ place.gamma, -omega @ place.p])
    return left, extended_field(place, point.special, place.state)


def rolling(point: Point) -> Sides:
    """Compare (ro1), (ro2) with the motion of the rolling ball."""
    return ro(point, point.state), np.concatenate(true_rates(point, point.special))


claim("ro1", "(ro1) is −ωγ of the rolling ball, special operator", "803–806")(half(rolling, 0))
claim("ro2", "(ro2) is −ωp of the rolling ball, special operator", "807–810")(half(rolling, 1))


@claim(
    "text:extended:phi-K", "(ro1), (ro2) preserve φ_1, φ_2 and K on R̂²ⁿ", "641–647", everywhere=True
)
def ro_preserves(point: Point) -> Sides:
    n = point.n

    def integrals(y: Array) -> Array:
        gamma, p = y[:n], y[n:]
        k = (gamma @ gamma) * (p @ p) - (gamma @ p) ** 2
        return np.array([gamma @ gamma, gamma @ p, k])

    return conserved(integrals, ro(point, point.state), point.state)


@claim(
    "text:extended:H-special",
    "(ro1), (ro2) preserve H of (ham0) on R̂²ⁿ",
    "641–644",
    everywhere=True,
    off_manifold="(r1), (r2) with q = (γ, γ)p − (γ, p)γ for p in ω, and H = ½⟨γ∧p, ω⟩ with it",
    finding="theorem:ro",
)
def ro_preserves_energy(point: Point, amended: bool) -> Sides:
    def omega(y: Array) -> Array:
        return with_q(point, y) if amended else special_omega(point, y)

    def energy(y: Array) -> Any:
        return 0.5 * inner(wedge(*split(y)), omega(y))

    y = point.state
    turning = omega(y)
    rate = np.concatenate([-turning @ part for part in split(y)])
    return conserved(energy, rate, y)


@claim("operator*", "I⁻¹(γ∧ξ) = A⁻¹γ∧A⁻¹ξ − γ∧ξ/D", "813–819", everywhere=True)
def operator_inverse(point: Point) -> Sides:
    xi, gamma = point.normal("xi", point.n), point.gamma
    left = apply(np.linalg.inv(point.special), wedge(gamma, xi))
    return left, wedge(gamma / point.a, xi / point.a) - wedge(gamma, xi) / point.D


def printed_xi(point: Point, y: Array) -> Array:
    """Return ξ of eq. (xi)."""
    gamma, p = split(y)
    ap = point.a * p
    return np.asarray((ap - (ap @ gamma) * gamma) / (point.D * u_of(point, gamma)))


@claim("xi", "ξ = (Ap − (p, Aγ)γ)/(D(γ, A⁻¹γ)) solves (veza)", "821–825")
def xi(point: Point) -> Sides:
    return printed_xi(point, point.state), extended_xi(point, point.special, point.state)[0]


@claim("proof:ro", "ω = (A⁻¹γ∧p − γ∧Ap/D)/(D(γ, A⁻¹γ)), and −ωγ, −ωp are (ro1), (ro2)", "827–829")
def proof_ro(point: Point) -> Sides:
    y = point.state
    omega = special_omega(point, y)
    actual = apply(np.linalg.inv(point.special), wedge(point.gamma, printed_xi(point, y)))
    left = [*np.ravel(omega), *(-omega @ point.gamma), *(-omega @ point.p)]
    return left, [*np.ravel(actual), *ro(point, y)]
