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
from geomint import section

from ..ball.classical import DIAGONAL, classical_parameters, diagonal_omega
from ..ball.sphere import ChaplyginSphere
from ..exact.area import principal_moments, without_area
from ..manifold import Array
from .correspondence import Correspondence

__all__ = ["chaplygin_change"]


@gi.observable
def new_time(params: Any, t: Any, y: Any, work: Any) -> Any:
    """dt₁/dt = α + ζ D(ω⃗, γ⃗); α and ζ are its own of the parameters."""
    w0, w1, w2 = diagonal_omega(params, y)
    own, D = section(params, DIAGONAL, "own"), section(params, DIAGONAL, "D")
    return own[0] + own[1] * D[0] * (w0 * y[3] + w1 * y[4] + w2 * y[5])


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
    moments = principal_moments(sphere.inertia)
    change = without_area(moments, sphere.D, problem.canonical(y))
    matrix, inverse = change.forward, change.backward
    other = ChaplyginSphere(inertia=change.inertia)
    _, params = classical_parameters(np.diag(moments), sphere.D, inverse[:, 0])
    source = dataclasses.replace(problem, params=params.data)

    def forward(point: Array) -> Array:
        return np.asarray((matrix @ point.reshape(2, 3)).reshape(-1))

    def backward(point: Array) -> Array:
        return np.asarray((inverse @ point.reshape(2, 3)).reshape(-1))

    return Correspondence(
        "chaplygin-change", source, other.classical(), forward, backward, new_time
    )
