"""The Gauss map: geodesics of the ellipsoid and motions of the Veselova problem."""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi
from geomint import sqrt

from ..manifold import Array
from ..related.ellipsoid import ellipsoid_problem, normal_squared
from ..veselova.body import Veselova
from .correspondence import Correspondence

__all__ = ["gauss_map"]


@gi.observable
def veselova_time(params: Any, t: Any, y: Any, work: Any) -> Any:
    """dt/ds = |A⁻¹x|⁻³ = U^(3/2), U = (γ, Aγ)."""
    total = normal_squared(params, y)
    return 1.0 / (total * sqrt(total))


def gauss_map(a: Any, D: Any = 1.0) -> Correspondence:
    """Return the correspondence of an ellipsoid's geodesics and the Veselova problem with 1/a_i.

    Φ(x, ẋ) = (γ, p), γ = A⁻¹x/|A⁻¹x|, p = ẋ, with dt = U^(3/2) ds, U = (γ, Aγ): the remark after
    eq. (ham:ves), where |Aγ| is misprinted for |Ax| and the time change is left out.

    Parameters
    ----------
    a : array_like, shape (n,)
        Squares of the semi-axes of (x, A⁻¹x) = 1.
    D : float
        Of the Veselova problem: the unit of its τ.
    """
    source = ellipsoid_problem(a)
    squares = np.array(source.parameters["a"])
    n = len(squares)
    target = Veselova(1.0 / squares, D).reduced()

    def forward(y: Array) -> Array:
        normal = y[:n] / squares
        return np.concatenate([normal / np.sqrt(normal @ normal), y[n:]])

    def backward(z: Array) -> Array:
        x = squares * z[:n]
        return np.concatenate([x / np.sqrt(z[:n] @ x), z[n:]])

    return Correspondence("gauss-map", source, target, forward, backward, veselova_time)
