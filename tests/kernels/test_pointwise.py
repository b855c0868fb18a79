"""`geomint.pointwise`: a function at many points, compiled and in plain Python."""

import numpy as np
import pytest

import geomint as gi


@gi.helper
def total(x):
    result = 0.0
    for i in range(len(x)):
        result += x[i]
    return result


@gi.field
def scaled(params, t, x, out, work):
    """(x, y) ↦ (factor · x, x + y, y − t)."""
    work[0] = total(x)
    out[0], out[1], out[2] = params[0] * x[0], work[0], x[1] - t


@pytest.mark.nojit
def test_values_and_shapes():
    for points in (np.arange(12.0).reshape(2, 3, 2), np.arange(12).reshape(2, 6).T):
        found = gi.pointwise(scaled, [3.0], points, 3, 1)
        assert found.shape == (*points.shape[:-1], 3)
        np.testing.assert_array_equal(found[..., 0], 3.0 * points[..., 0])
        np.testing.assert_array_equal(found[..., 1], points.sum(axis=-1))
        np.testing.assert_array_equal(found[..., 2], points[..., 1])
    assert gi.pointwise(scaled, [3.0], [1.0, 2.0], 3, 1).shape == (3,)
    assert gi.pointwise(scaled, [3.0], np.zeros((0, 2)), 3, 1).shape == (0, 3)
    with pytest.raises(gi.DomainError, match="last axis"):
        gi.pointwise(scaled, [3.0], 1.0, 3, 1)


def test_more_points_than_go_into_a_call():
    points = np.random.default_rng(1).normal(size=(20_001, 2))
    found = gi.pointwise(scaled, [2.0], points, 3, 1)
    np.testing.assert_array_equal(found[:, 0], 2.0 * points[:, 0])
    np.testing.assert_array_equal(found[:, 1], points[:, 0] + points[:, 1])
