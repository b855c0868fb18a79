"""A fast oscillator that drives a slow pendulum: forces that are stiff beside a slow motion."""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi

__all__ = ["INITIAL", "problem"]

INITIAL = np.array([0.02, 0.0, 1.0, 0.0])


@gi.field
def motion(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """ż₁ = −r z₂, ż₂ = r z₁, q̇ = p, ṗ = −sin q − ½ω ε |z|², with r = ω (1 + ε q)."""
    rate = params[0] * (1.0 + params[1] * y[2])
    out[0] = -rate * y[1]
    out[1] = rate * y[0]
    out[2] = 1.0 * y[3]
    turning = params[0] * params[1] * (y[0] * y[0] + y[1] * y[1])
    out[3] = -gi.sin(y[2]) - 0.5 * turning


@gi.field
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """H = ½ω (1 + ε q) |z|² + ½p² − cos q."""
    turning = params[0] * (1.0 + params[1] * y[2]) * (y[0] * y[0] + y[1] * y[1])
    return 0.5 * (turning + y[3] * y[3]) - gi.cos(y[2])


@gi.field
def turning(params: Any, t: Any, y: Any, work: Any) -> Any:
    """|z|², twice the action of the oscillator."""
    return y[0] * y[0] + y[1] * y[1]


def problem(frequency: float = 100.0, coupling: float = 0.1) -> gi.Problem:
    """Return an oscillator z of frequency ω (1 + ε q) and a pendulum, q and p.

    ::

        H = ½ω (1 + ε q) |z|² + ½p² − cos q

    Conserved: the energy, and |z|², so that the pendulum feels a constant force. Parameters: ω, ε.
    Form: ODE.

    References
    ----------
    E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, 2nd ed., XIII.
    """
    return gi.Problem(
        name="fast-rotor",
        pieces=(("z", 2), ("q", 1), ("p", 1)),
        params=np.array([frequency, coupling]),
        field=motion,
        invariants={"energy": energy, "turning": turning},
        measure=gi.Measure(),
        parameters={"frequency": frequency, "coupling": coupling},
    )
