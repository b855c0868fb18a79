"""Section 5.1, the classical Chaplygin sphere and the Veselova problem, n = 3."""

from __future__ import annotations

from typing import Any

import numpy as np

from .algebra import Array, hat, rank, skew, vector, wedge
from .calculus import derivative, gradient
from .claim import Section, Sides
from .classical import (
    along_gamma,
    capital_k,
    classical_k,
    classical_omega,
    printed_lambda,
    veselova_field,
)
from .motion import constrained_rotation
from .points import Point
from .two_forms import conserved

__all__ = ["claim"]

claim = Section("5.1 Classical Chaplygin sphere and the Veselova problem", n=(3,))

claim.unchecked("classical", "(w⃗, γ⃗) = 0", "1130–1137", "definition of the constraint")


def tensor(point: Point) -> Array:
    """Return a full inertia tensor with eigenvalues greater than 1."""
    square = point.normal("tensor", 3, 3)
    return 1.2 * np.eye(3) + square @ square.T / 3


def state(point: Point, constrained: bool = False) -> Array:
    """Return random (w, γ), with (w, γ) = 0 if wanted."""
    w, gamma = point.normal("w", 3), point.gamma
    return np.concatenate([w - (w @ gamma) / (gamma @ gamma) * gamma if constrained else w, gamma])


def operator_of(inertia: Array) -> Array:
    """Return the operator on so(3) of an inertia tensor, in the basis E_i∧E_j."""
    rows = [hat(inertia @ vector(skew(e, 3))) for e in np.eye(3)]
    return np.array([row[np.triu_indices(3, 1)] for row in rows]).T


def forced(point: Point, w: Array) -> tuple[Array, Array]:
    """Return ẇ and λ by d'Alembert's principle on SO(3) with the constraint ⟨Ad_g w, E_1∧E_2⟩ = 0."""
    E = np.eye(3)
    return constrained_rotation(point, operator_of(tensor(point)), hat(w), [wedge(E[1], E[0])])


@claim("3.1", "d/dt 𝓘w⃗ = 𝓘w⃗ × w⃗ + λγ⃗, dγ⃗/dt = γ⃗ × w⃗", "1138–1147")
def euler_with_multiplier(point: Point) -> Sides:
    inertia, y = tensor(point), state(point, constrained=True)
    w, gamma = y[:3], y[3:]
    rate, (force,) = forced(point, w)
    left = [inertia @ vector(rate), (point.g @ hat(w)).T @ point.Gamma]
    return left, [np.cross(inertia @ w, w) + force * gamma, np.cross(gamma, w)]


@claim("la", "λ = −(𝓘w⃗ × w⃗, 𝓘⁻¹γ⃗)/(𝓘⁻¹γ⃗, γ⃗)", "1147–1152")
def la(point: Point) -> Sides:
    y = state(point, constrained=True)
    return printed_lambda(tensor(point), y[:3], y[3:]), forced(point, y[:3])[1][0]


@claim(
    "text:f1",
    "f_1 = (w⃗, γ⃗) is an integral of (3.1), (la) on R⁶",
    "1156–1159",
    everywhere=True,
)
def first_integral(point: Point) -> Sides:
    return integral(point, lambda y: y[:3] @ y[3:])


def integral(point: Point, f: Any) -> Sides:
    """Return the derivative of f along (3.1), (la), and 0."""
    y = state(point)
    return conserved(f, veselova_field(tensor(point), y), y)


@claim(
    "text:veselova-measure",
    "√(𝓘⁻¹γ⃗, γ⃗) is the density of an invariant measure on R⁶(w⃗, γ⃗)",
    "1159–1160",
    everywhere=True,
)
def veselova_measure(point: Point) -> Sides:
    inertia, y = tensor(point), state(point)
    terms = np.diag(gradient(lambda z: veselova_field(inertia, z), y))

    def log_density(z: Array) -> Any:
        return 0.5 * np.log(z[3:] @ np.linalg.solve(inertia, z[3:]))

    return (
        np.sum(terms),
        -derivative(log_density, y, veselova_field(inertia, y)),
        np.sum(np.abs(terms)),
    )


