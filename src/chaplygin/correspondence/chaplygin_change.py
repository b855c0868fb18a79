"""Chaplygin's change of variables: the ball in R³ at any area constant, and one at area zero.

A motion with c = (k⃗, γ⃗), h = ½(k⃗, ω⃗) and F = (k⃗, k⃗) is also that of a ball with another D and other
moments, without area constant: with δ = D₁/D − 1,

    (2hD₁ − F) δ = c²,   I₁ + D₁ = I + D,
    γ⃗₁ = (δk⃗ + cγ⃗)/|…|,   k⃗₁ ∈ span{k⃗, γ⃗},   k⃗₁ ⟂ γ⃗₁.

Of the two roots D₁ the one in (0, D] is taken: I₁ ≥ I, and where c = 0, D₁ = D. k⃗ and γ⃗ have constant
products, so both maps are linear with constant coefficients along a motion. Both pairs turn with the
same ω⃗, up to its length: with k⃗ = αk⃗₁ + βγ⃗₁ and γ⃗ = ζk⃗₁ + εγ⃗₁,

    dt₁/dt = α + ζ D(ω⃗, γ⃗),

which is no constant. The scale of k⃗₁ is free, and taken so that |k⃗₁| = |k⃗|.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

import geomint as gi

from ..ball.classical import diagonal_omega
from ..ball.sphere import ChaplyginSphere
from ..inertia import SpecialInertia
from ..manifold import PARALLEL, Array
from .correspondence import Correspondence

__all__ = ["chaplygin_change"]

SMALLEST = 1e-12  # D₁/D: below it nothing but rounding is left of the difference of both balls


@gi.observable
def new_time(params: Any, t: Any, y: Any, work: Any) -> Any:
    """dt₁/dt = α + ζ D(ω⃗, γ⃗); the parameters of the ball with α and ζ at their end."""
    w0, w1, w2 = diagonal_omega(params, y)
    last = len(params)
    return params[last - 2] + params[last - 1] * params[0] * (w0 * y[3] + w1 * y[4] + w2 * y[5])


def chaplygin_change(sphere: ChaplyginSphere, y: Any) -> Correspondence:
    """Return the correspondence of a motion of the ball in R³ and one with area constant zero.

    Parameters
    ----------
    sphere : ChaplyginSphere
        n = 3, in its principal axes.
    y : array_like
        A state (k⃗, γ⃗) of ``sphere.classical()``; only states with the same energy, (k⃗, k⃗) and
        (k⃗, γ⃗) correspond.

    Raises
    ------
    geomint.DomainError
        If n is not 3 or the inertia tensor is not diagonal; if k⃗ and γ⃗ are parallel, which is a
        steady turn about the vertical.
    """
    problem = sphere.classical()
    if sphere.inertia.diagonal is None:
        raise gi.DomainError("inertia", sphere.inertia.matrix, "an operator in principal axes")
    state = problem.canonical(y)
    moments = sphere.inertia.diagonal[::-1]
    # In units in which |k⃗| is about 1: the sizes of k⃗ and γ⃗ have nothing to do with each other.
    size = float(np.ldexp(1.0, int(np.frexp(np.max(np.abs(state[:3])))[1])))
    scaled = np.concatenate([state[:3] / size, state[3:]])
    D1, matrix = _plane(sphere.D, gi.value(problem, "energy", scaled), scaled)
    matrix = matrix * np.array([[1.0, size], [1.0 / size, 1.0]])
    # |k⃗₁×γ⃗₁| = |k⃗|: the determinant, without the cancellation.
    slant = np.linalg.norm(scaled[:3]) / np.linalg.norm(np.cross(scaled[:3], scaled[3:]))
    inverse = np.array([[matrix[1, 1], -matrix[0, 1]], [-matrix[1, 0], matrix[0, 0]]]) / slant
    if not D1 > SMALLEST * sphere.D:
        expected = f"a state whose k and gamma are less parallel: D of the other ball is {D1:.3g}"
        raise gi.DomainError("y", y, expected)
    other = ChaplyginSphere(inertia=SpecialInertia.from_moments(moments + sphere.D - D1, D1))
    source = dataclasses.replace(problem, params=np.concatenate([problem.params, inverse[:, 0]]))

    def forward(point: Array) -> Array:
        return np.asarray((matrix @ point.reshape(2, 3)).reshape(-1))

    def backward(point: Array) -> Array:
        return np.asarray((inverse @ point.reshape(2, 3)).reshape(-1))

    return Correspondence(
        "chaplygin-change", source, other.classical(), forward, backward, new_time
    )


def _plane(D: float, h: float, y: Array) -> tuple[float, Array]:
    """Return D₁ and the matrix of (k⃗, γ⃗) ↦ (k⃗₁, γ⃗₁) for the motion through y."""
    k, gamma = y[:3], y[3:]
    c, size = float(k @ gamma), float(k @ k)
    apart = float(np.linalg.norm(np.cross(k, gamma)))
    if apart <= PARALLEL * np.sqrt(size):
        raise gi.DomainError("y", y, "a state whose k and gamma are not parallel")
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
