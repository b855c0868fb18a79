"""The exact flow where all a_i are equal: γ runs along a great circle, eq. (sphere).

U = 1/a is constant, and so are both clocks. With dH/dp̃ = c p̃ on the circle, c = D/a − a for the sphere
and D²a for Veselova's problem, γ turns with the frequency c|p̃| in τ, and in t = (D/√a) τ.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi

from ..manifold import Array

__all__ = ["ExactGreatCircle"]


class ExactGreatCircle:
    """The motion through one state of a sphere or body with equal a_i, at any time.

    Made by ``problem.exact(y0)``. Call it with physical times t, a number or an array; `at_tau` takes
    times τ. Both return flat states of the problem from which it was made.

    Parameters
    ----------
    a : float
        The value of all a_i.
    D : float
    rate : float
        c, see the module's docstring.
    y : array, shape (2n,)
        The state at time 0.
    physical : bool
        Whether states are (γ, p), else (γ, p̃).

    Raises
    ------
    geomint.DomainError
        For a state at rest.
    """

    condition = 1.0

    def __init__(self, a: float, D: float, rate: float, y: Array, physical: bool) -> None:
        n = len(y) // 2
        self._gamma, momentum = y[:n], y[n:]
        self._size = float(np.sqrt(momentum @ momentum))
        if self._size == 0.0:
            raise gi.DomainError("p", momentum, "a momentum that is not zero: the state is at rest")
        self._direction = momentum / self._size
        self._clock = D / np.sqrt(a)  # dt/dτ = p/p̃
        p_tilde = self._size / self._clock if physical else self._size
        self.frequencies = np.array([rate * p_tilde])

    @property
    def mean_frequencies(self) -> Array:
        """The frequency in physical time, shape (1,)."""
        return np.asarray(self.frequencies / self._clock)

    def phase_error(self, tau: Any) -> Array:
        """Return an estimate of the error of the angle at times τ: (1 + |ωτ|) · 2⁻⁵²."""
        times = np.abs(np.asarray(tau, dtype=np.float64))
        return np.asarray((1.0 + np.abs(self.frequencies[0]) * times) * 2.0**-52)

    def time(self, tau: Any) -> Array:
        """Return physical time at times τ."""
        return np.asarray(self._clock * np.asarray(tau, dtype=np.float64))

    def tau(self, t: Any) -> Array:
        """Return τ at physical times t."""
        return np.asarray(np.asarray(t, dtype=np.float64) / self._clock)

    def __call__(self, t: Any) -> Array:
        """Return states at physical times t, of any sign and size."""
        return self.at_tau(self.tau(t))

    def at_tau(self, tau: Any) -> Array:
        """Return states at times τ, of any sign and size."""
        times = np.asarray(tau, dtype=np.float64)
        if not np.isfinite(times).all():
            raise gi.DomainError("tau", tau, "finite times")
        angle = (self.frequencies[0] * times)[..., None]
        cos, sin = np.cos(angle), np.sin(angle)
        gamma = cos * self._gamma + sin * self._direction
        momentum = self._size * (cos * self._direction - sin * self._gamma)
        return np.concatenate([gamma, momentum], axis=-1)