ANY_LENGTH = "K⃗ = 𝓘w⃗ − (𝓘⁰w⃗, γ⃗)γ⃗/(γ⃗, γ⃗)"  # d/dt of the factor of γ⃗ is λ only so


@claim(
    "3.2",
    "dK⃗/dt = K⃗ × w⃗, dγ⃗/dt = γ⃗ × w⃗ with K⃗ = 𝓘w⃗ − (𝓘⁰w⃗, γ⃗)γ⃗, on R⁶(w⃗, γ⃗)",
    "1161–1169",
    everywhere=True,
    off_manifold="with " + ANY_LENGTH,
)
def momentum_form(point: Point, amended: bool) -> Sides:
    inertia, y = tensor(point), state(point)
    left = derivative(lambda z: capital_k(inertia, z, amended), y, veselova_field(inertia, y))
    return left, np.cross(capital_k(inertia, y, amended), y[:3])


@claim(
    "text:f1-K",
    "f_1 = (w⃗, γ⃗) = (K⃗, γ⃗)",
    "1171",
    everywhere=True,
    off_manifold="with " + ANY_LENGTH,
    finding="3.2",
)
def f1_of_k(point: Point, amended: bool) -> Sides:
    y = state(point)
    return capital_k(tensor(point), y, amended) @ y[3:], y[:3] @ y[3:]


def f3_f4(inertia: Array, y: Array, any_length: bool = False) -> Array:
    """Return f_3 and f_4 of eq. (ints)."""
    w, gamma, K = y[:3], y[3:], capital_k(inertia, y, any_length)
    along = along_gamma(inertia, y, any_length)
    return np.array([0.5 * (K @ w) - 0.5 * (K @ gamma) * along, K @ K])


@claim(
    "ints",
    "f_3 = ½(K⃗, w⃗) − ½(K⃗, γ⃗)(𝓘⁰w⃗, γ⃗) and f_4 = (K⃗, K⃗) are integrals at any f_1",
    "1172–1178",
    everywhere=True,
    off_manifold="with " + ANY_LENGTH + ", and the second factor in f_3 divided by (γ⃗, γ⃗) too",
    finding="3.2",
)
def ints(point: Point, amended: bool) -> Sides:
    return integral(point, lambda y: f3_f4(tensor(point), y, amended))


@claim(
    "text:reduced-integrals",
    "on f_1 = 0 these are ½(𝓘w⃗, w⃗) and (Iw⃗, Iw⃗) − (Iw⃗, γ⃗)², I of (tr1)",
    "1180–1183",
    misprint="½(𝓘w⃗, w⃗) and (𝓘w⃗, 𝓘w⃗) − (𝓘w⃗, γ⃗)²: script 𝓘 throughout",
)
def reduced_integrals(point: Point, corrected: bool) -> Sides:
    inertia, y = tensor(point), state(point, constrained=True)
    w, gamma = y[:3], y[3:]
    Iw = (inertia if corrected else ball_tensor(point, inertia)) @ w
    return f3_f4(inertia, y), [0.5 * (inertia @ w @ w), Iw @ Iw - (Iw @ gamma) ** 2]


@claim(
    "text:euler-jacobi-veselova",
    "f_1 … f_4 are independent: quadratures on all of R⁶",
    "1185–1187",
)
def euler_jacobi(point: Point) -> Sides:
    def integrals(y: Array) -> Array:
        return np.array([y[:3] @ y[3:], y[3:] @ y[3:], *f3_f4(tensor(point), y)])

    return rank(gradient(integrals, state(point))), 4


def ball_tensor(point: Point, inertia: Array) -> Array:
    """Return I = D(𝓘 − 1)⁻¹, eq. (tr1)."""
    return point.D * np.linalg.inv(inertia - np.eye(3))


