"""The outer Solar System: the Sun with the inner planets, Jupiter to Neptune, and Pluto."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

import geomint as gi
from geomint.kernels.compiling.recorded import Recorded
from geomint.kernels.numbers.blocks import sections

__all__ = ["initial", "problem"]

Gravity = namedtuple("Gravity", "constant masses")
LAYOUT = Gravity(constant=1, masses=gi.REST)  # of the parameters

CONSTANT = 2.95912208286e-4  # of gravity, AU³ per day² and mass of the Sun
BODIES = ("sun", "jupiter", "saturn", "uranus", "neptune", "pluto")
MASSES = (  # of the Sun; the first with those of the inner planets
    *(1.00000597682, 9.54786104043e-4, 2.85583733151e-4),
    *(4.37273164546e-5, 5.17759138449e-5, 1.0 / 1.3e8),
)
POSITIONS = (  # AU, September 5, 1994, 0h00
    (0.0, 0.0, 0.0),
    (-3.5023653, -3.8169847, -1.5507963),
    (9.0755314, -3.0458353, -1.6483708),
    (8.3101420, -16.2901086, -7.2521278),
    (11.4707666, -25.7294829, -10.8169456),
    (-15.5387357, -25.2225594, -3.1902382),
)
VELOCITIES = (  # AU a day
    (0.0, 0.0, 0.0),
    (0.00565429, -0.00412490, -0.00190589),
    (0.00168318, 0.00483525, 0.00192462),
    (0.00354178, 0.00137102, 0.00055029),
    (0.00288930, 0.00114527, 0.00039677),
    (0.00276725, -0.00170702, -0.00136504),
)


@gi.field
def acceleration(params: Any, t: Any, q: Any, out: Any, work: Any) -> None:
    """a_i = G Σ_{j≠i} m_j (q_j − q_i)/|q_j − q_i|³."""
    constant, masses = sections(params, LAYOUT)
    for i in range(len(q)):
        out[i] = 0.0 * q[0]
    for i in range(0, len(q), 3):
        for j in range(i + 3, len(q), 3):
            x, y, z = q[j] - q[i], q[j + 1] - q[i + 1], q[j + 2] - q[i + 2]
            square = x * x + y * y + z * z
            pull = constant[0] / (square * gi.sqrt(square))
            there, here = pull * masses[j // 3], pull * masses[i // 3]
            out[i] = out[i] + there * x
            out[i + 1] = out[i + 1] + there * y
            out[i + 2] = out[i + 2] + there * z
            out[j] = out[j] - here * x
            out[j + 1] = out[j + 1] - here * y
            out[j + 2] = out[j + 2] - here * z


@gi.field
def motion(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """q̇ = v, v̇ = a(q)."""
    n = len(y) // 2
    for i in range(n):
        out[i] = 1.0 * y[n + i]
    acceleration(params, t, gi.part(y, 0, n), gi.part(out, n, n), work)


@gi.field
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """H = ½ Σ m_i |v_i|² − G Σ_{i<j} m_i m_j/|q_j − q_i|."""
    constant, masses = sections(params, LAYOUT)
    n, total = len(y) // 2, 0.0 * y[0]
    for i in range(0, n, 3):
        a, b, c = y[n + i], y[n + i + 1], y[n + i + 2]
        total += 0.5 * masses[i // 3] * (a * a + b * b + c * c)
        for j in range(i + 3, n, 3):
            a, b, c = y[j] - y[i], y[j + 1] - y[i + 1], y[j + 2] - y[i + 2]
            total -= constant[0] * masses[i // 3] * masses[j // 3] / gi.sqrt(a * a + b * b + c * c)
    return total


def momentum(k: int) -> Recorded:
    """P_k = Σ m_i v_ik."""

    @gi.field
    def component(params: Any, t: Any, y: Any, work: Any) -> Any:
        masses = sections(params, LAYOUT).masses
        n, total = len(y) // 2, 0.0 * y[0]
        for i in range(0, n, 3):
            total += masses[i // 3] * y[n + i + k]
        return total

    return component


def angular_momentum(k: int) -> Recorded:
    """L = Σ m_i q_i × v_i, component k."""
    a, b = (k + 1) % 3, (k + 2) % 3

    @gi.field
    def component(params: Any, t: Any, y: Any, work: Any) -> Any:
        masses = sections(params, LAYOUT).masses
        n, total = len(y) // 2, 0.0 * y[0]
        for i in range(0, n, 3):
            total += masses[i // 3] * (y[i + a] * y[n + i + b] - y[i + b] * y[n + i + a])
        return total

    return component


@gi.field
def mass_form(params: Any, t: Any, y: Any, u: Any, v: Any, work: Any) -> Any:
    """Σ m_i dq_i∧dv_i."""
    masses = sections(params, LAYOUT).masses
    n, total = len(y) // 2, 0.0 * u[0]
    for i in range(n):
        total += masses[i // 3] * (u[i] * v[n + i] - u[n + i] * v[i])
    return total


def initial(pluto: bool = True) -> npt.NDArray[np.float64]:
    """Return the state of September 5, 1994, 0h00: heliocentric, the Sun at rest."""
    bodies = len(BODIES) if pluto else len(BODIES) - 1
    return np.concatenate([np.ravel(POSITIONS[:bodies]), np.ravel(VELOCITIES[:bodies])])


def problem(pluto: bool = True) -> gi.Problem:
    """Return the N-body problem of the outer Solar System, with Pluto or without.

    ::

        q̈_i = G Σ_{j≠i} m_j (q_j − q_i)/|q_j − q_i|³

    State: positions ``q`` in AU and velocities ``v`` in AU a day, body after body, of the Sun (with
    the inner planets), Jupiter, Saturn, Uranus, Neptune and Pluto; time in days, masses in that of
    the Sun. Conserved: the energy, momentum and angular momentum. Forms: ODE and splitting.

    References
    ----------
    E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, 2nd ed., I.2.4, table 2.2.
    """
    bodies = len(BODIES) if pluto else len(BODIES) - 1
    vectors: dict[str, Callable[[int], Recorded]] = {
        "momentum": momentum,
        "angular-momentum": angular_momentum,
    }
    return gi.Problem(
        name=f"outer-solar-system-{bodies}",
        pieces=(("q", 3 * bodies), ("v", 3 * bodies)),
        params=gi.packed(LAYOUT, constant=CONSTANT, masses=MASSES[:bodies]).data,
        field=motion,
        splitting=gi.natural_in_space(acceleration),
        invariants={
            "energy": energy,
            **{f"{name}-{k + 1}": make(k) for name, make in vectors.items() for k in range(3)},
        },
        measure=gi.Measure(),
        symplectic_form=gi.SymplecticForm(mass_form),
        parameters={"pluto": pluto},
        units={"q": "AU", "v": "AU/day", "t": "day"},
    )
