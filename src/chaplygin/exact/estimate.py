"""What is known of the error of an exact flow: an estimate from derivatives, and where it ends."""

from __future__ import annotations

import dataclasses
import functools
import math
import sys
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..manifold import Array

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
        return np.asarray(self._rounding * (self.offset + self.growth * times))

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
