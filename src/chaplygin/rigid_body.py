"""Moments of inertia that no rigid body has: a warning where they are given as those of a body.

A body of positive masses has a mass tensor J ≥ 0, its moments are I_ij = J_i + J_j. In R³ that is the
triangle inequality I_i ≤ I_j + I_k, of which J_i = ½(I_j + I_k − I_i) is half of what is left over.
The equations want a positive definite operator only. So what is given as an operator (``a``,
``inertia``), as in the paper, is taken as it is; ``moments`` and ``J`` name a body, and there a
violation is more likely a slip than meant.
"""

from typing import Any

import numpy as np

import geomint as gi

from .manifold import Array, warn

LEAST = 4e-3  # of m r²: mass within 0.045 radii
ROUNDING = 1e-13  # of the largest value: a body as flat as a disc has a J_i of 0


def warn_of_moments(moments: Any) -> None:
    """Warn where principal moments, or an inertia tensor in R³, break the triangle inequality."""
    values, unit = _principal(moments)
    largest, others = values[-1], float(np.sum(values[:-1]))
    excess = largest - others
    if excess > ROUNDING * largest:
        warn(
            f"moments: the largest, {unit * largest:.6g}, is more than the sum of the others, "
            f"{unit * others:.6g}, by {unit * excess:.3g}: no rigid body has such moments "
            "(I_i ≤ I_j + I_k)",
            "moments",
            excess,
            gi.DeclarationWarning,
        )


def warn_of_mass_tensor(J: Any) -> None:
    """Warn where a mass tensor, or one of its principal values, is negative."""
    values, unit = _principal(J)
    if values[0] < -ROUNDING * values[-1]:
        warn(
            f"J: the principal value {unit * values[0]:.6g} is negative: no rigid body has such a mass "
            "tensor (J_i ≥ 0)",
            "J",
            -values[0],
            gi.DeclarationWarning,
        )


def check_inside(moments: Array, mass: float, radius: float) -> None:
    """Raise `DomainError` for moments > 0 that no body inside of a ball has, about its centre.

    They sum to twice ∫|x|² dm, which is at most 2 m r². Much less than that is mass in a point, or in
    grams, or a radius in centimetres.
    """
    values, unit = _principal(moments)
    inside = float(np.sum(values)) * (unit / mass / radius / radius)
    if values[-1] - float(np.sum(values[:-1])) > ROUNDING * values[-1]:
        raise gi.DomainError("moments", moments, "I_i ≤ I_j + I_k, as all bodies have")
    if values[0] > 0.0 and not LEAST <= inside <= 2.0 + ROUNDING:
        uniform = f"a uniform one has 0.4 m r² = {0.4 * mass * radius * radius:.3g} three times"
        expected = f"a sum of {LEAST:g} m r² … 2 m r², as of bodies in a ball, in kg m²: {uniform}"
        raise gi.DomainError("moments", moments, expected)


def _principal(tensor: Any) -> tuple[Array, float]:
    """Return the principal values in ascending order, and their unit: sums of 1e308 are no number."""
    values = np.array(tensor, dtype=np.float64)
    unit = float(np.max(np.abs(values)))
    values /= unit or 1.0
    if values.ndim != 2 or values.shape[0] != values.shape[1]:
        return np.sort(values.reshape(-1)), unit
    return np.asarray(np.linalg.eigvalsh(0.5 * (values + values.T))), unit
