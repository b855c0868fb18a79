"""The exact flow of the ball in R³ at any area constant, through Chaplygin's change of variables.

`chaplygin_change` takes the motion to one of another ball with area constant zero, whose Hamiltonised
flow is exact in its τ. Time runs as dt = (D₁√U/(dt₁/dt)) dτ, again a function on the torus.
"""

import numpy as np

from ..inertia import Inertia
from ..manifold import Array, length
from .area import principal_moments, without_area
from .clock import Clock, sampled_clock
from .flow import ExactFlow
from .separated_energy import SeparatedEnergy
from .symmetry import power_of_two, unit_of


class BallFlow(ExactFlow):
    """A motion whose dt/dτ is a function of the state (k⃗, γ⃗), with the signs of its components."""

    def _make_clock(self) -> Clock:
        return sampled_clock(self.torus, lambda phi: self.rate(self.at_angles(phi)), 2)


class ExactBall(BallFlow):
    """The motion of the ball in R³ through one state (k⃗, γ⃗), at any time.

    Made by ``problem.exact(y0)`` of a classical ball in its principal axes. Call it with physical
    times; `at_tau` takes times τ of the ball with area constant zero. Angles and frequencies are that
    ball's.

    Parameters
    ----------
    inertia : SpecialInertia or GeneralInertia
        n = 3.
    D : float
    y : array, shape (6,)
        The state at time 0.

    Raises
    ------
    geomint.DomainError
        As `ExactFlow`; for a tensor that is not diagonal, and where k⃗ and γ⃗ are parallel.
    """

    def __init__(self, inertia: Inertia, D: float, y: Array) -> None:
        moments = principal_moments(inertia)
        other = without_area(moments, D, np.concatenate([y[:3], unit_of(y[3:])]))
        k, gamma = y[:3] / length(y[:3]), y[3:] / length(y[3:])
        self._slant = 1.0 / length(np.cross(k, gamma))
        # In units of k⃗, whose size has nothing to do with that of γ⃗.
        self._size = power_of_two(np.max(np.abs(y[:3])))
        self._forward = other.forward * np.array([[1.0, 1.0 / self._size], [self._size, 1.0]])
        (p, q), (r, s) = self._forward
        self._backward = np.array([[s, -q], [-r, p]]) / self._slant  # its determinant
        # ω⃗ = B(k⃗ + D(ω⃗, γ⃗)γ⃗), and dt₁/dt = α + ζ D(ω⃗, γ⃗): see `chaplygin_change`.
        total = moments + D
        self._b, self._w, self._own = 1.0 / total, moments / total, D
        D1 = other.inertia.D
        super().__init__(other.inertia.a, D1, SeparatedEnergy(D1, -1.0), y, True)

    def _magnified(self) -> float:
        """1 over the sine of the angle of k⃗ and γ⃗: the change of variables is made of their plane."""
        return self._slant

    def _growth(self, steepest: float) -> float:
        """Return it as often again: frequencies are made of 1 − a_ia_j/D₁, as small as D₁."""
        return self._slant * steepest

    def rate(self, states: Array) -> Array:
        """Return dt/dτ of states (k⃗, γ⃗), shape (..., 6) ↦ (...,)."""
        along = self._backward[0, 0] + self._backward[1, 0] * self._own * (
            self._turning(states) / self._size
        )
        return np.asarray(super().rate(states) / along)

    def _turning(self, y: Array) -> Array:
        """Return (ω⃗, γ⃗) = (γ⃗, Bk⃗)/(γ⃗, Wγ⃗) of states of the given ball."""
        k, gamma = y[..., :3], y[..., 3:]
        above = np.sum(gamma * self._b * k, axis=-1)
        return np.asarray(above / np.sum(gamma * self._w * gamma, axis=-1))

    def angular_velocity(self, y: Array) -> Array:
        """Return ω⃗ = B(k⃗ + D(ω⃗, γ⃗)γ⃗) of states, shape (..., 3), in the body."""
        s = self._turning(y)[..., None]
        return np.asarray(self._b * (y[..., :3] + self._own * s * y[..., 3:]))

    def inward(self, y: Array) -> Array:
        """Return (γ₁, p₁) of the ball with area constant zero from (k⃗, γ⃗)."""
        both = np.asarray(y).reshape(*np.shape(y)[:-1], 2, 3) / self._units
        both[..., 1, :] /= np.linalg.norm(both[..., 1:, :], axis=-1)
        k, gamma = np.moveaxis(self._forward @ both, -2, 0)
        # Where k⃗ and γ⃗ are nearly parallel k⃗₁ has more digits than γ⃗₁.
        along = np.sum(k * gamma, axis=-1, keepdims=True) / np.sum(k * k, axis=-1, keepdims=True)
        gamma = gamma - along * k
        return np.concatenate([gamma, self._size * np.cross(gamma, k)], axis=-1)

    def outward(self, y: Array) -> Array:
        """Return (k⃗, γ⃗) from (γ₁, p₁) of the ball with area constant zero."""
        gamma, p = y[..., :3], y[..., 3:] / self._size
        both = self._units * (self._backward @ np.stack([np.cross(p, gamma), gamma], axis=-2))
        return np.asarray(both.reshape(*both.shape[:-2], 6))

    @property
    def _units(self) -> Array:
        return np.array([[self._size], [1.0]])
