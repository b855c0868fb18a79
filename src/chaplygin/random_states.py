"""Random directions, tangents and rotations: what random states are made of."""

from __future__ import annotations

from typing import Any

import numpy as np

from .manifold import Array

__all__ = ["random_direction", "random_rotation", "random_tangent", "random_tangent_state"]

Generator = np.random.Generator


def random_direction(rng: Generator, n: int) -> Array:
    """Return a unit vector, uniform on S^(n−1)."""
    v = rng.normal(size=n)
    return np.asarray(v / np.sqrt(v @ v))


def random_tangent(rng: Generator, gamma: Array) -> Array:
    """Return a normal vector's part orthogonal to γ, which need not be a unit vector."""
    p = rng.normal(size=len(gamma))
    for _ in range(2):
        p = p - (gamma @ p) / (gamma @ gamma) * gamma
    return np.asarray(p)


def random_tangent_state(rng: Generator, n: int) -> dict[str, Any]:
    """Return γ and p as the components of a state on T*S^(n−1)."""
    gamma = random_direction(rng, n)
    return {"gamma": gamma, "p": random_tangent(rng, gamma)}


def random_rotation(rng: Generator, n: int) -> Array:
    """Return a rotation of R^n, uniform (Haar's measure), shape (n, n)."""
    q, r = np.linalg.qr(rng.normal(size=(n, n)))
    q = q * np.sign(np.diag(r))
    q[0] *= np.linalg.det(q)
    for _ in range(2):  # orthogonal to rounding, as the signs and the determinant leave it
        q = q @ (1.5 * np.eye(n) - 0.5 * q.T @ q)
    return np.asarray(q)
