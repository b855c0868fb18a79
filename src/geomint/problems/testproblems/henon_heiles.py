"""Hénon and Heiles: two coupled anharmonic oscillators."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...kernels.compiling.recorded import field
from ..forms import Measure
from ..problem import Problem
from ..two_form import SymplecticForm

__all__ = ["INITIAL", "problem"]

INITIAL = np.array([0.1, -0.2, 0.3, 0.15])


@field
def motion(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """q̇ = p, ṗ = −∂V/∂q."""
    q1, q2 = y[0], y[1]
    out[0] = y[2]
    out[1] = y[3]
    out[2] = -q1 - 2.0 * params[0] * q1 * q2
    out[3] = -q2 - params[0] * (q1 * q1 - q2 * q2)


@field
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """H = ½(|p|² + |q|²) + λ (q₁² q₂ − q₂³/3)."""
    q1, q2 = y[0], y[1]
    kinetic = 0.5 * (y[2] * y[2] + y[3] * y[3])
    cubic = q2 * (q1 * q1 - q2 * q2 / 3.0)
    return kinetic + 0.5 * (q1 * q1 + q2 * q2) + params[0] * cubic


def problem(coupling: float = 1.0) -> Problem:
    """Return the system of Hénon and Heiles, H = ½(|p|² + |q|²) + λ (q₁² q₂ − q₂³/3).

    Chaotic at energies near 1/6 (λ = 1); at `INITIAL`, 0.0777, nearly integrable.

    References
    ----------
    M. Hénon, C. Heiles, Astron. J. 69 (1964) 73.
    """
    return Problem(
        name="henon-heiles",
        pieces=(("q", 2), ("p", 2)),
        params=np.array([coupling]),
        field=motion,
        invariants={"energy": energy},
        measure=Measure(),
        symplectic_form=SymplecticForm(),
        parameters={"coupling": coupling},
    )
