"""Predators and prey in changing seasons: nonlinear, non-autonomous, two numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi

__all__ = ["INITIAL", "problem"]

INITIAL = np.array([1.3, 0.7])


@gi.helper
def named(params: Any) -> Any:
    """Return ε and ω: the parameters, in the order of those of `problem`."""
    return params[0], params[1]


@gi.field
def rates(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """u̇ = u (1 + ε cos ωt − v), v̇ = v (u − 1 − v/8)."""
    (amplitude, frequency), u, v = named(params), y[0], y[1]
    season = amplitude * gi.cos(frequency * t)
    out[0] = u * ((1.0 - v) + season)
    out[1] = v * ((u - 1.0) - 0.125 * v)


@gi.field
def log_density(params: Any, t: Any, y: Any, work: Any) -> Any:
    """Log μ = (t + ε sin(ωt)/ω)/8 − 9/8 log u − log v: crowding dissipates, so μ depends on time."""
    amplitude, frequency = named(params)
    seasons = t + amplitude * gi.sin(frequency * t) / frequency
    return 0.125 * seasons - 1.125 * gi.log(y[0]) - gi.log(y[1])


def problem(amplitude: float = 0.4, frequency: float = 1.5) -> gi.Problem:
    """Return the equations of Lotka and Volterra with a seasonal growth of the prey.

    ::

        u̇ = u (1 + ε cos ωt − v),        v̇ = v (u − 1 − v/8)

    with crowding of the predators; nothing is conserved but a measure. Parameters: ε, ω.

    References
    ----------
    S. Rinaldi, S. Muratori, Y. Kuznetsov, Bull. Math. Biol. 55 (1993) 15, on seasonally perturbed
    predator-prey systems.
    """
    return gi.Problem(
        name="seasonal-lotka-volterra",
        pieces=(("u", 1), ("v", 1)),
        params=np.array([amplitude, frequency]),
        field=rates,
        measure=gi.Measure(log_density),
        parameters={"amplitude": amplitude, "frequency": frequency},
    )
