"""Quadratures along a motion, and what times may be."""

from dataclasses import dataclass
from typing import Any

import numpy as np

import geomint as gi
from geomint.arguments import as_array

from ..manifold import Array
from .clock import Clock
from .clock_functions import time_at
from .packing import evaluated

LEFT = 1e-9  # of an iteration's last step: more is a failure


@dataclass(frozen=True)
class Quadrature:
    """A quadrature along a motion, 0 at τ = 0 up to rounding; called with times τ.

    Parameters
    ----------
    clock : Clock
        The Fourier series of its rate.
    params, work
        For the compiled function.
    longest : float
        The largest |τ| for which the phase means something.
    """

    clock: Clock
    params: Array
    work: int
    longest: float

    @property
    def mean(self) -> float:
        """The mean rate in τ."""
        return self.clock.mean

    def __call__(self, tau: Any) -> Array:
        """Return the integral from 0 to τ, for every τ."""
        points = finite_times("tau", tau, self.longest)[..., None]
        values = evaluated(time_at, self.params, points, 1, self.work)[..., 0]
        if not np.isfinite(values).all():
            raise gi.DomainError("tau", tau, "times at which the integral is a finite number")
        return values


def finite_times(name: str, values: Any, longest: float) -> Array:
    """Return times as an array, or raise `DomainError` for what is no finite number, or too large."""
    times = as_array(name, values, "real numbers")
    if (np.abs(times) <= longest).all():
        return times
    if not np.isfinite(times).all():
        raise gi.DomainError(name, values, "finite times")
    expected = f"|{name}| up to {longest:.3g}; later the phase is uncertain by more than a radian"
    raise gi.DomainError(name, values, expected)


def refuse_left_over(left: Array, points: Array) -> None:
    """Raise ConvergenceError where an iteration has left more than it may."""
    failed = ~(left <= LEFT)
    if np.any(failed):
        first = np.argwhere(failed)[0]
        at, residual = float(points[tuple(first)][0]), float(left[tuple(first)])
        raise gi.ConvergenceError(
            at, 0, residual, 60, "no step: the inversion of the torus' angles"
        )
