"""Physical time on the torus: t as a function of τ, and back.

dt/dτ, such as D√U with U = Πλ_k/Πa, is a function on the torus. In the linear angles φ it is a Fourier
series, and

    t(τ) = T τ + Σ_{m≠0} f_m (e^{im·φ(τ)} − e^{im·φ(0)})/(i m·ω),   T = f_0.

Coefficients are by FFT over a grid in φ, which is refined until they have decayed; small divisors m·ω
do no harm, because the quotient is then τ f_m to first order and is evaluated as such. t(τ) is
monotone, and is inverted by Newton's method.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import geomint as gi

from ..manifold import Array
from .torus import Torus

__all__ = ["Clock", "Rate", "clock_of", "multiplier_rate"]

Rate = Callable[[Array], Array]

DECAYED = 4e-16  # of the mean: Fourier coefficients at the edge of the grid
KEPT = 1e-18
GRIDS = {1: 4096, 2: 512, 3: 96}  # most points in every direction, by the dimension of the torus
NEWTON = 50


@dataclass(frozen=True)
class Clock:
    """t as a function of τ along one motion.

    Parameters
    ----------
    mean : float
        T, the mean of dt/dτ over the torus.
    waves : array, shape (M, n−1)
        m, one of each pair ±m.
    coefficients : array of complex, shape (M,)
        2f_m.
    rates : array, shape (M,)
        m·ω.
    start : array, shape (n−1,)
        φ(0).
    edge : float
        Largest coefficient left out, relative to the mean: the error of dt/dτ.
    """

    mean: float
    waves: Array
    coefficients: Array
    rates: Array
    start: Array
    edge: float

    def periodic(self, phi: Array, tau: Array) -> Array:
        """Return t − Tτ at the angles φ that the motion has at τ, shape (...,)."""
        total = np.zeros(np.shape(tau))
        for m, c, rate in zip(self.waves, self.coefficients, self.rates, strict=True):
            first, last = m @ self.start, phi @ m
            # (e^{ib} − e^{ia})/(ir) = e^{i(a+b)/2} 2 sin((b − a)/2)/r, and τ sinc where rτ is small.
            whole = rate * tau
            half = np.where(np.abs(whole) < 1.0, 0.5 * whole, 0.5 * (last - first))
            middle = np.where(np.abs(whole) < 1.0, first + half, 0.5 * (first + last))
            span = np.where(
                np.abs(whole) < 1.0, tau * np.sinc(half / np.pi), 2.0 * np.sin(half) / rate
            )
            total = total + span * (c * np.exp(1j * middle)).real
        return total


def multiplier_rate(a: Array, D: float, torus: Torus) -> Rate:
    """Return dt/dτ = D√U, U = Πλ_k/Πa, as a function of θ."""
    order = np.sort(a)

    def rate(theta: Array) -> Array:
        ratio = np.prod(torus.lam(theta) / order[:-1], axis=-1) / order[-1]
        return np.asarray(D * np.sqrt(ratio))

    return rate


def clock_of(torus: Torus, start: Array, rate: Rate, turns: int = 1, signed: bool = False) -> Clock:
    """Return the clock of a motion whose angles at τ = 0 are `start`.

    Parameters
    ----------
    torus : Torus
    start : array, shape (n−1,)
    rate : callable
        dt/dτ of θ, shape (..., n−1) ↦ (...,); of one sign.
    turns : int
        The period of the rate in every angle over 2π: 2 where it changes with the signs of the γ_i.
    signed : bool
        The rate may change its sign: a quadrature that is no time, measured by its size.

    Raises
    ------
    geomint.DomainError
        For tori of more than three dimensions, and where the series decays too slowly for its grid.
    """
    size = len(torus.middle)
    if size not in GRIDS:
        expected = "n ≤ 4 for physical time (its Fourier series); at_tau has any n"
        raise gi.DomainError("n", size + 1, expected)
    count, most = 32, GRIDS[size]
    while True:
        spectrum = _spectrum(torus, rate, count, turns)
        mean = float(spectrum[(0,) * size].real)
        largest = float(np.max(np.abs(spectrum))) if signed else abs(mean)
        edge = _edge(spectrum) / largest
        if edge < DECAYED or count >= most:
            break
        count *= 2
    if edge > 1e-9:
        expected = (
            f"a motion whose time has a Fourier series that decays; at {count} it is {edge:.3g}"
        )
        raise gi.DomainError("state", start, expected)
    return _clock(spectrum, mean, largest, torus, start, edge, turns)


def _spectrum(torus: Torus, rate: Rate, count: int, turns: int) -> Array:
    """Return the Fourier coefficients of dt/dτ in φ."""
    size = len(torus.middle)
    axis = 2.0 * np.pi * turns * np.arange(count) / count
    phi = np.stack(np.meshgrid(*([axis] * size), indexing="ij"), axis=-1).reshape(-1, size)
    values = rate(torus.solve(phi)).reshape((count,) * size)
    return np.asarray(np.fft.fftn(values) / values.size)


def _edge(spectrum: Array) -> float:
    """Return the largest coefficient in the outer quarter of the frequencies."""
    count, worst = spectrum.shape[0], 0.0
    outer = np.abs(np.fft.fftfreq(count, 1.0 / count)) >= 0.375 * count
    for axis in range(spectrum.ndim):
        worst = max(worst, float(np.max(np.abs(np.compress(outer, spectrum, axis=axis)))))
    return worst


def _clock(
    spectrum: Array,
    mean: float,
    largest: float,
    torus: Torus,
    start: Array,
    edge: float,
    turns: int,
) -> Clock:
    count, size = spectrum.shape[0], spectrum.ndim
    numbers = np.fft.fftfreq(count, 1.0 / count).astype(int)
    grids = np.stack(np.meshgrid(*([numbers] * size), indexing="ij"), axis=-1).reshape(-1, size)
    flat = spectrum.reshape(-1)
    inside = np.all(np.abs(grids) < count // 2, axis=1) & (np.abs(flat) > KEPT * largest)
    first = [next((int(x) for x in m if x), 0) for m in grids[inside]]
    chosen = np.flatnonzero(inside)[np.array(first) > 0]  # one of ±m
    waves = grids[chosen] / turns
    return Clock(mean, waves, 2.0 * flat[chosen], waves @ torus.frequencies, start, edge)
