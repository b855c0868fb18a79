"""Hénon and Heiles: two coupled anharmonic oscillators."""

import numpy as np

from ...kernels.compiling.recorded import field
from ...kernels.numbers.blocks import part
from ..forms import Measure
from ..natural import natural_in_space
from ..problem import Problem
from ..two_form import SymplecticForm

__all__ = ["CHAOTIC", "INITIAL", "problem"]

INITIAL = np.array([0.1, -0.2, 0.3, 0.15])
CHAOTIC = np.array([0.0, 0.3, np.sqrt(0.138), 0.2])  # energy 1/8


@field
def force(params, t, q, out, work):
    """−∂V/∂q."""
    q1, q2 = q[0], q[1]
    out[0] = -q1 - 2.0 * params[0] * q1 * q2
    out[1] = -q2 - params[0] * (q1 * q1 - q2 * q2)


@field
def motion(params, t, y, out, work):
    """q̇ = p, ṗ = −∂V/∂q."""
    out[0] = y[2]
    out[1] = y[3]
    force(params, t, part(y, 0, 2), part(out, 2, 2), work)


@field
def energy(params, t, y, work):
    """H = ½(|p|² + |q|²) + λ (q₁² q₂ − q₂³/3)."""
    q1, q2 = y[0], y[1]
    kinetic = 0.5 * (y[2] * y[2] + y[3] * y[3])
    cubic = q2 * (q1 * q1 - q2 * q2 / 3.0)
    return kinetic + 0.5 * (q1 * q1 + q2 * q2) + params[0] * cubic


def problem(coupling: float = 1.0) -> Problem:
    """Return the system of Hénon and Heiles, H = ½(|p|² + |q|²) + λ (q₁² q₂ − q₂³/3).

    Chaotic at energies near 1/6 (λ = 1); at `INITIAL`, 0.0777, nearly integrable; at `CHAOTIC`, the
    state of energy 1/8 of E. Hairer, R. I. McLachlan, A. Razakarivony (BIT 48 (2008) 231) and of
    arXiv:2511.03655, chaotic. Forms: ODE and splitting.

    References
    ----------
    M. Hénon, C. Heiles, Astron. J. 69 (1964) 73.
    """
    return Problem(
        name="henon-heiles",
        pieces=(("q", 2), ("p", 2)),
        params=np.array([coupling]),
        field=motion,
        splitting=natural_in_space(force),
        invariants={"energy": energy},
        measure=Measure(),
        symplectic_form=SymplecticForm(),
        parameters={"coupling": coupling},
    )
