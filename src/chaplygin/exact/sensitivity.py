"""How rounding errors of a state grow with time: derivatives of the frequencies.

Let C be the constants of a motion: R on the middles of the ovals, and the ℓ_g. The means over one turn
of θ_k, of the differentials of `torus`, are ∂J_k/∂C_i, J the actions. With the second derivatives of
μ_k,

    S_k,ij = mean of ∂²μ_k/∂C_i∂C_j dλ_k/dθ_k,

where the singular ends of the oval are passed at a distance, in the complex plane of θ_k, the rule
Σ_k ω_k ∂J_k/∂c_j = ∂H/∂c_j = const gives ∂ω/∂C, and with the gradients of C it gives those of the
frequencies. That is no bound but the derivative: it says that nearly equal a_i and narrow ovals do no
harm, and how much separatrices do.

The `Estimate` of a flow's error is made of them.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import sys
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..manifold import Array
from .branch_points import Separation
from .separated_energy import SeparatedEnergy
from .symmetry import ReducedAxes
from .torus import Torus, distances, products_without_one

WIDEST = 1.5  # of strips: half of it is far enough from all that is singular
FINENESS = 12.0  # points over 1/distance: e^−12 is far more exact than an estimate must be


def frequency_gradients(
    axes: ReducedAxes,
    separation: Separation,
    torus: Torus,
    energy: SeparatedEnergy,
    gamma: Array,
    p_tilde: Array,
) -> Array:
    """Return the lengths of the gradients of all frequencies by γ and by p̃/|p̃|, shape (d + pairs,)."""
    size, paired = len(torus.middle), np.flatnonzero(axes.paired)
    # In units of time in which nothing overflows.
    unit = float(np.max(np.abs(torus.frequencies))) or 1.0
    turning = np.array([energy.turning(separation.alpha[g]) / unit for g in paired])
    gradients = _constants(axes, torus, gamma, p_tilde)
    omega, means = torus.frequencies[:size] / unit, torus.means
    second = _second_derivatives(separation, torus) if size else np.zeros((0, 1, 1))
    changed = np.tensordot(omega, second, 1) @ gradients
    separated = -np.linalg.solve(means[:, :size].T, changed[:size])
    pairs = turning[:, None] * gradients[size:] - changed[size:] - means[:, size:].T @ separated
    return unit * np.linalg.norm(np.concatenate([separated, pairs]), axis=1)


def _second_derivatives(separation: Separation, torus: Torus) -> Array:
    """Return S_k: −h_i h_j λP/(8 d² sin²θ Q^(3/2)), and −½ αP/((λ − α)²√Q) for a pair's ∂²/∂ℓ².

    h_i is Lagrange's polynomial, or 2αℓP/(λ − α)². Shape (d, d + pairs, d + pairs).
    """
    radius, pairs = torus.radius[:, None], np.flatnonzero(separation.paired)
    size = len(radius)
    shift = 0.5 * np.minimum(torus.strips, WIDEST)
    count = int(np.ceil(FINENESS / np.min(shift))) + 4
    sine = np.sin(np.pi * np.arange(count) / count + 0.5j * shift[:, None])[:, None] ** 2
    branch = distances(torus.branch_gaps[..., None], radius[..., None], sine)
    axis = distances(torus.axis_gaps[..., None], radius[..., None], sine)
    lam, product = branch[:, 0], np.prod(axis, axis=1)
    roots = np.sqrt(np.where(torus.branch_gaps[..., None] < 0.0, -branch, branch))
    root_q = np.sqrt(torus.lead) * np.prod(roots, axis=1)
    h = np.ones((size, size + len(pairs), count), dtype=np.complex128)
    sides = 2.0 * np.tri(size, k=-1) - 1.0  # of the oval in the row, seen from that in the column
    from_middle = distances(torus.oval_gaps[..., None], radius[..., None], sine)
    from_middle += (sides * radius.T)[..., None]
    between = torus.oval_gaps + sides * (radius + radius.T)
    for s in range(size):
        others = np.flatnonzero(np.arange(size) != s)
        h[:, others] *= from_middle[:, s, None] / between[others, s, None]
    alpha = separation.alpha[pairs, None]
    own = alpha * product[:, None] / axis[:, pairs] ** 2
    h[:, size:] = 2.0 * separation.ell[pairs, :1] * own
    ends = 4.0 * radius * radius * sine[:, 0] * (1.0 - sine[:, 0])
    # In an order in which neither gaps of 1e-16 between ten a_i nor their quotients are too small.
    weight = -lam * (product / root_q) / root_q / (8.0 * ends * count) / root_q
    result = ((h * weight[:, None]) @ h.transpose(0, 2, 1)).real
    diagonal = np.arange(size, size + len(pairs))
    result[:, diagonal, diagonal] -= 0.5 * np.mean((own / root_q[:, None]).real, axis=2)
    return result


def _constants(axes: ReducedAxes, torus: Torus, gamma: Array, p_tilde: Array) -> Array:
    """Return the gradients of R on the middles, then of the ℓ, by γ and p̃/|p̃|, shape (…, 2n).

    R = −(p̃, p̃) Σ A_g P_g + λ Σ_{g<h} (A_gC_h + A_hC_g − 2B_gB_h) P_gh + Σ ℓ_g² P_g,
    P_g = P/(λ − α_g), and A, B, C the products (γ_g, γ_g), (γ_g, p̃_g), (p̃_g, p̃_g).
    """
    members = axes.members.astype(np.float64)
    momentum = float(np.linalg.norm(p_tilde))
    p = p_tilde / momentum
    A, B, C = members @ (gamma * gamma), members @ (gamma * p), members @ (p * p)
    lam, away = torus.middle[:, None], distances(torus.axis_gaps, torus.radius[:, None], 0.5)
    single, double = products_without_one(away), _products_without_two(away)
    pairs = np.where(axes.paired, single, 0.0)
    by_a = -single + lam * (double @ C) + pairs * C
    by_b = -2.0 * lam * (double @ B) - 2.0 * pairs * B
    by_c = -(single @ A)[:, None] + lam * (double @ A) + pairs * A
    rows = [momentum**2 * _by_state(by_a @ members, by_b @ members, by_c @ members, gamma, p)]
    for g in np.flatnonzero(axes.paired):
        inside = members[g]
        ell = max(float(np.sqrt(max(A[g] * C[g] - B[g] * B[g], 0.0))), 1e-300)
        row = _by_state(C[g] * inside, -2.0 * B[g] * inside, A[g] * inside, gamma, p)
        rows.append(momentum * row[None] / (2.0 * ell))
    return np.concatenate(rows)


def _products_without_two(factors: Array) -> Array:
    """Return the products of all but two different ones, shape (d, q) ↦ (d, q, q), 0 for one twice."""
    one = np.eye(factors.shape[1], dtype=bool)
    left_out = one[:, None] | one
    return np.prod(np.where(left_out, 1.0, factors[:, None, None]), axis=-1) * ~one


def _by_state(by_a: Array, by_b: Array, by_c: Array, gamma: Array, p: Array) -> Array:
    """Return a gradient by γ and p from that by the products."""
    return np.concatenate([2.0 * by_a * gamma + by_b * p, 2.0 * by_c * p + by_b * gamma], axis=-1)


SAFETY = 8.0  # of the estimated error, over what roundings do on the average
MARGIN = 2.0  # over an error that is seen at one time


@dataclass(frozen=True)
class Estimate:
    """The error of the angles at time τ: 2⁻⁵² times 8 (1 + ln o) m w (o + g|τ|).

    Parameters
    ----------
    offset : float
        o = 1/η, at least 1, with the half width η of the narrowest strip of `Torus`.
    growth : float
        g, the length of the gradient of the most sensitive frequency by γ and p̃/|p̃|.
    fastest : float
        The largest frequency.
    magnified : float
        m, how many times larger roundings of the given state are in (γ, p̃).
    widened : float
        w, at least 1: by how much the estimate at τ = 0 was seen to be too small.
    """

    offset: float
    growth: float
    fastest: float
    magnified: float = 1.0
    widened: float = 1.0

    @property
    def condition(self) -> float:
        """About what relative errors of the state are magnified by in frequencies."""
        growth = self.growth / self.fastest if self.fastest > 0.0 else 1.0
        return self.magnified * float(np.maximum(self.offset, growth))  # NaN if one of them is

    def seen(self, missed: float) -> Estimate:
        """Return the estimate that knows by how much the torus misses the state at τ = 0.

        So digits that are lost in a way that the derivatives know nothing of are part of it.
        """
        return dataclasses.replace(self, widened=max(1.0, MARGIN * missed / float(self.phase(0.0))))

    def phase(self, tau: Any) -> Array:
        """Return the estimated error of the angles at times τ, in radians."""
        times = np.abs(np.asarray(tau, dtype=np.float64))
        return self._rounding * (self.offset + self.growth * times)

    @functools.cached_property
    def longest(self) -> float:
        """The largest |τ| at which `phase` is no more than a radian; finite."""
        if not self.growth > 0.0:
            return sys.float_info.max
        left = max(0.0, 1.0 / self._rounding - self.offset)
        return min(left / self.growth, sys.float_info.max)

    @property
    def _rounding(self) -> float:
        return SAFETY * (1.0 + math.log(self.offset)) * self.magnified * self.widened * 2.0**-52
