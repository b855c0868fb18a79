"""The Veselova problem on SO(n) and on the Stiefel variety V(n, r): states, motion, equations."""

from __future__ import annotations

from typing import Any

import numpy as np

from .algebra import Array, apply, inner, wedge
from .calculus import derivative
from .motion import constrained_rotation
from .points import Point

__all__ = [
    "admissible",
    "constraint_forms",
    "momentum_matrix",
    "phi_r",
    "rank_of",
    "span",
    "stiefel",
    "stiefel_rates",
    "veselova_motion",
]


def rank_of(point: Point) -> int:
    """Return r = 1 … n − 2, by turns of the points; the constraints are those of so(n − r)."""
    return 1 + point.seed[-1] % (point.n - 2)


def span(point: Point) -> list[Array]:
    """Return 𝔡 = span{E_i∧E_j, i ≤ r}."""
    E, r = np.eye(point.n), rank_of(point)
    return [wedge(E[i], E[j]) for i in range(r) for j in range(point.n) if i < j]


def constraint_forms(point: Point, printed: bool = False) -> list[Array]:
    """Return E_i∧E_j, r + 1 ≤ i < j ≤ n; as printed, n − r + 1 ≤ i < j ≤ n."""
    n, r = point.n, rank_of(point)
    E, start = np.eye(n), n - r if printed else r
    return [wedge(E[i], E[j]) for i in range(start, n) for j in range(i + 1, n)]


def admissible(point: Point) -> Array:
    """Return a random w with Ad_g w in 𝔡."""
    Omega = sum(
        c * X for c, X in zip(point.normal("w", len(span(point))), span(point), strict=True)
    )
    return np.asarray(point.g.T @ Omega @ point.g)


def veselova_motion(point: Point) -> tuple[Array, Array]:
    """Return w and ẇ of the LR system with a general operator, from d'Alembert's principle."""
    w = admissible(point)
    return w, constrained_rotation(point, point.general, w, constraint_forms(point))[0]


def stiefel(point: Point) -> tuple[Array, Array, Array]:
    """Return X = (e_1, …, e_r), Ẋ and w at a random admissible state."""
    w = admissible(point)
    X = point.g.T[:, : rank_of(point)]
    return X, -w @ X, w


def phi_r(X: Array, X_dot: Array) -> Array:
    """Return Φ_r(X, Ẋ), first form printed."""
    inside = X.T @ X_dot - X_dot.T @ X
    return np.asarray(X @ X_dot.T - X_dot @ X.T + 0.5 * X @ inside @ X.T)


def momentum_matrix(point: Point, X: Array, X_dot: Array) -> Array:
    """Return P = ∂L_red/∂Ẋ, eq. (dotX->P)."""

    def lagrangian(v: Array) -> Any:
        phi = phi_r(X, v.reshape(X.shape))
        return 0.5 * inner(apply(point.general, phi), phi)

    return np.asarray(bilinear_gradient(lagrangian, np.ravel(X_dot)).reshape(X.shape))


def bilinear_gradient(f: Any, v: Array) -> Array:
    """Return the gradient of a quadratic form, exact for complex v too."""
    return np.array([0.5 * (f(v + e) - f(v - e)) for e in np.eye(len(v))])


def stiefel_rates(point: Point) -> tuple[list[Array], list[Array]]:
    """Return the printed (Ẋ, Ṗ), and the motion's: P differentiated along Ẋ = −wX and ẇ."""
    X, X_dot, _ = stiefel(point)
    w, rate = veselova_motion(point)
    acceleration = -rate @ X - w @ X_dot
    shape = (2, *X.shape)

    def momenta(z: Array) -> Array:
        place, velocity = z.reshape(shape)
        return momentum_matrix(point, place, velocity)

    here, moving = np.ravel([X, X_dot]), np.ravel([X_dot, acceleration])
    P, P_dot = momentum_matrix(point, X, X_dot), derivative(momenta, here, moving)
    phi = phi_r(X, X_dot)
    return [-phi @ X, -phi @ P], [(point.g @ w).T[:, : X.shape[1]], P_dot]
