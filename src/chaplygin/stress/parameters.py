"""Parameters at the edge: a_i a_j → D, numbers of very different size, nearly equal numbers."""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

import geomint as gi

from ..ball.sphere import ChaplyginSphere
from ..inertia import GeneralInertia
from ..manifold import Array, triangle_rows
from ..systems.models import ball_model
from .standard import SYSTEMS, D, a_values, case_of, direction, momentum, motion

EDGE = gi.StressAxis("edge", "a_i a_j → D", "1 − a_i a_j/D")
SPREAD = gi.StressAxis("spread", "spread parameters", "largest/middle")
EQUAL = gi.StressAxis("equal", "nearly equal a_i", "relative differences")

Parameters = Callable[[int, float], tuple[Array, float]]

BOUNDED = ("sphere", "rolling", "group", "poisson", "rubber")  # motions with a D to stay below
_EDGES = (0.5, 1e-1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-13, 0.0)
_SPREADS = (1.0, 1e1, 1e2, 1e4, 1e6)
_DIFFERENCES = (1e-1, 1e-6, 1e-9, 1e-12, 1e-15, 0.0)
_QUICK = (1e-13, 1e6, 1e-15)


def cases() -> list[gi.StressCase]:
    """Return the cases of the three axes."""
    sizes = dict.fromkeys(SYSTEMS, (3,)) | {"sphere": (3, 4), "veselova-lr": (4,)}
    return [
        *_along(EDGE, _EDGES, near_the_edge, dict.fromkeys(BOUNDED, (3,)) | {"sphere": (3, 4)}),
        *_along(EDGE, _EDGES, all_near_the_edge, {"sphere": (4,)}, "-all-pairs"),
        *_along(SPREAD, _SPREADS, spread, sizes),
        *_along(EQUAL, _DIFFERENCES, nearly_equal, sizes),
        *(
            gi.StressCase(
                name, SPREAD, ratio, 4, partial(build, 4, ratio), representations=("ball-attitude",)
            )
            for name, build in (
                ("ball-diagonal-n4", spread_diagonal),
                ("ball-full-n4", spread_full),
            )
            for ratio in _SPREADS
        ),
    ]


def _along(
    axis: gi.StressAxis,
    values: tuple[float, ...],
    parameters: Parameters,
    motions: dict[str, tuple[int, ...]],
    suffix: str = "",
) -> Iterator[gi.StressCase]:
    for name, dimensions in motions.items():
        for n in dimensions:
            for value in values:
                build = partial(_motion, name, parameters, n, value)
                yield case_of(axis, name, n, value, build, suffix, quick=value in _QUICK)


def _motion(name: str, parameters: Parameters, n: int, value: float) -> gi.Model:
    gamma = direction(n)
    return motion(name, *parameters(n, value), gamma, momentum(gamma))


def near_the_edge(n: int, distance: float) -> tuple[Array, float]:
    """Return a and D with a_1 a_2 = D (1 − distance): one moment grows without bounds."""
    a = 0.6 * a_values(n)
    a[0] = 1.6
    a[1] = D * (1.0 - distance) / a[0]
    return a, D


def all_near_the_edge(n: int, distance: float) -> tuple[Array, float]:
    """Return a and D with all a_i a_j nearly D (1 − distance): a ball much heavier than D."""
    a = np.sqrt(D * (1.0 - distance)) * (1.0 - 0.1 * distance * np.arange(n))
    return a, D


def powers(rows: int, ratio: float) -> Array:
    """Return numbers from 1/ratio to ratio."""
    return ratio ** np.linspace(-1.0, 1.0, rows)


def spread(n: int, ratio: float) -> tuple[Array, float]:
    """Return a_i from 1/ratio to ratio, and D, twice the largest a_i a_j."""
    a = a_values(n) * powers(n, ratio)
    return a, 2.0 * float(np.prod(np.sort(a)[-2:]))


def nearly_equal(n: int, difference: float) -> tuple[Array, float]:
    """Return a_i = 1 + i · difference, and D."""
    return np.asarray(1.0 + difference * np.arange(n)), D


def spread_diagonal(n: int, ratio: float) -> gi.Model:
    """Return a ball with moments from 1/ratio to ratio, not of the special form."""
    moments = powers(triangle_rows(n), ratio)[::-1] * np.array([1.0, 1.3, 0.8, 1.1, 0.9, 1.2])
    return _ball(n, GeneralInertia(moments))


def spread_full(n: int, ratio: float) -> gi.Model:
    """Return the same about axes of so(n) that have nothing to do with those of Rⁿ."""
    rows = triangle_rows(n)
    turn, _ = np.linalg.qr(np.sin(1.0 + np.arange(rows * rows) ** 1.5).reshape(rows, rows))
    matrix = turn @ np.diag(powers(rows, ratio)) @ turn.T
    return _ball(n, GeneralInertia(0.5 * (matrix + matrix.T)))


def _ball(n: int, inertia: GeneralInertia) -> gi.Model:
    k = np.cos(0.5 + 1.3 * np.arange(triangle_rows(n)))
    return ball_model(ChaplyginSphere(inertia=inertia, D=1.0), direction(n), k=k)
