"""A body that changes its shape while it turns: SO(3) acting on vectors, in time."""

from collections import namedtuple
from typing import Any

import numpy as np

from ...kernels.compiling.recorded import field, helper
from ...kernels.numbers.blocks import packed, sections
from ...kernels.numbers.circular import cos
from ..forms import GroupAction, Measure
from ..groups import so3
from ..problem import Problem
from ..spaces.sphere import product

__all__ = ["INITIAL", "problem"]

Body = namedtuple("Body", "inertia pulse frequencies rotor")
LAYOUT = Body(inertia=3, pulse=3, frequencies=3, rotor=3)  # of the parameters
INITIAL = np.array([0.7, -0.4, 1.1, 0.48, 0.6, -0.64])


@helper
def angular_velocity(params: Any, t: Any, y: Any, i: int) -> Any:
    """Ω_i = m_i / (I_i (1 + ε_i cos ω_i t)) + κ_i γ_i."""
    inertia, pulse, frequencies, rotor = sections(params, LAYOUT)
    now = inertia[i] * (1.0 + pulse[i] * cos(frequencies[i] * t))
    return y[i] / now + rotor[i] * y[3 + i]


@field
def generator(params, t, y, out, work):
    """ξ = −Ω: the vectors turn against the body."""
    for i in range(3):
        out[i] = -angular_velocity(params, t, y, i)


@field
def motion(params, t, y, out, work):
    """ṁ = m × Ω, γ̇ = γ × Ω."""
    w0 = angular_velocity(params, t, y, 0)
    w1 = angular_velocity(params, t, y, 1)
    w2 = angular_velocity(params, t, y, 2)
    for i in range(0, 6, 3):
        out[i] = y[i + 1] * w2 - y[i + 2] * w1
        out[i + 1] = y[i + 2] * w0 - y[i] * w2
        out[i + 2] = y[i] * w1 - y[i + 1] * w0


def problem(
    inertia: tuple[float, float, float] = (1.0, 1.6, 2.3),
    pulse: tuple[float, float, float] = (0.3, -0.2, 0.25),
    frequencies: tuple[float, float, float] = (1.0, 1.7, 0.6),
    rotor: tuple[float, float, float] = (0.5, -0.3, 0.2),
) -> Problem:
    """Return a body of pulsating shape, seen from itself: angular momentum m and a fixed line γ.

    ::

        ṁ = m × Ω,   γ̇ = γ × Ω,   Ω_i = m_i / (I_i (1 + ε_i cos ω_i t)) + κ_i γ_i

    Principal moments I that change with time by prescribed motions of masses that carry no angular
    momentum, and rotors that are turned as γ directs. Both vectors are turned by one element of
    SO(3), whose generator depends on time and state and does not commute with itself. Conserved:
    (m, m), (γ, γ), (m, γ). Parameters: I, ε, ω, κ. Forms: ODE and group action.

    References
    ----------
    The torque-free body with time-dependent inertia: J. E. Marsden, T. S. Ratiu, *Introduction to
    Mechanics and Symmetry*, 2nd ed., chapter 15.
    """
    given = {"inertia": inertia, "pulse": pulse, "frequencies": frequencies, "rotor": rotor}
    return Problem(
        name="pulsating-body",
        pieces=(("m", 3), ("gamma", 3)),
        params=packed(LAYOUT, **given).data,
        field=motion,
        action=GroupAction(generator, so3(2)),
        invariants={
            "momentum-squared": product(3, 0, 0),
            "direction-squared": product(3, 3, 3),
            "inclination": product(3, 0, 3),
        },
        measure=Measure(),
        parameters={name: list(numbers) for name, numbers in given.items()},
    )
