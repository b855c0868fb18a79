"""Points back to a level: of a sphere and a plane, where the way is known; and where there is none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.run.way_back import way_back

SIZES = np.array([1.0, 0.5])


@gi.field
def still(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    for i in range(3):
        out[i] = 0.0 * y[i]


@gi.field
def sphere_and_plane(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = y[0] * y[0] + y[1] * y[1] + y[2] * y[2]
    out[1] = params[0] * y[2]


SPACE = gi.Problem("space", (("x", 3),), field=still, params=[1.0])


def asked(seed: int, far: float, count: int = 50) -> tuple[np.ndarray, np.ndarray]:
    """Return points beside the circle z = ½ of the unit sphere, and their ways to it: (x, y), z."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0.0, 2.0 * np.pi, count)
    outward = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=1)
    radius = np.sqrt(0.75) + far * rng.normal(size=count)
    points = radius[:, None] * outward
    points[:, 2] = 0.5 + far * rng.normal(size=count)
    ways = np.stack([outward, np.broadcast_to([0.0, 0.0, 1.0], (count, 3))], axis=1)
    return points, ways


@pytest.mark.nojit
@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("far", [0.0, 1e-9, 0.01])
def test_the_way_is_known(far: float, compiled: bool) -> None:
    points, ways = asked(3, far)
    back = way_back(SPACE, sphere_and_plane, np.array([1.0, 0.5]), SIZES, compiled)
    a, found = back(points, ways, np.zeros((50, 2)), 1e-13)
    assert found.all()
    radius = np.linalg.norm(points[:, :2], axis=1)
    np.testing.assert_allclose(a[:, 0], radius - np.sqrt(0.75), rtol=0, atol=2e-13)
    np.testing.assert_allclose(a[:, 1], points[:, 2] - 0.5, rtol=0, atol=1e-13)


@pytest.mark.nojit
def test_bits_are_those_of_plain_python_and_of_single_points() -> None:
    points, ways = asked(4, 0.05, 20)
    begun = np.random.default_rng(0).normal(size=(20, 2)) * 0.1
    wanted = np.array([1.0, 0.5])
    fast, plain = (way_back(SPACE, sphere_and_plane, wanted, SIZES, c) for c in (True, False))
    a, found = fast(points, ways, begun, 1e-13)
    b, same = plain(points, ways, begun, 1e-13)
    np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(found, same)
    for k in range(20):
        (one,), (met,) = fast(points[k : k + 1], ways[k : k + 1], begun[k : k + 1], 1e-13)
        assert met == found[k]
        np.testing.assert_array_equal(one, a[k])


@pytest.mark.nojit
@pytest.mark.parametrize("far", [np.nan, np.inf, 1e200, 1e4])
def test_no_way_is_told_and_hurts_no_other(far: float) -> None:
    points, ways = asked(5, 0.01, 4)
    points[1, 0] = far
    ways[2] = 0.0  # leads nowhere
    ways[3, 1] = ways[3, 0]  # both the same: a singular matrix
    back = way_back(SPACE, sphere_and_plane, np.array([1.0, 0.5]), SIZES)
    _, found = back(points, ways, np.zeros((4, 2)), 1e-13)
    assert found.tolist() == [True, False, False, False]
