"""The exact flow of the ball in R³ at any area constant, through Chaplygin's change of variables.

`chaplygin_change` takes the motion to one of another ball with area constant zero, whose Hamiltonised
flow is exact in its τ. Time runs as dt = (D₁√U/(dt₁/dt)) dτ, again a function on the torus.
`chaplygin.correspondence.maps` has the equations of the change, and it as a map of problems.
"""

from dataclasses import dataclass

import numpy as np

import geomint as gi

from ..inertia import Inertia, SpecialInertia
from ..manifold import PARALLEL, Array, length
from .clock import Clock, sampled_clock
from .flow import ExactFlow
from .separated_energy import SeparatedEnergy
from .symmetry import power_of_two, unit_of

SMALLEST = 1e-12  # D₁/D: below it nothing but rounding is left of the difference of both balls


@dataclass(frozen=True)
class WithoutArea:
    """The other ball, and the map of the motion's states to its.

    Attributes
    ----------
    inertia : SpecialInertia
        I₁ = I + D − D₁, and D₁.
    forward, backward : array, shape (2, 2)
        (k⃗, γ⃗) ↦ (k⃗₁, γ⃗₁), and its inverse.
    """

    inertia: SpecialInertia
    forward: Array
    backward: Array


def principal_moments(inertia: Inertia) -> Array:
    """Return I₁, I₂, I₃ of an operator in its principal axes, or raise `geomint.DomainError`."""
    if inertia.diagonal is None:
        raise gi.DomainError("inertia", inertia.matrix, "an operator in principal axes")
    return inertia.diagonal[::-1]


def without_area(moments: Array, D: float, y: Array) -> WithoutArea:
    """Return the ball with area constant zero for the motion through y = (k⃗, γ⃗), |γ⃗| = 1.

    Raises
    ------
    geomint.DomainError
        If k⃗ and γ⃗ are parallel, which is a steady turn about the vertical, or nearly so.
    """
    # In units in which |k⃗| is about 1: the sizes of k⃗ and γ⃗ have nothing to do with each other.
    size = power_of_two(np.max(np.abs(y[:3])))
    k, gamma = y[:3] / size, y[3:]
    D1, matrix = _plane(D, _energy(moments, D, k, gamma), k, gamma)
    matrix = matrix * np.array([[1.0, size], [1.0 / size, 1.0]])
    # |k⃗₁×γ⃗₁| = |k⃗|: the determinant, without the cancellation.
    slant = np.linalg.norm(k) / np.linalg.norm(np.cross(k, gamma))
    inverse = np.array([[matrix[1, 1], -matrix[0, 1]], [-matrix[1, 0], matrix[0, 0]]]) / slant
    if not D1 > SMALLEST * D:
        expected = f"a state whose k and gamma are less parallel: D of the other ball is {D1:.3g}"
        raise gi.DomainError("y", y, expected)
    return WithoutArea(SpecialInertia.from_moments(moments + D - D1, D1), matrix, inverse)


def _energy(moments: Array, D: float, k: Array, gamma: Array) -> float:
    """Return ½(k⃗, ω⃗), ω⃗ = B(k⃗ + D(ω⃗, γ⃗)γ⃗), B = (I + D)⁻¹."""
    total = moments + D
    turning = (gamma / total) @ k / (gamma * (moments / total) @ gamma)
    return 0.5 * float(k @ ((k + D * turning * gamma) / total))


def _plane(D: float, h: float, k: Array, gamma: Array) -> tuple[float, Array]:
    """Return D₁ and the matrix of (k⃗, γ⃗) ↦ (k⃗₁, γ⃗₁) for the motion through both."""
    c, size = float(k @ gamma), float(k @ k)
    apart = float(np.linalg.norm(np.cross(k, gamma)))
    if apart <= PARALLEL * np.sqrt(size):
        raise gi.DomainError(
            "y", np.concatenate([k, gamma]), "a state whose k and gamma are not parallel"
        )
    # 2hD δ² + b δ − c² = 0, the root in (−1, 0], and δ/c, without cancellation. At c = 0 is b < 0.
    b = 2.0 * h * D - size
    root = np.sqrt(b * b + 8.0 * h * D * c * c)
    ratio = -2.0 * c / (root - b) if b < 0.0 else -(b + root) / (4.0 * h * D * c)
    # Nearly parallel vectors: 1 + δ is a root of 2hD x² − (2hD + (k⃗, k⃗)) x + |k⃗×γ⃗|² = 0, and
    # δ/c k⃗ + γ⃗ is κk⃗ and the part of γ⃗ across k⃗, with κ(k⃗, k⃗) = 2hD (1 + δ) δ/c.
    left = 2.0 * apart * apart / (2.0 * h * D + size + root)
    along = 2.0 * h * D * left * ratio
    norm = np.sqrt((along * along + apart * apart) / size)
    # k⃗₁ is γ⃗₁ turned in the plane of k⃗ and γ⃗.
    momentum = np.array([left, -along]) * (np.sqrt(size) / apart)
    return D * left, np.array([momentum, [ratio, 1.0]]) / norm


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
        return super().rate(states) / along

    def _turning(self, y: Array) -> Array:
        """Return (ω⃗, γ⃗) = (γ⃗, Bk⃗)/(γ⃗, Wγ⃗) of states of the given ball."""
        k, gamma = y[..., :3], y[..., 3:]
        above = np.sum(gamma * self._b * k, axis=-1)
        return above / np.sum(gamma * self._w * gamma, axis=-1)

    def angular_velocity(self, y: Array) -> Array:
        """Return ω⃗ = B(k⃗ + D(ω⃗, γ⃗)γ⃗) of states, shape (..., 3), in the body."""
        s = self._turning(y)[..., None]
        return self._b * (y[..., :3] + self._own * s * y[..., 3:])

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
        return both.reshape(*both.shape[:-2], 6)

    @property
    def _units(self) -> Array:
        return np.array([[self._size], [1.0]])
