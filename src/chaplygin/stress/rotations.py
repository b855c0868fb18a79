"""Rotations by nearly π and 2π in one step: where logarithms and closed forms of exp have trouble."""

from functools import partial

import numpy as np

import geomint as gi

from ..ball.sphere import ChaplyginSphere
from ..inertia import GeneralInertia
from ..manifold import triangle_rows
from ..systems.models import ball_model
from .standard import SYSTEMS, built, direction

ROTATION = gi.StressAxis("rotation", "rotations by nearly π and 2π in a step", "angle/π")

_FEW = ("1−1e-04", "1−1e-12", "1", "2")  # angles of what turns as the ball does
_QUICK = ("1−1e-15", "1")
_OFF = (1e-1, 1e-4, 1e-8, 1e-12, 1e-15)
STEPS = 4


def cases() -> list[gi.StressCase]:
    """Return steady rotations, which Lie group methods follow exactly, and others."""
    angles = [(1.0 - off, f"1−{off:.0e}") for off in _OFF] + [(1.0, "1")]
    angles += [(1.0 + off, f"1+{off:.0e}") for off in reversed(_OFF)]
    angles += [(2.0 - 1e-9, "2−1e-09"), (2.0, "2"), (2.0 + 1e-9, "2+1e-09")]
    turning = [
        gi.StressCase(
            f"{name}-n3",
            ROTATION,
            angle,
            3,
            partial(_turning, name),
            label=label,
            representations=chosen,
            step=angle * np.pi,
            steps=STEPS,
            steady=True,
        )
        for name, chosen in (
            ("group", ("group",)),
            ("rolling", ("rolling", "contact")),
            ("rubber", ("rolling",)),
            ("veselova-lr", ("lr",)),
        )
        for angle, label in angles
        if label in _FEW
    ]
    return turning + [
        gi.StressCase(
            f"{name}-n{n}",
            ROTATION,
            angle,
            n,
            partial(build, n),
            label=label,
            representations=(
                "ball-attitude",
                *(("classical", "classical-attitude") if n == 3 else ()),
            ),
            step=angle * np.pi,
            steps=STEPS,
            steady=build is steady,
            quick=("classical",) if name == "tumbling" and label in _QUICK and n == 3 else (),
        )
        for name, build, dimensions in (
            ("steady", steady, (3, 5)),
            ("tumbling", tumbling, (3, 4)),
        )
        for n in dimensions
        for angle, label in angles
    ]


def _moments(n: int) -> GeneralInertia:
    return GeneralInertia(1.0 + 0.5 * np.cos(np.arange(triangle_rows(n))))


def steady(n: int) -> gi.Model:
    """Return rotations about the vertical, at angular velocity 1 in the first plane: ω is constant.

    At n = 5 the second plane turns as well, at an incommensurate velocity.
    """
    inertia = _moments(n)
    omega = np.zeros((n, n))
    omega[0, 1] = 1.0
    if n > 4:
        omega[2, 3] = np.sqrt(0.5)
    omega = omega - omega.T
    gamma = np.zeros(n)
    gamma[-1] = 1.0
    return ball_model(ChaplyginSphere(inertia=inertia, D=1.0), gamma, attitude=True, omega=omega)


def _turning(name: str) -> gi.Model:
    """Return that rotation at n = 3 with other pieces; what is bound turns about a level axis."""
    moments, gamma = _moments(3).diagonal, np.array([0.0, 0.0, 1.0])
    if name == "veselova-lr":
        return built(SYSTEMS[name], {"inertia": moments}, {"w": [1.0, 0.0, 0.0]})
    omega = [0.0, 1.0, 0.0] if name == "rubber" else [1.0, 0.0, 0.0]
    return built(SYSTEMS[name], {"inertia": moments, "D": 1.0}, {"gamma": gamma, "omega": omega})


def tumbling(n: int) -> gi.Model:
    """Return a general motion at an angular velocity of about 1."""
    omega = np.triu(np.sin(2.0 + np.arange(n * n)).reshape(n, n), 1)
    omega /= np.linalg.norm(omega, 2)
    sphere = ChaplyginSphere(inertia=_moments(n), D=1.0)
    return ball_model(sphere, direction(n), attitude=True, omega=omega - omega.T)
