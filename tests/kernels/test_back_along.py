"""Points back to a level: of a sphere and a plane, where the way is known; and where there is none."""

from __future__ import annotations

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.numbers.blocks import Block
from geomint.kernels.solve.back_along import back_along

pytestmark = pytest.mark.nojit


@gi.field
def sphere_and_plane(params, t, y, out, work):
    out[0] = y[0] * y[0] + y[1] * y[1] + y[2] * y[2]
    out[1] = params[0] * y[2]


def asked(far: float, count: int = 20) -> tuple[np.ndarray, np.ndarray]:
    """Return points beside the circle z = ½ of the unit sphere, and their ways to it: (x, y), z."""
    rng = np.random.default_rng(3)
    angle = rng.uniform(0.0, 2.0 * np.pi, count)
    outward = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
    points = (np.sqrt(0.75) + far * rng.normal(size=count))[:, None] * outward
    points[:, 2] = 0.5 + far * rng.normal(size=count)
    ways = np.stack([outward, np.broadcast_to([0.0, 0.0, 1.0], (count, 3))], axis=1)
    return points, ways


def back(points: np.ndarray, ways: np.ndarray) -> tuple[np.ndarray, list[bool]]:
    """Return how far each way is gone, and whether it leads to the level."""
    count, rows, conditions = len(points), 3, 2
    a, found = np.zeros((count, conditions)), np.zeros(count)
    flat = [Block(x.reshape(-1)) for x in (points, ways)]
    scratch = Block(np.zeros(2 * rows + 3 * conditions)), Block(np.zeros(8 * conditions))
    level = Block(np.array([1.0])), Block(np.array([1.0, 0.5])), Block(np.array([1.0, 0.5]))
    with np.errstate(all="ignore"):
        back_along(
            *(sphere_and_plane, *level, rows, conditions, count, 1e-13),
            *(*flat, Block(np.zeros(0)), *scratch, Block(a.reshape(-1)), Block(found)),
        )
    return a, [x == 1.0 for x in found]


@pytest.mark.parametrize("far", [0.0, 1e-9, 0.01])
def test_the_way_is_known(far: float) -> None:
    points, ways = asked(far)
    a, found = back(points, ways)
    assert all(found)
    radius = np.linalg.norm(points[:, :2], axis=1)
    np.testing.assert_allclose(a[:, 0], radius - np.sqrt(0.75), rtol=0, atol=2e-13)
    np.testing.assert_allclose(a[:, 1], points[:, 2] - 0.5, rtol=0, atol=1e-13)


@pytest.mark.parametrize("far", [np.nan, np.inf, 1e200, 1e4])
def test_no_way_is_told_and_hurts_no_other(far: float) -> None:
    points, ways = asked(0.01, 5)
    alone, _ = back(points[:1], ways[:1])
    points[1, 0] = far
    ways[2] = 0.0  # leads nowhere
    ways[3, 1] = ways[3, 0]  # both the same: a singular matrix
    a, found = back(points, ways)
    assert found == [True, False, False, False, True]
    np.testing.assert_array_equal(a[0], alone[0])
