"""The actual motions of nonholonomic systems by d'Alembert's principle, and by nothing else.

`accelerations` takes a kinetic energy and constraint one-forms in any coordinates. On SO(n) the
coordinates are those of Cayley around the state, g(X) = g (1 − X/2)⁻¹(1 + X/2), X ∈ so(n): then
g(X)⁻¹ġ = (1 + X/2)⁻¹ Ẋ (1 − X/2)⁻¹ exactly, and Ẋ = ω, Ẍ = ω̇ at X = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .algebra import Array, coordinates, inner, skew, wedge
from .calculus import derivative, gradient
from .points import Point

__all__ = [
    "BallMotion",
    "accelerations",
    "ball_motion",
    "constrained_rotation",
    "general_motion",
    "zero_momentum_motion",
]


def accelerations(
    velocity: Callable[[Array, Array], Array],
    metric: Array,
    constraints: Callable[[Array], Array],
    x: Array,
    v: Array,
) -> tuple[Array, Array]:
    """Return v̇ and the multipliers λ of d/dt ∂L/∂v − ∂L/∂x = αᵀλ, α(x)v = 0.

    L(x, v) = ½(u, Gu), with a constant `metric` G and u = `velocity` (x, v), linear in v.
    """
    unit = np.eye(len(x))

    def rows(x: Array) -> Array:
        return np.array([velocity(x, e) for e in unit])

    def momenta(x: Array) -> Array:
        return np.asarray(rows(x) @ (metric @ velocity(x, v)))

    here = rows(x)
    slope = here @ metric @ here.T
    pull = gradient(lambda z: velocity(z, v), x).T @ (metric @ velocity(x, v))
    alpha = constraints(x)
    k = len(alpha)
    matrix = np.block([[slope, -alpha.T], [alpha, np.zeros((k, k))]])
    turning = derivative(lambda z: constraints(z) @ v, x, v)
    right = np.concatenate([pull - derivative(momenta, x, v), -turning])
    solution = np.linalg.solve(matrix, right)
    return solution[: len(x)], solution[len(x) :]


@dataclass(frozen=True)
class BallMotion:
    """State and rates of the rolling ball: ω, ω̇ in the body, V, V̇ and the reaction Λ in space."""

    omega: Array
    omega_dot: Array
    V: Array
    V_dot: Array
    Lambda: Array

    @property
    def size(self) -> float:
        """|ω|², the size of the terms of ω̇; all of them cancel at n = 2."""
        return float(np.sum(self.omega**2))


def _rotation(point: Point, x: Array) -> Array:
    half, one = 0.5 * skew(x, point.n), np.eye(point.n)
    return np.asarray(point.g @ np.linalg.solve(one - half, one + half))


def _angular_velocity(n: int, x: Array, v: Array) -> Array:
    half, one = 0.5 * skew(x, n), np.eye(n)
    return np.asarray(np.linalg.solve(one + half, skew(v, n)) @ np.linalg.inv(one - half))


def ball_motion(point: Point, inertia: Array, omega: Array) -> BallMotion:
    """Return the motion of the rolling ball on SO(n) × Rⁿ, with constraints V − ρΩΓ = 0."""
    n, size = point.n, len(inertia)

    metric = np.block([[inertia, np.zeros((size, n))], [np.zeros((n, size)), point.m * np.eye(n)]])

    def both(x: Array, v: Array) -> Array:
        turning = coordinates(_angular_velocity(n, x[:size], v[:size]))
        return np.concatenate([turning, v[size:]])

    def constraints(x: Array) -> Array:
        g = _rotation(point, x[:size])
        contact = [g @ _angular_velocity(n, x[:size], e) @ g.T @ point.Gamma for e in np.eye(size)]
        return np.hstack([-point.rho * np.array(contact).T, np.eye(n)])

    V = point.rho * (point.g @ omega @ point.gamma)
    velocity = np.concatenate([coordinates(omega), V])
    rate, Lambda = accelerations(both, metric, constraints, np.zeros(size + n), velocity)
    return BallMotion(omega, skew(rate[:size], n), V, rate[size:], Lambda)


@lru_cache(maxsize=256)
def general_motion(point: Point) -> BallMotion:
    """Return the motion of the ball with a general operator and any momentum at the point."""
    return ball_motion(point, point.general, point.omega)


@lru_cache(maxsize=256)
def zero_momentum_motion(point: Point, special: bool = False) -> BallMotion:
    """Return the motion of the ball with k = γ∧p, for the general or the special operator."""
    inertia = point.special if special else point.general
    k = wedge(point.gamma, point.p)
    return ball_motion(point, inertia, point.omega_of(inertia, k, point.gamma))


def constrained_rotation(
    point: Point, inertia: Array, omega: Array, forms: Sequence[Array]
) -> tuple[Array, Array]:
    """Return ω̇ and λ of an LR system on SO(n): constraints ⟨gωg⁻¹, C⟩ = 0 for all C of `forms`."""
    n, size = point.n, len(inertia)

    def turning(x: Array, v: Array) -> Array:
        return coordinates(_angular_velocity(n, x, v))

    def constraints(x: Array) -> Array:
        g = _rotation(point, x)
        turned = [g @ _angular_velocity(n, x, e) @ g.T for e in np.eye(size)]
        return np.array([[inner(w, C) for w in turned] for C in forms]).reshape(-1, size)

    rate, multipliers = accelerations(
        turning, inertia, constraints, np.zeros(size), coordinates(omega)
    )
    return skew(rate, n), multipliers
