"""A charged particle around a black hole of Schwarzschild in a magnetic field."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

import geomint as gi

__all__ = ["initial", "problem"]


@gi.helper
def named(params: Any) -> Any:
    """Return E, L and β: the parameters, in the order of those of `problem`."""
    return params[0], params[1], params[2]


@gi.field
def motion(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """Hamilton's equations."""
    E, L, beta = named(params)
    r, pr, pt = y[0], y[2], y[3]
    s, c, w = gi.sin(y[1]), gi.cos(y[1]), 1.0 / r
    fall = E / (r - 2.0)
    turned = L * w / s  # that of a circle at this distance from the axis
    half = 0.5 * beta
    squares = pt * pt * w * w + turned * turned
    out[0] = (1.0 - 2.0 * w) * pr
    out[1] = pt * w * w
    out[2] = squares * w - fall * fall - pr * pr * w * w - half * half * r * s * s
    out[3] = (turned * turned / s - half * half * r * r * s) * c


@gi.field
def hamiltonian(params: Any, t: Any, y: Any, work: Any) -> Any:
    """H, −½ for a particle with mass."""
    E, L, beta = named(params)
    r, pr, pt = y[0], y[2], y[3]
    s = gi.sin(y[1])
    across = r * s
    turned = L / across - 0.5 * beta * across
    radial = (1.0 - 2.0 / r) * pr * pr - E * E * r / (r - 2.0)
    return 0.5 * (radial + pt * pt / (r * r) + turned * turned)


@gi.field
def angular_momentum_squared(params: Any, t: Any, y: Any, work: Any) -> Any:
    """p_θ² + L²/sin² θ."""
    _, L, _ = named(params)
    turned = L / gi.sin(y[1])
    return y[3] * y[3] + turned * turned


def initial(problem: gi.Problem, distance: float = 11.0) -> npt.NDArray[np.float64]:
    """Return the state in the equatorial plane with p_r = 0 and H = −½, at a distance."""
    still = np.array([distance, 0.5 * math.pi, 0.0, 0.0])
    still[3] = distance * math.sqrt(-1.0 - 2.0 * gi.value(problem, hamiltonian, still))
    return still


def problem(energy: float = 0.995, momentum: float = 4.6, magnetic: float = 8.9e-5) -> gi.Problem:
    """Return the motion of a charged particle around a black hole in a uniform magnetic field.

    ::

        H = ½ (1 − 2/r) p_r² − ½ E²/(1 − 2/r) + p_θ²/2r² + (L − ½ β r² sin² θ)²/(2 r² sin² θ)

    State: ``q`` = (r, θ), ``p`` = (p_r, p_θ), dimensionless: distances in GM/c²; time is proper time.
    Not separable. Conserved: H; with β = 0, a geodesic, p_θ² + L²/sin² θ too. Parameters: E, L, β.
    The defaults are those of arXiv:2511.03655, a regular motion. Form: ODE.

    References
    ----------
    Y. Wang, W. Sun, F. Liu, X. Wu, Astrophys. J. 907 (2021) 66; M. Antoñana, J. Makazaga, A. Murua,
    arXiv:2511.03655.
    """
    integrals = {"hamiltonian": hamiltonian}
    if magnetic == 0.0:
        integrals["angular-momentum-squared"] = angular_momentum_squared
    return gi.Problem(
        name="schwarzschild",
        pieces=(("q", 2), ("p", 2)),
        params=np.array([energy, momentum, magnetic]),
        field=motion,
        invariants=integrals,
        measure=gi.Measure(),
        symplectic_form=gi.SymplecticForm(),
        parameters={"energy": energy, "momentum": momentum, "magnetic": magnetic},
    )
