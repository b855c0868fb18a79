"""Where a state stands on its torus: θ and ψ, and the signs of components, from γ and p̃."""

import math

import numpy as np

from ..manifold import Array
from ..spheroconical import ascending_gaps
from .symmetry import TINY, ReducedAxes
from .torus import Torus, distances, products_without_one


def theta_of(axes: ReducedAxes, torus: Torus, position: Array, momentum: Array) -> Array:
    """Return θ_k in [−π, π] from components, both sine and cosine, shape (d,)."""
    if len(position) == 1:
        return np.zeros(0)
    squares = position * position
    gaps = ascending_gaps(axes.alpha, squares / np.sum(squares))
    # P(λ_k) μ_k = ½ Σ_g p̃_gγ_g Π_{h≠g} (λ_k − α_h)
    sines = 0.5 * products_without_one(gaps) @ (momentum * position)
    # m − λ from the α nearest to m, of which both are known to rounding.
    radius = torus.radius
    middle = distances(torus.axis_gaps, radius[:, None], 0.5)
    nearest = np.argmin(np.abs(middle), axis=1)[:, None]
    cosines = np.take_along_axis(middle - gaps, nearest, axis=1)[:, 0]
    sine = np.clip(0.5 * (1.0 - cosines / radius), 0.0, 1.0)[:, None]  # sin²(θ/2)
    away = distances(torus.branch_gaps, radius[:, None], sine)
    root_q = np.sqrt(torus.lead * np.prod(np.abs(away), axis=1))
    return np.arctan2(2.0 * away[:, 0] / root_q * sines, cosines)  # d sin θ, d cos θ


def linear_angles(torus: Torus, theta: Array, psi: Array) -> Array:
    """Return (φ, Φ) at (θ, ψ), shape (d + pairs,).

    With the roundings of `inversion`: next to a separatrix the way back to θ makes them larger.
    """
    plain = np.concatenate([theta, psi])
    waves = zip(torus.shifts, theta.tolist(), strict=True)
    terms = [shift * _sines(x, shift.shape[1]) for shift, x in waves]
    sums = np.cumsum(np.concatenate([0.0 * plain[:, None], *terms], axis=1), axis=1)
    return plain + sums[:, -1]


def _sines(x: float, count: int) -> list[float]:
    """Return sin mx, m = 1 … count."""
    cos1, sin1 = math.cos(x), math.sin(x)
    cos, sin, found = cos1, sin1, []
    for _ in range(count):
        found.append(sin)
        cos, sin = cos * cos1 - sin * sin1, sin * cos1 + cos * sin1
    return found


def component_signs(axes: ReducedAxes, position: Array, momentum: Array, bare: Array) -> Array:
    """Return the signs of the components, but for the sines and cosines of half angles, (q,).

    Parameters
    ----------
    axes : ReducedAxes
    position, momentum : array, shape (q,)
    bare : array, shape (2n,)
        The state where these signs are 1.
    """
    x, rate, _, _ = axes.components(*np.split(bare, 2))
    # Where one of both is 0 the other decides; both are of the sizes of γ and p̃.
    signs = np.sign(position * x + momentum * rate / max(float(momentum @ momentum), TINY))
    return np.where(axes.paired | (signs == 0.0), 1.0, signs)
