"""The ball and the Veselova problem at n = 3, in vectors: printed equations that several claims use."""

from __future__ import annotations

from typing import Any

import numpy as np

from .algebra import Array, apply, hat, vector
from .points import Point

__all__ = [
    "along_gamma",
    "capital_k",
    "classical_field",
    "classical_k",
    "classical_omega",
    "iop1",
    "printed_lambda",
    "tensor_of",
    "three_moments",
    "veselova_field",
]


def tensor_of(inertia: Array) -> Array:
    """Return the inertia tensor of an operator on so(3)."""
    return np.array([vector(apply(inertia, hat(e))) for e in np.eye(3)]).T


def classical_k(point: Point, tensor: Array, omega: Array, gamma: Array) -> Array:
    """Return k⃗ = Iω⃗ + Dω⃗ − D(ω⃗, γ⃗)γ⃗."""
    return np.asarray(tensor @ omega + point.D * omega - point.D * (omega @ gamma) * gamma)


def classical_omega(point: Point, tensor: Array, k: Array, gamma: Array) -> Array:
    """Return ω⃗ of k⃗, by a solve."""
    matrix = tensor + point.D * (np.eye(3) - np.outer(gamma, gamma))
    return np.linalg.solve(matrix, k)


def classical_field(point: Point, tensor: Array, y: Array) -> Array:
    """Return the right-hand sides of eq. (Chap)."""
    k, gamma = y[:3], y[3:]
    omega = classical_omega(point, tensor, k, gamma)
    return np.concatenate([np.cross(k, omega), np.cross(gamma, omega)])


def three_moments(point: Point, key: str = "moments") -> tuple[Array, float]:
    """Return any principal moments of a ball in R³, and D; they need no triangle inequality."""
    return np.exp(point.uniform(key, -2.5, 2.5, 3)), float(
        np.exp(point.uniform(key + "D", -1.0, 1.0))
    )


def iop1(moments: Array, D: float) -> Array:
    """Return a_i of eq. (IOP1)."""
    shifted = moments + D
    top = np.sqrt(np.prod(moments) * D) * shifted
    return np.asarray(top / (moments * np.sqrt(np.prod(shifted))))


def printed_lambda(inertia: Array, w: Array, gamma: Array) -> Any:
    """Return λ of eq. (la)."""
    inverse = np.linalg.solve(inertia, gamma)
    return -(np.cross(inertia @ w, w) @ inverse) / (inverse @ gamma)


def veselova_field(inertia: Array, y: Array) -> Array:
    """Return (ẇ, γ̇) of eqs. (3.1), (la), for any w and γ."""
    w, gamma = y[:3], y[3:]
    torque = np.cross(inertia @ w, w) + printed_lambda(inertia, w, gamma) * gamma
    return np.concatenate([np.linalg.solve(inertia, torque), np.cross(gamma, w)])


def along_gamma(inertia: Array, y: Array, any_length: bool = False) -> Any:
    """Return (𝓘⁰w⃗, γ⃗), 𝓘⁰ = 𝓘 − 1; over (γ⃗, γ⃗) what holds whatever the length of γ⃗."""
    w, gamma = y[:3], y[3:]
    return ((inertia @ w - w) @ gamma) / (gamma @ gamma if any_length else 1.0)


def capital_k(inertia: Array, y: Array, any_length: bool = False) -> Array:
    """Return K⃗ = 𝓘w⃗ − (𝓘⁰w⃗, γ⃗)γ⃗."""
    return np.asarray(inertia @ y[:3] - along_gamma(inertia, y, any_length) * y[3:])
