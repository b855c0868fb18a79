"""The exact flow of the Hamiltonised sphere and of Veselova's problem: states without stepping.

Both are linear in the same angles of the same tori (Theorem CH-VP (iii)), with different frequencies.
A state at any time is: angles φ₀ + ωτ, θ by Newton's method, and (γ, p̃) from θ; it costs the same at
τ = 1 and at 10⁹. Frequencies are known to more than double precision, and ωτ is reduced in two parts.
What is left of the error at large times is the rounding of the state from which the motion starts: a
relative error ε of it turns into a phase error of about condition · ω τ ε.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

import geomint as gi

from ..manifold import Array
from ..spheroconical import Spheroconical
from ..states import multiplier
from .branch_points import mp, separation_of
from .clock import Clock, clock_of, multiplier_rate
from .state_map import StateMap
from .torus import torus_of

__all__ = ["ExactFlow", "sphere_weights", "veselova_weights"]

NEWTON = 60


def sphere_weights(a: Array, D: float) -> list[Any]:
    """Return ∂H/∂r_j of the sphere: H = (−1)ⁿ D r_0/(2Πa) − r_(n−2)/2."""
    n = len(a)
    weights = [mp.mpf(0)] * (n - 1)
    weights[0] += (-1) ** n * mp.mpf(D) / (2 * mp.fprod(mp.mpf(float(x)) for x in a))
    weights[-1] -= mp.mpf(1) / 2
    return weights


def veselova_weights(a: Array, D: float) -> list[Any]:
    """Return ∂𝓗/∂r_j of Veselova's problem: 𝓗 = D² r_(n−2)/2."""
    weights = [mp.mpf(0)] * (len(a) - 1)
    weights[-1] += mp.mpf(D) ** 2 / 2
    return weights


class ExactFlow:
    """The motion through one state, at any time.

    Made by ``problem.exact(y0)`` of a Hamiltonised or reduced problem with different a_i. Call it with
    physical times t, a number or an array; `at_tau` takes times τ. Both return states of the problem
    from which it was made, flat, shape (rows,) or (times, rows).

    Parameters
    ----------
    a, D
        Of the problem.
    weights : sequence
        ∂H/∂r_j.
    y : array, shape (2n,)
        The state at time 0.
    physical : bool
        Whether states are (γ, p), else (γ, p̃).

    Raises
    ------
    geomint.DomainError
        For equal a_i, a state at rest, and motions next to a separatrix: with the condition number.
    """

    def __init__(self, a: Array, D: float, weights: Any, y: Array, physical: bool) -> None:
        self.a, self.D, self.physical = a, D, physical
        Spheroconical(a)  # refuses equal a_i
        gamma, p_tilde = self._split(y)
        moving = (gamma != 0.0) | (p_tilde != 0.0)  # the others are 0 for ever
        if np.any(p_tilde) and not moving.all():
            expected = "a motion that leaves every coordinate plane; drop the axes in which it is 0"
            raise gi.DomainError("gamma", gamma, expected)
        self.separation = separation_of(a, gamma, p_tilde)
        self.torus = torus_of(self.separation, weights)
        self._map, theta = StateMap.at(a, self.separation, self.torus, gamma, p_tilde)
        self.start = self.torus.angles(theta)
        self.rate, self._turns = multiplier_rate(a, D, self.torus), 1

    @property
    def frequencies(self) -> Array:
        """ω = dφ/dτ, shape (n−1,)."""
        return self.torus.frequencies

    @property
    def condition(self) -> float:
        """About what relative errors of the state are magnified by in frequencies."""
        return self.separation.condition

    def phase_error(self, tau: Any) -> Array:
        """Return an estimate of the error of the angles at times τ: (1 + |ωτ|) · condition · 2⁻⁵².

        That is what the rounding of the state at time 0 makes of the angles, with the largest
        frequency; the computation itself adds some units of condition · 2⁻⁵² at any τ.
        """
        times = np.abs(np.asarray(tau, dtype=np.float64))
        fastest = float(np.max(np.abs(self.frequencies)))
        return np.asarray((1.0 + fastest * times) * self.condition * 2.0**-52)

    @functools.cached_property
    def clock(self) -> Clock:
        """Physical time as a function of τ; n ≤ 4."""
        return clock_of(self.torus, self.start, self.rate, self._turns)

    @property
    def mean_frequencies(self) -> Array:
        """Mean frequencies in physical time, ω/T, shape (n−1,)."""
        return np.asarray(self.frequencies / self.clock.mean)

    def angles(self, y: Any) -> Array:
        """Return φ of a state on the torus, modulo 4π, shape (n−1,)."""
        return self.torus.angles(self._map.theta(*self._split(np.asarray(y, dtype=np.float64))))

    def _split(self, y: Array) -> tuple[Array, Array]:
        """Return γ and p̃."""
        n = len(self.a)
        scale = multiplier(self.a, self.D, y[:n]) if self.physical else 1.0
        return y[:n], np.asarray(y[n:] / scale)

    def at_tau(self, tau: Any) -> Array:
        """Return states at times τ, of any sign and size."""
        times = np.asarray(tau, dtype=np.float64)
        if not np.isfinite(times).all():
            raise gi.DomainError("tau", tau, "finite times")
        return self.states(self.torus.solve(self.phases(times)))

    def __call__(self, t: Any) -> Array:
        """Return states at physical times t, of any sign and size."""
        times = np.asarray(t, dtype=np.float64)
        if not np.isfinite(times).all():
            raise gi.DomainError("t", t, "finite times")
        return self.at_tau(self.tau(times))

    def time(self, tau: Any) -> Array:
        """Return physical time at times τ."""
        times = np.asarray(tau, dtype=np.float64)
        return np.asarray(self.clock.mean * times + self.clock.periodic(self.phases(times), times))

    def tau(self, t: Any) -> Array:
        """Return τ at physical times t."""
        times = np.asarray(t, dtype=np.float64)
        tau = times / self.clock.mean
        for _ in range(NEWTON):
            phi = self.phases(tau)
            rate = self.rate(self.torus.solve(phi))
            defect = self.clock.mean * tau + self.clock.periodic(phi, tau) - times
            tau = tau - defect / rate
            if np.all(np.abs(defect) <= 4e-16 * (np.abs(times) + abs(self.clock.mean))):
                return np.asarray(tau)
        return np.asarray(tau)

    def phases(self, tau: Array) -> Array:
        """Return φ₀ + ωτ modulo 4π, shape (..., n−1): reduced as turns, in two parts."""
        turns = self.torus.turns
        product, error = _two_product(tau[..., None], turns)
        rest = (product - np.rint(product)) + (error + tau[..., None] * self.torus.turns_low)
        return np.asarray(self.start + 4.0 * np.pi * (rest - np.rint(rest)))

    def states(self, theta: Array) -> Array:
        """Return states at angles θ of the torus, shape (..., n−1)."""
        gamma, p_tilde = self._map(theta)
        if self.physical:
            u = np.sum(gamma * gamma / self.a, axis=-1, keepdims=True)
            p_tilde = self.D * np.sqrt(u) * p_tilde
        return np.concatenate([gamma, p_tilde], axis=-1)


def _two_product(x: Array, y: Array) -> tuple[Array, Array]:
    """Return the rounded product, and what rounding took from it (Dekker)."""
    product = x * y
    factor = 134217729.0  # 2²⁷ + 1
    xh = factor * x - (factor * x - x)
    yh = factor * y - (factor * y - y)
    xl, yl = x - xh, y - yh
    return product, ((xh * yh - product) + xh * yl + xl * yh) + xl * yl
