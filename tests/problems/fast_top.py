"""Lagrange's top, spinning fast: nutations beside a slow precession."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

import geomint as gi
from geomint.problems.spaces.sphere import product

__all__ = ["initial", "problem"]


@gi.helper
def named(params: Any) -> Any:
    """Return I, C and W: the parameters, in the order of those of `problem`."""
    return params[0], params[1], params[2]


@gi.field
def motion(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """ṁ = m × Ω + W γ × e₃, γ̇ = γ × Ω, Ω = (m₁/I, m₂/I, m₃/C)."""
    across, along, weight = named(params)
    a, b, c = y[0] / across, y[1] / across, y[2] / along
    for i in range(0, 6, 3):
        out[i] = y[i + 1] * c - y[i + 2] * b
        out[i + 1] = y[i + 2] * a - y[i] * c
        out[i + 2] = y[i] * b - y[i + 1] * a
    out[0] = out[0] + weight * y[4]
    out[1] = out[1] - weight * y[3]


@gi.field
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """H = (m₁² + m₂²)/2I + m₃²/2C + W γ₃."""
    across, along, weight = named(params)
    swing = (y[0] * y[0] + y[1] * y[1]) / across
    return 0.5 * (swing + y[2] * y[2] / along) + weight * y[5]


@gi.field
def spin(params: Any, t: Any, y: Any, work: Any) -> Any:
    """m₃."""
    return 1.0 * y[2]


def initial(spin: float = 40.0) -> npt.NDArray[np.float64]:
    """Return a top with m₃ = spin that leans by 0.6435, let go with its axis at rest."""
    return np.array([0.0, 0.0, spin, 0.6, 0.0, 0.8])


def problem(across: float = 1.0, along: float = 0.5, weight: float = 2.0) -> gi.Problem:
    """Return Lagrange's top, seen from itself: angular momentum m and the vertical γ.

    ::

        ṁ = m × Ω + W γ × e₃,   γ̇ = γ × Ω,   Ω = (m₁/I, m₂/I, m₃/C)

    Moments of inertia I, I and C, W the weight times the distance of the centre of mass from the
    point that is fixed. Spinning fast it turns about its axis at m₃/C, nutates at m₃/I and precesses
    at W/m₃. Conserved: the energy, (m, γ), m₃, |γ|. Parameters: I, C, W. Form: ODE.

    References
    ----------
    L. D. Landau, E. M. Lifshitz, *Mechanics*, 3rd ed., §35; J. E. Marsden, T. S. Ratiu,
    *Introduction to Mechanics and Symmetry*, 2nd ed., section 15.10.
    """
    return gi.Problem(
        name="fast-top",
        pieces=(("m", 3), ("gamma", 3)),
        params=np.array([across, along, weight]),
        field=motion,
        invariants={
            "energy": energy,
            "vertical-momentum": product(3, 0, 3),
            "spin": spin,
            "direction-squared": product(3, 3, 3),
        },
        measure=gi.Measure(),
        parameters={"across": across, "along": along, "weight": weight},
    )
