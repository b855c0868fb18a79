"""Fedorov's correspondence of tori, n = 3: Veselova's problem and the ball at any f₁ and F₁.

Theorem 6 of the paper, with the constants that really correspond. With 𝓘 = 1 + DI⁻¹ and w⃗ = −Iω⃗, eq.
(tr1), the momenta of (3.2) and (Chap) are opposite, K⃗ = −k⃗, with the same γ⃗, and

    F₁ = −f₁,   F₂ = f₂ = 1,   F₃ = (f₄/2 − f₃)/D,   F₄ = f₄.

Tori go to tori and, with the same γ⃗, both are turned by their own angular velocity: the two *flows* on
them are different, so that this is no `Correspondence`.
"""

import numpy as np

import geomint as gi

from ..ball.sphere import ChaplyginSphere
from ..inertia import SpecialInertia, positive_vector
from ..manifold import Array
from ..veselova.body import Veselova, veselova_factors


def fedorov_body(sphere: ChaplyginSphere) -> Veselova:
    """Return the body with the moments 𝓘 = 1 + D/I of a ball in principal axes, n = 3."""
    if sphere.n != 3 or sphere.inertia.diagonal is None:
        expected = "a ball in R³ in principal axes"
        raise gi.DomainError("inertia", sphere.inertia.diagonal, expected)
    return Veselova(veselova_factors(1.0 + sphere.D / sphere.inertia.diagonal[::-1]), sphere.D)


def fedorov_ball(moments: Array, D: float) -> ChaplyginSphere:
    """Return the ball with the moments I = D/(𝓘 − 1) of a body with all 𝓘_i > 1.

    Raises
    ------
    geomint.DomainError
        If some 𝓘_i ≤ 1: such a body has no ball.
    """
    values = gi.as_vector("moments", positive_vector("moments", moments), 3)
    if not (values > 1.0).all():
        raise gi.DomainError("moments", moments, "principal moments that are all greater than 1")
    return ChaplyginSphere(inertia=SpecialInertia.from_moments(D / (values - 1.0), D))


def fedorov_state(y: Array) -> Array:
    """Return (K⃗, γ⃗) of (k⃗, γ⃗), or back: the momentum changes its sign."""
    return np.concatenate([-y[:3], y[3:]])


def fedorov_constants(f1: float, f3: float, f4: float, D: float) -> tuple[float, float, float]:
    """Return (F₁, F₃, F₄) of the ball's torus from (f₁, f₃, f₄) of the body's, f₂ = F₂ = 1."""
    return -f1, (0.5 * f4 - f3) / D, f4
