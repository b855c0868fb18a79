"""Exponents of growth: how the rms over members of an ensemble depends on the number of steps."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

RESAMPLED = 400


def rms(deviations: Array) -> Array:
    """Return the rms over members (the last axis) at every number of steps (the first)."""
    return np.sqrt(np.mean(deviations**2, axis=-1))


def exponent(steps: Array, deviations: Array) -> tuple[float, float]:
    """Return b of ``rms ~ steps^b`` and its standard error.

    Points of one run are not independent of each other, members are: the error is that of fits to
    members drawn anew (B. Efron's bootstrap).

    Parameters
    ----------
    steps : array, shape (points,)
    deviations : array, shape (points, members)
    """
    x = np.log(steps) - np.log(steps).mean()
    weights = x / (x @ x)
    members = deviations.shape[1]
    rng = np.random.default_rng(0)
    drawn = rng.integers(members, size=(RESAMPLED, members))
    again = [float(weights @ np.log(rms(deviations[:, who]))) for who in drawn]
    return float(weights @ np.log(rms(deviations))), float(np.std(again))


def common_part(deviations: Array) -> Array:
    """Return the mean over members over their rms, at every number of steps.

    0 ± 1/√members for errors of either sign, ±1 where all members err alike.
    """
    return np.mean(deviations, axis=-1) / rms(deviations)
