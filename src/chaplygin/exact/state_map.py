"""States from the angles θ on the torus, without a division where a λ is at its turning point.

γ_i² = Π_k |a_i − λ_k| / Π_{j≠i} |a_i − a_j|. Where a_i is the lower end of the oval of λ_k, the factor
a_i − λ_k is 2d sin²(θ_k/2), and γ_i has the sign of sin(θ_k/2): smooth, and of period 4π; where a_i
is the upper end, cos. Other γ_i keep their sign. With 1/g_k = −4P(λ_k)/Π_{s≠k}(λ_k − λ_s) the momentum
is

    p̃_i = −Σ_k d_k sin θ_k √Q_k/(λ_k Π_{s≠k}(λ_k − λ_s)) · γ_i/(λ_k − a_i),

where half the sine cancels the root of λ_k − a_i.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..manifold import Array
from ..spheroconical import Spheroconical
from .branch_points import Separation
from .torus import Torus

__all__ = ["StateMap"]


@dataclass(frozen=True)
class StateMap:
    """From θ to (γ, p̃), and where a state stands on its torus.

    Parameters
    ----------
    a : array, shape (n,)
    torus : Torus
    low, high : array of int, shape (n,)
        The k whose oval begins, or ends, at a_i; −1 if none.
    signs : array, shape (n,)
        Of γ_i, but for the sines and cosines of half angles.
    """

    a: Array
    torus: Torus
    low: Array
    high: Array
    signs: Array

    @classmethod
    def at(
        cls, a: Array, separation: Separation, torus: Torus, gamma: Array, p_tilde: Array
    ) -> tuple[StateMap, Array]:
        """Return the map of the torus through a state, and its θ, shape (n−1,)."""
        low, high = np.full(len(a), -1), np.full(len(a), -1)
        for k, oval in enumerate(separation.ovals):
            if oval.low_axis is not None:
                low[oval.low_axis] = k
            if oval.high_axis is not None:
                high[oval.high_axis] = k
        bare = cls(a, torus, low, high, np.ones(len(a)))
        theta = bare.theta(gamma, p_tilde)
        # A component that is 0 now has the sign with which it is about to leave.
        plain, momentum = bare(theta)
        by_gamma = np.abs(gamma) >= 1e-8
        signs = np.where(by_gamma, np.sign(gamma * plain), np.sign(p_tilde * momentum))
        return cls(a, torus, low, high, np.where(signs == 0.0, 1.0, signs)), theta

    def theta(self, gamma: Array, p_tilde: Array) -> Array:
        """Return θ_k in [−π, π] of a state, from both sine and cosine, shape (n−1,)."""
        lam, gaps = Spheroconical(self.a).coordinates(gamma)
        sines = np.zeros(len(lam))
        products = p_tilde * gamma
        for i in range(len(self.a)):  # P(λ_k) μ_k = ½ Σ_i p̃_iγ_i Π_{j≠i} (λ_k − a_j)
            sines += 0.5 * products[i] * np.prod(np.delete(gaps, i, axis=1), axis=1)
        sines *= 2.0 * lam / self.torus.root_q(lam)  # d sin θ
        return np.arctan2(sines, self.torus.middle - lam)

    def __call__(self, theta: Array) -> tuple[Array, Array]:
        """Return γ and p̃ at θ, both of shape (..., n)."""
        lam, radius = self.torus.lam(theta), self.torus.radius
        n, half = len(self.a), 0.5 * theta
        sin, cos = np.sin(half), np.cos(half)
        apart = lam[..., :, None] - lam[..., None, :] + np.eye(n - 1)
        weights = -self.torus.root_q(lam) * radius / (lam * np.prod(apart, axis=-1))
        gamma, momentum = np.zeros((*theta.shape[:-1], n)), np.zeros((*theta.shape[:-1], n))
        for i in range(n):
            gaps = lam - self.a[i]  # λ_k − a_i
            k = self.low[i] if self.low[i] >= 0 else self.high[i]
            free = np.delete(np.arange(n - 1), k) if k >= 0 else np.arange(n - 1)
            spread = np.sort(np.abs(np.delete(self.a, i) - self.a[i]))
            value = self.signs[i] * np.sqrt(
                np.prod(np.abs(gaps[..., free]), axis=-1) / np.prod(spread)
            )
            rates = 2.0 * weights * sin * cos  # d sin θ …, to be divided by λ_k − a_i
            if k < 0:
                gamma[..., i] = value
            else:
                root = np.sqrt(2.0 * radius[k])
                wave, other = (sin, cos) if self.low[i] >= 0 else (cos, -sin)
                gamma[..., i] = value * root * wave[..., k]
                # 2 sin cos · wave/(± 2d wave²) = ± other/d, the sign being that of the gap.
                momentum[..., i] = value * root * weights[..., k] * other[..., k] / radius[k]
            for s in free:
                momentum[..., i] += gamma[..., i] * rates[..., s] / gaps[..., s]
        return gamma, momentum
