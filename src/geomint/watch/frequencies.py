"""Frequencies of a quasi-periodic signal, by Laskar's numerical analysis of fundamental frequencies.

A signal z(t) = Σ c_k e^{iν_k t} sampled at equal steps over a time T is multiplied by Hann's window of
order p, and ν_1 is where |∫ z e^{−iνt} w dt| is largest: from the fast Fourier transform, then a root
of the derivative. All terms found so far are fitted together and taken away, and the next one is
looked for. The error of a frequency is of the order T^(−2p−2) where the others are further away than
some 1/T: far below the 1/T of a Fourier transform. It ends where nothing but roundings is left, or what
a term that is there already has left beside itself: closer than π/T two terms are one.

Source: J. Laskar, *Frequency analysis for multi-dimensional systems* (1993), Physica D 67.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arguments import as_array, positive, whole
from ..errors import DomainError
from .birkhoff import in_a_turn, times_power_of_two

Array = npt.NDArray[Any]
FEWEST = 16  # samples
LARGEST_ORDER = 100  # of a window: beyond, nothing but its middle is left
ROUNDING = 8.0 * 2.0**-52  # of a sample; as much of its phase νt


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
        How many, at most: a constant has one, and zeros have none.
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
    times = np.arange(len(z)) - 0.5 * (len(z) - 1)  # symmetric, in steps
    window = _window(len(z), order)
    found: list[float] = []
    amplitudes, rest = np.zeros(0, dtype=np.complex128), z
    near = np.pi / len(z)
    while len(found) < terms:
        phases = len(z) * float(np.abs(amplitudes * found).sum())
        nu = _largest(rest, times, window, ROUNDING * (1.0 + phases))
        if nu is None or any(abs(in_a_turn(nu - other)) < near for other in found):
            break
        found.append(nu)
        basis = np.exp(1j * np.outer(times, found))
        weights = np.sqrt(window)[:, None]
        amplitudes, *_ = np.linalg.lstsq(weights * basis, weights[:, 0] * z, rcond=None)
        rest = z - basis @ amplitudes
    turned = amplitudes * np.exp(1j * np.array(found) * times[0])
    told = times_power_of_two(turned, power)
    largest_first = np.argsort(-np.abs(amplitudes), kind="stable")
    return [Term(found[k] / step, complex(told[k])) for k in largest_first]


def _window(count: int, order: int) -> Array:
    """Return Hann's window of that order: (1 + cos πx)^p, of mean 1, x from −1 to 1."""
    x = np.linspace(-1.0, 1.0, count)
    values = (1.0 + np.cos(np.pi * x)) ** order
    return values / np.mean(values)


def _largest(z: Array, times: Array, window: Array, rounding: float) -> float | None:
    """Return the ν, in radians a step, where the windowed transform is largest; None: of roundings."""
    padded = 4 * len(z)
    power = np.abs(np.fft.fft(z * window, padded))
    top, width = int(np.argmax(power)), 2.0 * np.pi / padded
    if not power[top] > rounding * np.linalg.norm(window):
        return None

    def slope(nu: float) -> float:
        """Half of the derivative of |F|², F the transform: a root of it is known to rounding."""
        wave = z * window * np.exp(-1j * nu * times)
        return float((np.conj(np.sum(wave)) * np.sum(-1j * times * wave)).real)

    low, high = (top - 1) * width, (top + 1) * width
    if not slope(low) > 0.0 > slope(high):  # a plateau
        return float(in_a_turn(top * width))
    from scipy.optimize import brentq  # half a second, which scans for other readings need not wait

    nu = float(brentq(slope, low, high, xtol=1e-18, rtol=8.9e-16))  # type: ignore[no-untyped-call]
    return float(in_a_turn(nu))
