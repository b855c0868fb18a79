"""Steady motions: along rotations about principal axes the generators of the actions are constant.

A ball rolls straight on, with γ and p on principal axes, or spins upright about one; bodies and points
move alike.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

import geomint as gi

from ..manifold import Array, wedge
from .standard import SYSTEMS, D, a_values, built, case_of, motion, only

STEADY = gi.StressAxis("steady", "steady motions and fixed points", "distance")

Build = Callable[[str, int, float], gi.Model]

_DISTANCES = (1e-1, 1e-6, 1e-12, 0.0)
STEP, STEPS = 0.02, 50  # in the problem's time: what stands still has no characteristic one
_UPRIGHT = ("rolling", "group", "poisson", "veselova-classical")
_STRAIGHT = tuple(
    name for name in SYSTEMS if name not in ("group", "poisson", "veselova-classical")
)


def cases() -> list[gi.StressCase]:
    """Return motions that are steady, and such at a distance from them."""
    kinds = (
        ("straight", straight, _STRAIGHT),
        ("upright", upright, _UPRIGHT),
    )
    return [
        case_of(
            STEADY,
            name,
            3,
            distance,
            partial(build, name, 3, distance),
            f"-{kind}",
            quick=distance == 0.0,
            step=STEP,
            steps=STEPS,
            steady=distance == 0.0,
        )
        for kind, build, names in kinds
        for name in names
        for distance in _DISTANCES
    ]


def straight(name: str, n: int, distance: float) -> gi.Model:
    """Return a motion with γ along the first axis and p along the second: it stays in their plane."""
    gamma, p = near_axis(n, 0, distance), 2.0 * near_axis(n, 1, distance)
    for _ in range(2):
        p -= (gamma @ p) * gamma
    return motion(name, a_values(n), D, gamma, p)


def upright(name: str, n: int, distance: float) -> gi.Model:
    """Return a motion about the vertical, which is along the last axis."""
    a, gamma = a_values(n), near_axis(n, n - 1, distance)
    if name == "veselova-classical":
        parameters = {"moments": a, "f1": 1.0}
        return built(SYSTEMS[name], parameters, {"gamma": gamma, "w": gamma})
    k = wedge(near_axis(n, 0, distance), near_axis(n, 1, distance))
    model = built(SYSTEMS[name], {"a": a, "D": D}, {"gamma": gamma, "k": k})
    return only(model, "rolling", "contact") if name == "rolling" else model


def near_axis(n: int, i: int, distance: float) -> Array:
    """Return the unit vector along an axis, turned by about that distance."""
    x = distance * np.cos(0.7 + 1.3 * i + 1.9 * np.arange(n))
    x[i] = 1.0
    return x / np.linalg.norm(x)
