"""Derivatives, the sampler, and the motion from d'Alembert's principle."""

from __future__ import annotations

import numpy as np
import pytest

from tests.paper.calculus import derivative, gradient, nested, nested_gradient
from tests.paper.motion import ball_motion, constrained_rotation
from tests.paper.points import sample

DIMENSIONS = (2, 3, 5, 7)


def test_derivatives_to_round_off():
    def f(x):
        return np.exp(x[0]) / np.sqrt(x[0] ** 2 + x[1] ** 4)

    x, v = np.array([0.7, 1.3]), np.array([0.4, -2.0])
    r = x[0] ** 2 + x[1] ** 4
    exact = np.array([1.0 - x[0] / r, -2.0 * x[1] ** 3 / r]) * f(x)
    assert gradient(f, x) == pytest.approx(exact, rel=1e-15)
    assert derivative(f, x, v) == pytest.approx(exact @ v, rel=1e-15)
    assert nested(f, x, v) == pytest.approx(exact @ v, rel=3e-15)


def test_derivatives_of_derivatives():
    x = np.array([0.7, 1.3])
    hessian = nested_gradient(lambda y: nested_gradient(lambda z: np.sin(z[0] * z[1]), y), x)
    s, c, t = np.sin(x[0] * x[1]), np.cos(x[0] * x[1]), x[0] * x[1]
    exact = np.array([[-(x[1] ** 2) * s, c - t * s], [c - t * s, -(x[0] ** 2) * s]])
    assert hessian == pytest.approx(exact, abs=1e-12)


@pytest.mark.parametrize("n", DIMENSIONS)
def test_points_are_admissible_and_reproducible(n):
    point, again = sample(n, 1, 5), sample(n, 1, 5)
    assert (point.gamma == again.gamma).all()
    assert (point.normal("x", 3) == again.normal("x", 3)).all()
    assert (point.gamma != sample(n, 2, 5).gamma).any()
    assert point.gamma @ point.gamma == pytest.approx(1.0, abs=1e-15)
    assert point.gamma @ point.p == pytest.approx(0.0, abs=1e-14)
    assert point.g.T @ point.Gamma == pytest.approx(point.gamma, abs=1e-14)
    assert np.linalg.det(point.g) == pytest.approx(1.0)
    i, j = point.pairs
    assert (point.a[i] * point.a[j] < point.D).all()
    assert (np.diff(point.a) > 0).all()
    off = point.off
    assert abs(off.gamma @ off.gamma - 1.0) > 0.1
    assert abs(off.gamma @ off.p) > 0.1


def test_the_reaction_matters():
    """A ball that slides freely moves otherwise: the constraint is felt."""
    point = sample(4, 0)
    heavy = ball_motion(point.with_(m=100.0), point.general, point.omega)
    light = ball_motion(point.with_(m=1e-9), point.general, point.omega)
    free = constrained_rotation(point, point.general, point.omega, [])[0]
    assert light.omega_dot == pytest.approx(free, abs=1e-6)
    assert np.max(np.abs(heavy.omega_dot - free)) > 0.1
