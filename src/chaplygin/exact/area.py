"""The ball without area constant to which a motion of the ball in R³ belongs, in numbers.

`chaplygin.correspondence.maps` has the equations, and the change as a map of problems.
"""

from dataclasses import dataclass

import numpy as np

import geomint as gi

from ..inertia import Inertia, SpecialInertia
from ..manifold import PARALLEL, Array
from .symmetry import power_of_two

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
    return np.asarray(inertia.diagonal[::-1])


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
