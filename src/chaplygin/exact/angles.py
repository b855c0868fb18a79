"""Where a state stands on its torus: θ and ψ, and the signs of components, from γ and p̃."""

from __future__ import annotations

import numpy as np

from ..manifold import Array
from ..spheroconical import Spheroconical
from .branch_points import Separation
from .functions import at_angles, shifts, state_rows, state_work
from .packing import evaluated, packed_torus
from .symmetry import TINY, ReducedAxes
from .torus import Torus, distances

__all__ = ["component_signs", "linear_angles", "theta_of"]


def theta_of(axes: ReducedAxes, torus: Torus, position: Array, momentum: Array) -> Array:
    """Return θ_k in [−π, π] from components, both sine and cosine, shape (d,)."""
    if len(position) == 1:
        return np.zeros(0)
    _, gaps = Spheroconical(axes.alpha).coordinates(position)
    sines = np.zeros(len(gaps))
    for g in range(len(position)):  # P(λ_k) μ_k = ½ Σ_g p̃_gγ_g Π_{h≠g} (λ_k − α_h)
        others = np.prod(np.delete(gaps, g, axis=1), axis=1)
        sines += 0.5 * momentum[g] * position[g] * others
    # m − λ from the α nearest to m, of which both are known to rounding.
    radius = torus.radius
    middle = distances(torus.axis_gaps, radius[:, None], 0.5)
    nearest = np.argmin(np.abs(middle), axis=1)[:, None]
    cosines = np.take_along_axis(middle - gaps, nearest, axis=1)[:, 0]
    sine = np.clip(0.5 * (1.0 - cosines / radius), 0.0, 1.0)[:, None]  # sin²(θ/2)
    away = distances(torus.branch_gaps, radius[:, None], sine)
    root_q = np.sqrt(torus.lead * np.prod(np.abs(away), axis=1))
    return np.asarray(np.arctan2(2.0 * away[:, 0] / root_q * sines, cosines))  # d sin θ, d cos θ


def component_signs(
    axes: ReducedAxes, torus: Torus, separation: Separation, gamma: Array, p_tilde: Array
) -> Array:
    """Return the signs of the components, but for the sines and cosines of half angles, (q,)."""
    position, momentum, psi, _ = axes.components(gamma, p_tilde)
    theta = theta_of(axes, torus, position, momentum)
    plain = np.ones(len(axes.alpha))
    params = packed_torus(axes, separation, torus, plain, np.zeros(len(torus.turns)), 1.0, False)
    phi = linear_angles(params, theta, psi)
    n = len(gamma)
    work = state_work(len(theta), len(phi))
    state = evaluated(at_angles, params, phi, state_rows(n), work)
    bare, rate, _, _ = axes.components(state[:n], state[n : 2 * n])
    # Where one of both is 0 the other decides; both are of the sizes of γ and p̃.
    signs = np.sign(position * bare + momentum * rate / max(float(momentum @ momentum), TINY))
    return np.where(axes.paired | (signs == 0.0), 1.0, signs)


def linear_angles(params: Array, theta: Array, psi: Array) -> Array:
    """Return (φ, Φ) at (θ, ψ), shape (d + pairs,)."""
    angles, ovals = len(theta) + len(psi), len(theta)
    shift = evaluated(shifts, params, theta, angles, ovals * ovals)
    return np.asarray(np.concatenate([theta, psi]) + shift)
