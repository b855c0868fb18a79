"""Frequencies of a quasi-periodic signal, by Laskar's numerical analysis of fundamental frequencies.

A signal z(t) = Σ c_k e^{iν_k t} sampled at equal steps over a time T is multiplied by Hann's window of
order p, and ν_1 is where |∫ z e^{−iνt} w dt| is largest: from the fast Fourier transform, then a root
of the derivative. All terms found so far are fitted together and taken away, and the next one is
looked for. The error of a frequency is of the order T^(−2p−2) where the others are further away than
some 1/T: far below the 1/T of a Fourier transform.

Source: J. Laskar, *Frequency analysis for multi-dimensional systems* (1993), Physica D 67.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arguments import as_array, positive, whole
from ..errors import DomainError
from .birkhoff import times_power_of_two

Array = npt.NDArray[Any]
FEWEST = 16  # samples
LARGEST_ORDER = 100  # of a window: beyond, nothing but its middle is left


@dataclass(frozen=True)
class Term:
    """One term c e^{iνt} of a signal.

    Parameters
    ----------
    frequency : float
        ν, in radians per unit of time.
    amplitude : complex
        c, at the time 0 of the samples' first.
    """

    frequency: float
    amplitude: complex


def frequencies(signal: Any, step: float, terms: int = 1, order: int = 2) -> list[Term]:
    """Return the leading terms of a signal, the largest first.

    Parameters
    ----------
    signal : array_like, shape (N,)
        Real or complex samples at equal steps; of a real signal terms come in pairs ±ν.
    step : float
        Time between samples.
    terms : int
        How many.
    order : int
        Of the window, p ≥ 0: 1 is Hann's own. Higher orders are better for long signals and worse
        for neighbouring frequencies.

    Raises
    ------
    geomint.DomainError
        For fewer than 16 samples, numbers that are not finite, and other nonsense.
    """
    expected = f"at least {FEWEST} finite numbers in a row"
    z = as_array("signal", signal, expected, np.complex128)
    if z.ndim != 1 or len(z) < FEWEST or not np.isfinite(z).all():
        raise DomainError("signal", signal, expected)
    step, order = positive("step", step), whole("order", order, 0, LARGEST_ORDER)
    if not math.isfinite(math.pi / step):
        raise DomainError("step", step, "a time whose inverse is a number")
    terms = whole("terms", terms, 1, len(z))
    power = int(np.frexp(np.maximum(np.abs(z.real), np.abs(z.imag)).max())[1])
    z = times_power_of_two(z, -power)
    size = float(np.max(np.abs(z))) or 1.0
    z = z / size
    times = np.arange(len(z)) - 0.5 * (len(z) - 1)  # symmetric, in steps
    window = _window(len(z), order)
    waves: list[Array] = []
    found: list[float] = []
    rest = z
    for _ in range(terms):
        nu = _largest(rest, times, window)
        found.append(nu)
        waves.append(np.exp(1j * nu * times))
        basis = np.array(waves).T
        weights = np.sqrt(window)[:, None]
        amplitudes, *_ = np.linalg.lstsq(weights * basis, weights[:, 0] * z, rcond=None)
        rest = z - basis @ amplitudes
    turned = size * amplitudes * np.exp(1j * np.array(found) * times[0])
    told = times_power_of_two(turned, power)
    return [Term(nu / step, complex(c)) for nu, c in zip(found, told, strict=True)]


def _window(count: int, order: int) -> Array:
    """Return Hann's window of that order: (1 + cos πx)^p, of mean 1, x from −1 to 1."""
    x = np.linspace(-1.0, 1.0, count)
    values = (1.0 + np.cos(np.pi * x)) ** order
    return values / np.mean(values)


def _largest(z: Array, times: Array, window: Array) -> float:
    """Return the ν, in radians a step, where the windowed transform is largest."""
    padded = 4 * len(z)
    power = np.abs(np.fft.fft(z * window, padded))
    top, width = int(np.argmax(power)), 2.0 * np.pi / padded

    def slope(nu: float) -> float:
        """Half of the derivative of |F|², F the transform: a root of it is known to rounding."""
        wave = z * window * np.exp(-1j * nu * times)
        return float((np.conj(np.sum(wave)) * np.sum(-1j * times * wave)).real)

    low, high = (top - 1) * width, (top + 1) * width
    if not slope(low) > 0.0 > slope(high):  # a plateau: nothing is there but round-off
        return float((top * width + np.pi) % (2.0 * np.pi) - np.pi)
    from scipy.optimize import brentq  # half a second, which scans for other readings need not wait

    nu = float(brentq(slope, low, high, xtol=1e-18, rtol=8.9e-16))  # type: ignore[no-untyped-call]
    return (nu + np.pi) % (2.0 * np.pi) - np.pi
