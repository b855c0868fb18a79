"""Particles held to a surface: a natural nonholonomic system whose motion is Newton's."""

from __future__ import annotations

from typing import Any

import numpy as np

from .algebra import Array
from .calculus import derivative
from .points import Point

__all__ = ["Particles"]


class Particles:
    """A natural system: points in Rᵈ held to x = x(q), with Newton's equations for x.

    d'Alembert: (∂x/∂q)ᵀ(m ẍ + ∇V) = αᵀλ, which needs no Lagrangian.
    """

    def __init__(self, point: Point) -> None:
        d = self.d = point.n + 1
        self.mass = point.uniform("mass", 0.5, 2.0, d)
        self.bend = 0.2 * point.normal("bend", d, d, d)
        self.alpha = point.normal("alpha", d // 2, d), point.normal("alpha1", d // 2, d, d)
        self.q = 0.2 * point.normal("q", d)
        start = point.normal("v", d)
        forms = self.constraints(self.q)
        self.v = start - forms.T @ np.linalg.solve(forms @ forms.T, forms @ start)

    def place(self, q: Array) -> Array:
        """Return x(q)."""
        return np.asarray(q + np.einsum("ijk,j,k->i", self.bend, q, q))

    def slope(self, q: Array) -> Array:
        """Return ∂x/∂q."""
        both = self.bend + np.swapaxes(self.bend, 1, 2)
        return np.asarray(np.eye(self.d) + np.einsum("ijk,k->ij", both, q))

    def potential(self, x: Array) -> Any:
        """Return V."""
        return np.sum(np.sin(x)) + (x @ x) ** 2 / 4.0

    def force(self, x: Array) -> Array:
        """Return −∇V."""
        return np.asarray(-np.cos(x) - (x @ x) * x)

    def constraints(self, q: Array) -> Array:
        """Return α(q)."""
        return np.asarray(self.alpha[0] + 0.3 * self.alpha[1] @ q)

    def lagrangian(self, q: Array, v: Array) -> Any:
        """Return L = ½Σ m ẋ² − V."""
        x_dot = self.slope(q) @ v
        return 0.5 * np.sum(self.mass * x_dot * x_dot) - self.potential(self.place(q))

    def hamiltonian(self, q: Array, p: Array) -> Any:
        """Return H = ½Σ κ^ij p_i p_j + V."""
        return 0.5 * (p @ np.linalg.solve(self.metric(q), p)) + self.potential(self.place(q))

    def metric(self, q: Array) -> Array:
        """Return κ(q)."""
        slope = self.slope(q)
        return np.asarray(slope.T @ (self.mass[:, None] * slope))

    def newton(self) -> tuple[Array, Array]:
        """Return v̇ and λ."""
        slope, alpha = self.slope(self.q), self.constraints(self.q)
        turning = derivative(self.slope, self.q, self.v) @ self.v
        pull = slope.T @ (self.force(self.place(self.q)) - self.mass * turning)
        k = len(alpha)
        matrix = np.block([[self.metric(self.q), -alpha.T], [alpha, np.zeros((k, k))]])
        swing = derivative(lambda q: self.constraints(q) @ self.v, self.q, self.v)
        solution = np.linalg.solve(matrix, np.concatenate([pull, -swing]))
        return solution[: self.d], solution[self.d :]

    def momentum_rate(self, rate: Array) -> Array:
        """Return d/dt of p = ∂L/∂v = κ v."""
        turned = derivative(lambda q: self.metric(q) @ self.v, self.q, self.v)
        return np.asarray(turned + self.metric(self.q) @ rate)
