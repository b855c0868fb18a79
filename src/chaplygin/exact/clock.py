"""Physical time on the torus: t as a function of τ, and back.

dt/dτ, such as D√U with U = Πλ_k/Πα, is a function on the torus. In the linear angles φ it is a Fourier
series, and

    t(τ) = T τ + Σ_{m≠0} f_m (e^{im·φ(τ)} − e^{im·φ(0)})/(i m·ω),   T = f_0.

Small divisors m·ω do no harm, because the quotient is then τ f_m to first order and is evaluated as
such (`clock_functions`).

* D√U is a product of functions of one θ_k each: see `clock_series`.
* Other functions of the state are expanded by the fast Fourier transform over a grid in φ, which is
  refined until the coefficients have decayed; on tori of one or two dimensions.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

import geomint as gi

from ..manifold import Array
from .clock_functions import clock_rows, wave_rows
from .torus import Torus

QUIET = 6e-17  # of the mean: Fourier coefficients that are left out
DECAYED = 4e-16  # of the mean: coefficients at the edge of a grid
TOO_LARGE = 1e-9  # of the mean: an error of dt/dτ that is refused
GRIDS = {0: 1, 1: 4096, 2: 512}  # most points in every direction, by the dimension of the torus
MOST_TERMS = 2e8  # of the series of θ on a whole grid, some seconds
RESONANT = 1e-3  # of the fastest frequency: divisors below it are small

Sampled = Callable[[Array], Array]


@dataclass(frozen=True)
class Clock:
    """The Fourier series of dt/dτ along one motion.

    Parameters
    ----------
    mean : float
        T, the mean of dt/dτ over the torus.
    waves : array of int, shape (M, d)
        m times `period`, one of each pair ±m.
    coefficients : array of complex, shape (M,)
        2f_m.
    period : int
        Of the series in every angle, over 2π.
    edge : float
        Error of dt/dτ, relative to the mean: measured, or the largest coefficient that is left out.
    """

    mean: float
    waves: npt.NDArray[np.int64]
    coefficients: npt.NDArray[np.complex128]
    period: int
    edge: float


def packed_clock(clock: Clock, torus: Torus, start: Array) -> Array:
    """Return the clock's section of the parameters for a motion that starts at given angles."""
    size = len(torus.middle)
    omega = torus.frequencies[:size]
    fastest = float(np.max(np.abs(torus.frequencies), initial=0.0))
    waves = clock.waves / clock.period
    rates, first = waves @ omega, waves @ start[:size]
    resonant = np.abs(rates) < RESONANT * fastest
    safe = np.where(resonant, 1.0, rates)
    amplitudes = np.where(resonant, clock.coefficients, clock.coefficients / (1j * safe))
    offset = -float(np.sum((amplitudes * np.exp(1j * first)).real[~resonant]))
    bounds = np.max(np.abs(clock.waves), axis=0, initial=0) if size else np.zeros(0)
    parts = {"m": clock.waves.T, "rate": rates, "first": first}
    parts |= {"re": amplitudes.real, "im": amplitudes.imag}
    numbers = np.vstack([parts[name] for name in wave_rows(size)._fields]).T
    return gi.packed(
        clock_rows(size),
        mean=clock.mean,
        period=clock.period,
        fastest=fastest,
        regular=np.count_nonzero(~resonant),
        resonant=np.count_nonzero(resonant),
        offset=offset,
        bounds=bounds,
        waves=np.concatenate([numbers[~resonant], numbers[resonant]]),
    ).data


def refuse_slow(edge: float, torus: Torus) -> None:
    """Raise `DomainError` for a series with too large an error."""
    if edge > TOO_LARGE:
        expected = (
            f"a motion whose time has a Fourier series that decays; it is wrong by {edge:.3g}"
        )
        raise gi.DomainError("state", torus.middle, expected)


def sampled_clock(torus: Torus, rate: Sampled, period: int = 1, signed: bool = False) -> Clock:
    """Return the clock of any dt/dτ on a torus of one or two dimensions.

    Parameters
    ----------
    torus : Torus
    rate : callable
        dt/dτ at angles φ, shape (N, d) ↦ (N,).
    period : int
        Its period in every angle over 2π: 2 where it changes with the signs of components.
    signed : bool
        The rate may change its sign: a quadrature that is no time, measured by its size.

    Raises
    ------
    geomint.DomainError
        For tori of more dimensions, and where the series decays too slowly for its grid.
    """
    size = len(torus.middle)
    if size not in GRIDS:
        expected = "a motion with no more than two angles of separation: its series takes a grid"
        raise gi.DomainError("n", size + 1, expected)
    if size == 0:
        mean = float(rate(np.zeros((1, 0)))[0])
        return Clock(mean, np.zeros((0, 0), dtype=np.int64), np.zeros(0, complex), period, 0.0)
    terms = sum(series.shape[1] for series in torus.shifts)
    count, most = 32, min(GRIDS[size], int((MOST_TERMS / (size * terms)) ** (1.0 / size)))
    while True:
        axis = 2.0 * np.pi * period * np.arange(count) / count
        grid = np.meshgrid(*([axis] * size), indexing="ij")
        phi = np.stack(grid, axis=-1).reshape(-1, size)
        spectrum = np.fft.fftn(rate(phi).reshape((count,) * size)) / count**size
        mean = float(spectrum[(0,) * size].real)
        largest = float(np.max(np.abs(spectrum))) if signed else abs(mean)
        edge = _edge(spectrum) / largest
        if edge < DECAYED or 2 * count > most:
            break
        count *= 2
    refuse_slow(edge, torus)
    numbers = np.fft.fftfreq(count, 1.0 / count).astype(np.int64)
    waves = np.stack(np.meshgrid(*([numbers] * size), indexing="ij"), axis=-1).reshape(-1, size)
    flat = spectrum.reshape(-1)
    leading = np.zeros(len(waves), dtype=np.int64)
    for k in range(size - 1, -1, -1):
        leading = np.where(waves[:, k] != 0, waves[:, k], leading)
    inside = np.all(np.abs(waves) < count // 2, axis=1) & (np.abs(flat) > 0.01 * QUIET * largest)
    chosen = inside & (leading > 0)
    return Clock(mean, waves[chosen], 2.0 * flat[chosen], period, edge)


def _edge(spectrum: npt.NDArray[np.complex128]) -> float:
    """Return the largest coefficient in the outer quarter of the frequencies."""
    count, worst = spectrum.shape[0], 0.0
    outer = np.abs(np.fft.fftfreq(count, 1.0 / count)) >= 0.375 * count
    for axis in range(spectrum.ndim):
        worst = max(worst, float(np.max(np.abs(np.compress(outer, spectrum, axis=axis)))))
    return worst
