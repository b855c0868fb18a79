"""A pulsating flow of Arnold, Beltrami and Childress: three parts, volume but no symplectic form."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np

import geomint as gi
from geomint.kernels.numbers.blocks import sections

__all__ = ["INITIAL", "problem"]

Shears = namedtuple("Shears", "amplitudes season")
LAYOUT = Shears(amplitudes=3, season=1)  # of the parameters
INITIAL = np.array([0.4, -0.7, 1.9])


@gi.field
def motion(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """ẋ = A sin z + C cos y, ẏ = B sin x + A cos z, ż = C sin y + B cos x."""
    amplitudes, season = sections(params, LAYOUT)
    A, B, C = amplitudes[0] * (1.0 + season[0] * gi.cos(2.0 * t)), amplitudes[1], amplitudes[2]
    out[0] = A * gi.sin(y[2]) + C * gi.cos(y[1])
    out[1] = B * gi.sin(y[0]) + A * gi.cos(y[2])
    out[2] = C * gi.sin(y[1]) + B * gi.cos(y[0])


@gi.helper
def shears(k: int, params: Any, t: Any, h: Any, y: Any, out: Any, work: Any) -> None:
    """Part k, with the amplitude A, B or C: one coordinate rests and moves the other two."""
    rests = (k + 2) % 3
    amplitudes, season = sections(params, LAYOUT)
    amplitude = h * amplitudes[k]
    if k == 0:
        amplitude *= 1.0 + season[0] * gi.cos(2.0 * t)
    out[rests] = 0.0 * h
    out[k] = amplitude * gi.sin(y[rests])
    out[(k + 1) % 3] = amplitude * gi.cos(y[rests])


def problem(A: float = 1.0, B: float = 0.8, C: float = 0.6, season: float = 0.4) -> gi.Problem:
    """Return the ABC flow with A pulsating as A (1 + ε cos 2t).

    ::

        ẋ = A sin z + C cos y,   ẏ = B sin x + A cos z,   ż = C sin y + B cos x

    Chaotic, keeps volumes and nothing else. Forms: ODE and splitting, the terms of A, B and C: not
    symplectic, in an odd number of dimensions.

    References
    ----------
    T. Dombre et al., J. Fluid Mech. 167 (1986) 353.
    """
    return gi.Problem(
        name="abc-flow",
        pieces=(("x", 3),),
        params=gi.packed(LAYOUT, amplitudes=(A, B, C), season=season).data,
        field=motion,
        splitting=gi.Splitting(shears, 3, symplectic=False),
        measure=gi.Measure(),
        parameters={"A": A, "B": B, "C": C, "season": season},
    )
