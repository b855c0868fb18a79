"""The plane of a Poincaré section, where it is known: its coordinates, and where the energy ends it.

In four dimensions an event and the energy leave two coordinates, and one number w that the energy
determines up to its sign. The motion can only be where the least energy over w is not more than its
own: the *boundary* of the section. Known are

- canonical coordinates in flat space, pieces of two numbers q and p, and an event ``q[i]``: the plane
  is that of the other pair, and w = p_i (likewise with q and p exchanged);
- a point γ of the sphere in R³ and a vector p tangent to it, and an event ``gamma[i]`` at level c: the
  plane has the angle φ about the axis e_i, in radians from e_(i+1) on, and ℓ = (γ × p)_i, what p turns
  about that axis; w is along the meridian, ``p = ℓ/√(1−c²) e_φ + w e_φ × γ``.
"""

from typing import NamedTuple, Protocol

import numpy as np

from ..arguments import Array
from ..kernels.compiling.recorded import Recorded
from ..problems.at_states import values_at
from ..problems.problem import Problem
from ..problems.spaces.euclidean import Euclidean
from ..problems.spaces.sphere import Sphere
from ..problems.spaces.tangent_bundle import TangentBundle
from .events import Event

__all__ = ["Boundary", "Plane", "boundary", "plane_of"]

CELLS = 160  # a side of the grid on which the boundary is found
BEYOND = 0.15  # of what the points span, or of the state's size: the grid begins so far outside
WIDENED = 12  # times at most, until all of the boundary is within the grid
PARABOLA = 1e-9  # of the energy's size: deviations from a parabola in w


class Plane(Protocol):
    """Coordinates of a plane: what they are called, those of states, and states with given ones."""

    axes: tuple[str, str]
    period: float | None  # x has values from −½ to ½ of it

    def coordinates(self, states: Array) -> tuple[Array, Array]:
        """Return x and y of states, one a row."""

    def states(self, x: Array, y: Array, w: float) -> Array:
        """Return states on the surface, one a row, with given x and y, and the third number w."""


class Boundary(NamedTuple):
    """A grid over the plane: x and y along its sides, the least energy at (y, x), and the motion's."""

    x: Array
    y: Array
    least: Array
    energy: float


class CanonicalPlane:
    """The other pair of canonical coordinates."""

    period: float | None = None

    def __init__(self, problem: Problem, row: int, level: float) -> None:
        other = 1 - row % 2
        self._row, self._level, self._third = row, level, (row + 2) % 4
        self._x, self._y = other, other + 2
        (q, _), (p, _) = problem.pieces
        self.axes = f"{q}[{other}]", f"{p}[{other}]"

    def coordinates(self, states: Array) -> tuple[Array, Array]:
        return states[:, self._x], states[:, self._y]

    def states(self, x: Array, y: Array, w: float) -> Array:
        result = np.empty((len(x), 4))
        result[:, self._row], result[:, self._third] = self._level, w
        result[:, self._x], result[:, self._y] = x, y
        return result


class SpherePlane:
    """The angle about an axis, and what the momentum turns about it."""

    period: float | None = 2.0 * np.pi

    def __init__(self, problem: Problem, axis: int, level: float) -> None:
        (point, _), (vector, _) = problem.pieces
        self._axis, self._level, self._radius = axis, level, float(np.sqrt(1.0 - level * level))
        self.axes = f"angle of {point} about axis {axis} (rad)", f"({point} × {vector})[{axis}]"

    def coordinates(self, states: Array) -> tuple[Array, Array]:
        j, k = (self._axis + 1) % 3, (self._axis + 2) % 3
        angle = np.arctan2(states[:, k], states[:, j])
        turn = states[:, j] * states[:, 3 + k] - states[:, k] * states[:, 3 + j]
        return angle, turn

    def states(self, x: Array, y: Array, w: float) -> Array:
        i, j, k = self._axis, (self._axis + 1) % 3, (self._axis + 2) % 3
        result = np.zeros((len(x), 6))
        gamma, p = result[:, :3], result[:, 3:]
        along = np.zeros_like(gamma)
        along[:, j], along[:, k] = -np.sin(x), np.cos(x)
        gamma[:, i] = self._level
        gamma[:, j], gamma[:, k] = self._radius * np.cos(x), self._radius * np.sin(x)
        p[:] = (y / self._radius)[:, None] * along + w * np.cross(along, gamma)
        return result


def plane_of(problem: Problem, event: Event) -> Plane | None:
    """Return the plane of a section, or None where it is not known."""
    row, sizes, space = event.row(problem), [rows for _, rows in problem.pieces], problem.space
    if row < 0:
        return None
    if sizes == [2, 2] and (space is None or isinstance(space, Euclidean)):
        return CanonicalPlane(problem, row, event.level)
    on_sphere = isinstance(space, TangentBundle) and isinstance(space.base, Sphere)
    if on_sphere and sizes == [3, 3] and row < 3 and abs(event.level) < 1.0:
        return SpherePlane(problem, row, event.level)
    return None


def boundary(problem: Problem, plane: Plane, states: Array) -> Boundary | None:
    """Return the energy over the plane, around the points of motions of the same energy.

    None if they are not of the same energy, if the problem has none, if it is no convex parabola in
    w, or if there is no end to where motions of this energy may come.
    """
    function = problem.diagnostics.get("energy")
    if function is None or not len(states):
        return None
    energies = values_at(problem, function, states)
    energy = float(np.median(energies))
    if not np.allclose(energies, energy, rtol=1e-6, atol=1e-9 * np.abs(energies).max()):
        return None
    size = max(float(np.abs(states).max()), 1e-300)
    (x_low, x_high), (y_low, y_high) = (_span(v, size) for v in plane.coordinates(states))
    if plane.period is not None:
        x_low, x_high = -0.5 * plane.period, 0.5 * plane.period
    found = None
    for _ in range(WIDENED):
        x, y = np.linspace(x_low, x_high, CELLS), np.linspace(y_low, y_high, CELLS)
        least = _least(problem, function, plane, x, y, size)
        if least is None:
            return None
        found = Boundary(x, y, least, energy)
        below = least < energy
        left, right = (plane.period is None and bool(below[:, i].any()) for i in (0, -1))
        bottom, top = bool(below[0].any()), bool(below[-1].any())
        if not (left or right or bottom or top):
            break
        wider, higher = 0.3 * (x_high - x_low), 0.3 * (y_high - y_low)
        x_low, x_high = x_low - wider * left, x_high + wider * right
        y_low, y_high = y_low - higher * bottom, y_high + higher * top
    else:  # motions may go as far as they like, as an angle does
        return None
    return found


def _least(
    problem: Problem, function: Recorded, plane: Plane, x: Array, y: Array, size: float
) -> Array | None:
    """Return the least energy over w at (y, x); None if it is no convex parabola in w."""
    across, up = np.meshgrid(x, y)
    low, middle, high, beyond = (
        values_at(problem, function, plane.states(across.ravel(), up.ravel(), w * size))
        for w in (-1.0, 0.0, 1.0, 2.0)
    )
    with np.errstate(invalid="ignore"):  # where the energy is infinite
        second, first = 0.5 * (high + low) - middle, 0.5 * (high - low)
        rest = np.abs(middle + 2.0 * first + 4.0 * second - beyond)
    if not (second > 0.0).all() or (rest > PARABOLA * (np.abs(beyond) + np.abs(second))).any():
        return None
    found = middle - first * first / (4.0 * second)
    return found.reshape(across.shape)


def _span(values: Array, size: float) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    more = BEYOND * max(high - low, size)
    return low - more, high + more
