"""Section 2.3, Classical Chaplygin sphere: n = 3, in vectors."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from .algebra import Array, bracket, hat, inner, rank, vector
from .calculus import derivative, gradient
from .claim import Section, Sides
from .classical import classical_field, classical_k, classical_omega, tensor_of
from .equations import log_rho
from .momenta import contact_momentum
from .motion import general_motion
from .points import Point
from .two_forms import conserved

__all__ = ["claim"]

claim = Section("2.3 Classical Chaplygin sphere", n=(3,))


@claim("iso", "X⃗ ↦ X: X y = X⃗ × y, [X, Y] is the matrix of X⃗ × Y⃗, ⟨X, Y⟩ = (X⃗, Y⃗)", "486–494")
def iso(point: Point) -> Sides:
    x, y = point.normal("x", 3), point.normal("y", 3)
    left = [hat(x) @ y, vector(bracket(hat(x), hat(y)))]
    cross = np.cross(x, y)
    return [*np.ravel(left), inner(hat(x), hat(y))], [*cross, *cross, x @ y]


@claim("Chap", "dk⃗/dt = k⃗ × ω⃗, dγ⃗/dt = γ⃗ × ω⃗, k⃗ = Iω⃗ + Dω⃗ − D(ω⃗, γ⃗)γ⃗", "495–502")
def classical(point: Point) -> Sides:
    moving = general_motion(point)
    k, rate = contact_momentum(point, point.general, moving)
    tensor, omega = tensor_of(point.general), vector(moving.omega)
    printed = classical_k(point, tensor, omega, point.gamma)
    gamma_dot = (point.g @ moving.omega).T @ point.Gamma
    right = [printed, np.cross(printed, omega), np.cross(point.gamma, omega)]
    return [vector(k), vector(rate), gamma_dot], right


@claim(
    "mu-ch",
    "ϱ = 1/√(det(I + D)(1 − D(γ⃗, (I + D)⁻¹γ⃗))) is invariant, and (mu*) at n = 3",
    "502–509",
)
def chaplygin_density(point: Point) -> Sides:
    tensor, gamma = tensor_of(point.general), point.gamma
    y = np.concatenate([classical_k(point, tensor, vector(point.omega), gamma), gamma])

    def log_density(gamma: Array) -> Any:
        shifted = tensor + point.D * np.eye(3)
        inside = 1.0 - point.D * (gamma @ np.linalg.solve(shifted, gamma))
        return -0.5 * np.log(np.linalg.det(shifted) * inside)

    slope = np.array(
        [derivative(lambda z: classical_field(point, tensor, z), y, e) for e in np.eye(6)]
    )
    rate = derivative(log_density, gamma, classical_field(point, tensor, y)[3:])
    terms = np.diag(slope)
    left = [np.sum(terms) + rate, log_density(gamma)]
    return left, [0.0, log_rho(point, point.general, gamma)], np.sum(np.abs(terms))


def classical_integrals(point: Point, tensor: Array, y: Array) -> Array:
    """Return F_1 … F_4, eq. (cl:int)."""
    k, gamma = y[:3], y[3:]
    omega = classical_omega(point, tensor, k, gamma)
    return np.array([k @ gamma, gamma @ gamma, 0.5 * (k @ omega), k @ k])


@claim(
    "cl:int",
    "F_1 = (k⃗, γ⃗), F_2 = (γ⃗, γ⃗), F_3 = ½(k⃗, ω⃗), F_4 = (k⃗, k⃗) are integrals",
    "510–515",
    everywhere=True,
)
def four_integrals(point: Point) -> Sides:
    tensor = tensor_of(point.general)
    y = np.concatenate([point.normal("k", 3), point.gamma])
    return conserved(
        partial(classical_integrals, point, tensor), classical_field(point, tensor, y), y
    )


@claim(
    "text:euler-jacobi",
    "four independent integrals and a measure in R⁶: tori by the Euler–Jacobi theorem",
    "517–519",
)
def euler_jacobi(point: Point) -> Sides:
    tensor = tensor_of(point.general)
    y = np.concatenate([point.normal("k", 3), point.gamma])
    return rank(gradient(lambda z: classical_integrals(point, tensor, z), y)), 4


@claim(
    "text:chaplygin-change",
    "a linear change (k⃗, γ⃗) ↦ (k⃗_1, γ⃗_1) carries any area constant to the zero "
    "one, the ball staying the same",
    "284–286, 522–525",
    restriction="with I, D changed too: I_1 + D_1 = I + D, (2hD_1 − F_4)(D_1/D − 1) = F_1², and "
    "time, by the factor |ω⃗|/|ω⃗_1|",
)
def chaplygin_change(point: Point, restricted: bool) -> Sides:
    """Compare ω⃗ with its part along ω⃗_1, at a few momenta; see `changed_velocity`."""
    momenta = point.normal("k", 4, 3)
    pairs = [changed_velocity(point, k, restricted) for k in momenta]
    parts = [(omega @ other) / (other @ other) * other for omega, other in pairs]
    return [omega for omega, _ in pairs], parts


def changed_velocity(point: Point, k: Array, restricted: bool) -> tuple[Array, Array]:
    """Return ω⃗ and ω⃗_1, which must be parallel.

    γ⃗_1 ∝ (D_1/D − 1)k⃗ + F_1γ⃗ and k⃗_1 ⟂ γ⃗_1, a combination of k⃗ and γ⃗ too, turn with ω⃗: they have
    constant coefficients.
    """
    tensor, D = tensor_of(point.general), point.D
    vectors = np.array([k, point.gamma])
    F1, _, F3, F4 = classical_integrals(point, tensor, np.ravel(vectors))
    # the smaller root, by the stable formula
    half = 0.5 * (2 * F3 + F4 / D)
    root = (F4 - F1**2) / (half + np.sqrt(half**2 - 2 * F3 / D * (F4 - F1**2)))
    first = np.array([root / D - 1.0, F1])
    gram = vectors @ vectors.T
    first = first / np.sqrt(first @ gram @ first)
    normal = gram @ first
    momentum = np.array([normal[1], -normal[0]])
    ball = point.with_(m=(root if restricted else D) / point.rho**2)
    changed = tensor + (D - root) * np.eye(3) if restricted else tensor
    omega = classical_omega(point, tensor, *vectors)
    return omega, classical_omega(ball, changed, momentum @ vectors, first @ vectors)
