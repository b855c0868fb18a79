"""States at the edge: momenta of any size, γ on coordinate planes and axes."""

from collections.abc import Callable
from functools import partial

import numpy as np

import geomint as gi

from ..manifold import Array
from .standard import SYSTEMS, D, a_values, case_of, motion, started

MOMENTUM = gi.StressAxis("momentum", "small and large momenta", "|p|²")
PLANES = gi.StressAxis("planes", "γ on axes and planes", "distance")

GammaAt = Callable[[int, float], Array]

_POWERS = (-500, -250, -25, 0, 25, 250, 500)  # of 2, for |p|/2; |p|² is 1e-300 … 1e300
_DISTANCES = (1e-1, 1e-8, 1e-300, 0.0)
_FOUR = ("sphere", "veselova", "veselova-lr")  # motions that are placed in R⁴ as well


def cases() -> list[gi.StressCase]:
    """Return the cases of both axes."""
    found = [
        case
        for name in SYSTEMS
        for case in (_at_rest(name, 3), *(_scaled(name, 3, power) for power in _POWERS))
    ]
    for name in SYSTEMS:
        for place, gamma_at, sizes in (
            ("axis", near_an_axis, (3, 4) if name in _FOUR else (3,)),
            ("plane", near_a_plane, (3,)),
        ):
            found += [
                case_of(
                    PLANES,
                    name,
                    n,
                    distance,
                    partial(_placed, name, gamma_at, n, distance),
                    f"-at-{place}",
                    quick=distance == 0.0,
                )
                for n in sizes
                for distance in _DISTANCES
            ]
    return found


def _scaled(name: str, n: int, power: int) -> gi.StressCase:
    """Return p times a power of two: the same motion in another unit of time, to the last bit."""
    size = 2.0**power
    value, start = 4.0 * size * size, partial(started, name, n)
    build, label, quick = partial(start, size), f"{value:.0e}", abs(power) == 250
    return case_of(MOMENTUM, name, n, value, build, "", quick, label=label)


def _at_rest(name: str, n: int) -> gi.StressCase:
    return case_of(MOMENTUM, name, n, 0.0, partial(started, name, n, 0.0))


def _placed(name: str, gamma_at: GammaAt, n: int, distance: float) -> gi.Model:
    """Return γ at that place and a p ⟂ γ, in the plane of the first axes as far as γ lets it."""
    gamma = gamma_at(n, distance)
    gamma = gamma / np.linalg.norm(gamma)
    p = np.zeros(n)
    p[:2] = np.array([1.3, -0.7])
    return motion(name, a_values(n), D, gamma, gi.Sphere(n).tangent(gamma, p))


def near_an_axis(n: int, distance: float) -> Array:
    """Return a vector along the last axis, but for components of that size."""
    gamma = np.full(n, distance)
    gamma[-1] = 1.0
    return gamma


def near_a_plane(n: int, distance: float) -> Array:
    """Return a vector in the plane of the first two axes, but for components of that size."""
    gamma = np.full(n, distance)
    gamma[:2] = 0.6, 0.8
    return gamma