@claim("tr1", "𝓘 = 1 + DI⁻¹, w⃗ = −Iω⃗ ⇔ I = D(𝓘 − 1)⁻¹, ω⃗ = −(𝓘 − 1)w⃗/D", "1198–1204")
def tr1(point: Point) -> Sides:
    script, w = tensor(point), point.normal("w", 3)
    latin = ball_tensor(point, script)
    omega = -(script - np.eye(3)) @ w / point.D
    back = np.eye(3) + point.D * np.linalg.inv(latin)
    return [*np.ravel(back), *(-latin @ omega)], [*np.ravel(script), *w]


@claim(
    "fedorov",
    "Theorem 6: (tr1) maps f_1 = c_1, f_2 = 1, f_3 = c_3, f_4 = c_4 to F_1 = c_1, "
    "F_2 = 1, F_3 = c_3, F_4 = c_4",
    "1206–1213",
    misprint="F_1 = −c_1, F_2 = 1, F_3 = (c_4/2 − c_3)/D, F_4 = c_4",
)
def fedorov(point: Point, corrected: bool) -> Sides:
    script, y = tensor(point), state(point)
    w, gamma, D = y[:3], y[3:], point.D
    latin = ball_tensor(point, script)
    omega = -(script - np.eye(3)) @ w / D
    k = classical_k(point, latin, omega, gamma)
    left = [k @ gamma, gamma @ gamma, 0.5 * (k @ omega), k @ k]
    c1, (c3, c4) = w @ gamma, f3_f4(script, y)
    return left, [-c1, 1.0, (c4 / 2 - c3) / D, c4] if corrected else [c1, 1.0, c3, c4]


@claim("text:fedorov-tangent", "both flows are tangent to the common tori, at any f_1", "1206–1213")
def fedorov_tangent(point: Point) -> Sides:
    """F_1 … F_4 of the ball, as functions of (K⃗, γ⃗) = (−k⃗, γ⃗), are constant along (3.2)."""
    script = tensor(point)
    latin = ball_tensor(point, script)

    def ball_integrals(z: Array) -> Array:
        k, gamma = -capital_k(script, z), z[3:]
        omega = classical_omega(point, latin, k, gamma)
        return np.array([k @ gamma, 0.5 * (k @ omega), k @ k])

    return integral(point, ball_integrals)


@claim(
    "text:neumann",
    "f_1 = 0: the Veselova problem is a Neumann system, γ″ = −Aγ + νγ with 𝓘_i = a_i/(a_1a_2a_3), "
    "in the time ds = √((𝓘w⃗, w⃗)/(γ⃗, A⁻¹γ⃗)) dt",
    "1187–1189",
)
def neumann(point: Point) -> Sides:
    A, y = point.a, state(point, constrained=True)
    inertia = np.diag(A) / np.prod(A)

    def slope(z: Array) -> Array:
        """Return γ′ = dγ/ds."""
        w, gamma = z[:3], z[3:]
        return np.asarray(np.cross(gamma, w) / rate(z))

    def rate(z: Array) -> Any:
        """Return ds/dt."""
        w, gamma = z[:3], z[3:]
        return np.sqrt((inertia @ w @ w) / (gamma @ (gamma / A)))

    gamma = y[3:]
    bent = derivative(slope, y, veselova_field(inertia, y)) / rate(y)
    return np.cross(bent, gamma), np.cross(-A * gamma, gamma), np.max(np.abs(bent))


claim.unchecked(
    "text:veselova-change",
    "f_1 = c_1 ≠ 0 is carried to f_1 = 0 by a linear change (K⃗, γ⃗) ↦ (K⃗_1, γ⃗_1) and a time change",
    "1189–1196",
    "cites a map and prints none",
)
claim.unchecked(
    "text:clebsch",
    "two isomorphisms of the ball at F_1 = 0 with the Clebsch case",
    "1215–1220",
    "cites two maps and prints none",
)
