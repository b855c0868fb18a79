"""Morse's oscillator: a bond that breaks at high energies, with its motion in closed form."""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi
from geomint.arguments import Array

__all__ = ["INITIAL", "exact", "problem"]

INITIAL = np.array([-0.3, 0.4])


@gi.field
def force(params: Any, t: Any, q: Any, out: Any, work: Any) -> None:
    """−∂V/∂q."""
    e = gi.exp(-params[1] * q[0])
    out[0] = -2.0 * params[0] * params[1] * e * (1.0 - e)


@gi.field
def motion(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """q̇ = p, ṗ = −∂V/∂q."""
    out[0] = 1.0 * y[1]
    force(params, t, gi.part(y, 0, 1), gi.part(out, 1, 1), work)


@gi.field
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """H = ½ p² + D (1 − e^(−aq))²."""
    stretch = 1.0 - gi.exp(-params[1] * y[0])
    return 0.5 * y[1] * y[1] + params[0] * stretch * stretch


def exact(problem: gi.Problem, y0: Array, t: Array) -> Array:
    """Return the states at times t of a motion with H < D, shape (times, 2).

    e^(aq) = (D + √(DH) cos(ωt + φ))/(D − H), ω = a √(2(D − H)).
    """
    depth, a = problem.params
    u = np.exp(a * y0[0])
    h = 0.5 * y0[1] ** 2 + depth * (1.0 - 1.0 / u) ** 2
    omega, size = a * np.sqrt(2.0 * (depth - h)), np.sqrt(depth * h)
    phase = np.arctan2(-a * u * y0[1] * (depth - h) / omega, u * (depth - h) - depth)
    angle = omega * np.asarray(t) + phase
    u = (depth + size * np.cos(angle)) / (depth - h)
    velocity = -omega * size * np.sin(angle) / (depth - h) / (a * u)
    return np.stack([np.log(u) / a, velocity], axis=-1)


def problem(depth: float = 1.5, a: float = 0.8) -> gi.Problem:
    """Return the oscillator of P. M. Morse of mass 1, H = ½ p² + D (1 − e^(−aq))².

    Bound for H < D, with a period that grows with the energy. Parameters: D, a. Forms: ODE and
    splitting.

    References
    ----------
    P. M. Morse, Phys. Rev. 34 (1929) 57.
    """
    return gi.Problem(
        name="morse",
        pieces=(("q", 1), ("p", 1)),
        params=np.array([depth, a]),
        field=motion,
        splitting=gi.natural_in_space(force),
        invariants={"energy": energy},
        measure=gi.Measure(),
        symplectic_form=gi.SymplecticForm(),
        parameters={"depth": depth, "a": a},
    )
