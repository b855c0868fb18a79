"""The exact motion of a ball whose inertia operator is a multiple of 1: a steady turn.

For I = s·1, and so for every ball at n = 2, ω is constant in the body and in space: in space k and γ
are, and with them ω, the solution of a linear equation whose coefficients they are. So

    γ(t) = e^(−ωt) γ_0,   k(t) = e^(−ωt) k_0 e^(ωt),   g(t) = g_0 e^(ωt),

for any momentum. With k = k_∥ + k_⊥, k_∥ in γ∧R^n, ω = k_∥/(s + D) + k_⊥/s.
"""

from typing import Any, NamedTuple

import numpy as np

import geomint as gi

from ..manifold import Array, skew_matrix, triangle_rows
from .numbers import MadeOfNumbers
from .quadrature import finite_times

ROUNDINGS = 4.0 * 2.0**-52


class Mean(NamedTuple):
    """The clock of a motion whose time is t itself."""

    mean: float = 1.0


class SteadyTurn(MadeOfNumbers):
    """The motion through one state (k, γ) or (k, γ, g), at any time.

    Made by ``problem.exact(y0)`` of a ball whose operator is a multiple of 1. Call it with times t, a
    number or an array; τ is t.

    Parameters
    ----------
    n : int
    s, D : float
        I = s·1, and mρ².
    y : array
        The state at time 0.

    Raises
    ------
    geomint.DomainError
        For a state at rest.
    """

    clock = Mean()

    def __init__(self, n: int, s: float, D: float, y: Array) -> None:
        self.a, self._y0 = np.full(n, s), y
        size = triangle_rows(n)
        k, gamma = skew_matrix(y[:size], n), y[size : size + n]
        v = k @ gamma
        along = np.outer(v, gamma) - np.outer(gamma, v)
        self.omega = along / (s + D) + (k - along) / s
        self._speeds, self._basis = np.linalg.eigh(1j * self.omega)
        fastest = float(np.max(np.abs(self._speeds)))
        if not (fastest > 0.0 and np.isfinite(self._speeds).all()):
            raise gi.DomainError("state", y, "a motion whose frequencies are finite and not all 0")
        self._fastest = fastest
        self.condition = float(np.linalg.norm(k)) / (s * float(np.linalg.norm(self.omega)))

    @property
    def frequencies(self) -> Array:
        """The angular speeds of the planes in which it turns, falling."""
        return self._speeds[::-1][: len(self.a) // 2]

    mean_frequencies = frequencies

    @property
    def ovals(self) -> Array:
        """There are no separated variables: none, shape (0, 2)."""
        return np.zeros((0, 2))

    @property
    def longest(self) -> float:
        """The largest |t| for which the phase means something."""
        return 1.0 / (ROUNDINGS * self.condition * self._fastest)

    def phase_error(self, tau: Any) -> Array:
        """Return an estimate of the error of the angles at times, in radians."""
        turned = self._fastest * np.abs(np.asarray(tau, dtype=np.float64))
        return ROUNDINGS * (1.0 + self.condition * turned)

    def time_error(self, tau: Any) -> Array:
        """Return 0: time needs no clock."""
        return np.zeros(np.shape(tau))

    def time(self, tau: Any) -> Array:
        """Return t at times τ: these."""
        return finite_times("t", tau, self.longest)

    tau = time

    def __call__(self, t: Any) -> Array:
        """Return states at times t, |t| up to `longest`, shape (..., rows)."""
        times = self.time(t)
        n = len(self.a)
        size = triangle_rows(n)
        phases = np.exp(1j * times[..., None] * self._speeds)
        turn = ((self._basis * phases[..., None, :]) @ self._basis.conj().T).real
        k = turn @ skew_matrix(self._y0[:size], n) @ np.swapaxes(turn, -1, -2)
        vectors = self._y0[size:].reshape(-1, n)
        turned = np.einsum("...ij,vj->...vi", turn, vectors).reshape(*times.shape, -1)
        i, j = np.triu_indices(n, 1)
        return np.concatenate([k[..., i, j], turned], axis=-1)

    at_tau = __call__
