"""The exact flow of the ball in R³ at any area constant, through Chaplygin's change of variables.

`chaplygin_change` takes the motion to one of another ball with area constant zero, whose Hamiltonised
flow is exact in its τ. Time runs as dt = (D₁√U/(dt₁/dt)) dτ, again a function on the torus.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..ball.sphere import ChaplyginSphere
from ..correspondence.chaplygin_change import chaplygin_change
from ..manifold import Array
from .flow import ExactFlow, sphere_weights

__all__ = ["ExactBall"]


class ExactBall(ExactFlow):
    """The motion of the ball in R³ through one state (k⃗, γ⃗), at any time.

    Made by ``problem.exact(y0)`` of a classical ball in its principal axes. Call it with physical
    times; `at_tau` takes times τ of the ball with area constant zero. Angles and frequencies are that
    ball's.

    Parameters
    ----------
    sphere : ChaplyginSphere
        n = 3, with three different moments.
    y : array, shape (6,)
        The state at time 0.

    Raises
    ------
    geomint.DomainError
        As `ExactFlow`; for a tensor that is not diagonal, and where k⃗ and γ⃗ are parallel.
    """

    def __init__(self, sphere: ChaplyginSphere, y: Array) -> None:
        change = chaplygin_change(sphere, y)
        self._backward = np.linalg.inv(_matrix(change.forward))
        first, D = change.forward(y), change.target.parameters["D"]
        a = np.array(change.target.parameters["a"])
        k, gamma = first[:3], first[3:]
        start = np.concatenate([gamma, np.cross(gamma, k)])
        super().__init__(a, D, sphere_weights(a, D), start, True)
        # ω⃗ = B(k⃗ + D(ω⃗, γ⃗)γ⃗), and dt₁/dt = α + ζ D(ω⃗, γ⃗): see `chaplygin_change`.
        moments = sphere.inertia.diagonal
        assert moments is not None
        self._b, self._w = (
            1.0 / (moments[::-1] + sphere.D),
            moments[::-1] / (moments[::-1] + sphere.D),
        )
        self._scale = sphere.D
        self._plain, self.rate, self._turns = self.rate, self._own_rate, 2

    def _own_rate(self, theta: Array) -> Array:
        """Return dt/dτ."""
        s = self._turning(self.states(theta))
        along = self._backward[0, 0] + self._backward[1, 0] * self._scale * s
        return np.asarray(self._plain(theta) / along)

    def _turning(self, y: Array) -> Array:
        """Return (ω⃗, γ⃗) = (γ⃗, Bk⃗)/(γ⃗, Wγ⃗) of states of the given ball."""
        k, gamma = y[..., :3], y[..., 3:]
        above = np.sum(gamma * self._b * k, axis=-1)
        return np.asarray(above / np.sum(gamma * self._w * gamma, axis=-1))

    def angular_velocity(self, y: Array) -> Array:
        """Return ω⃗ = B(k⃗ + D(ω⃗, γ⃗)γ⃗) of states, shape (..., 3), in the body."""
        s = self._turning(y)[..., None]
        return np.asarray(self._b * (y[..., :3] + self._scale * s * y[..., 3:]))

    def _vectors(self, gamma: Array, p_tilde: Array) -> Array:
        """Return (k⃗, γ⃗) of the given ball from (γ₁, p̃₁) of the other."""
        u = np.sum(gamma * gamma / self.a, axis=-1, keepdims=True)
        first = np.stack([np.cross(self.D * np.sqrt(u) * p_tilde, gamma), gamma], axis=-2)
        both = self._backward @ first
        return np.asarray(both.reshape(*both.shape[:-2], 6))

    def states(self, theta: Array) -> Array:
        """Return states (k⃗, γ⃗) at angles θ of the torus, shape (..., 2)."""
        return self._vectors(*self._map(theta))

    def angles(self, y: Any) -> Array:
        """Return φ of a state (k⃗, γ⃗) on the torus, modulo 2π, shape (2,)."""
        state = np.asarray(y, dtype=np.float64).reshape(2, 3)
        first = np.linalg.solve(self._backward, state)
        return super().angles(np.concatenate([first[1], np.cross(first[1], first[0])]))


def _matrix(forward: Any) -> Array:
    """Return the 2×2 matrix of the linear map (k⃗, γ⃗) ↦ (k⃗₁, γ⃗₁)."""
    columns = [forward(np.concatenate([x * np.eye(3)[0], z * np.eye(3)[0]])) for x, z in np.eye(2)]
    return np.array([[column[0], column[3]] for column in columns]).T
