"""Which quantities are of which kind is found without being told."""

import numpy as np
import pytest

import chaplygin as ch
from geomint.problems.testproblems import pulsating_body
from geomint.stress.preserved import Quantities
from tests.problems import double_pendulum, spherical_pendulum


def kinds(problem, kind, size=1.0):
    return Quantities(problem, size * np.ones(problem.rows)).of_kind(kind)


PULSATING = {"momentum-squared", "direction-squared", "inclination"}
SPHERE = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)


@pytest.mark.parametrize(
    ("problem", "kind", "names"),
    [
        (pulsating_body.problem(), "group orbits", PULSATING),
        # (q, q) changes where (q, p) is not 0, and the energy where the multiplier is not exact.
        (spherical_pendulum.problem(), "quadratic invariants", {"tangency", "angular-momentum"}),
        (double_pendulum.problem(), "constraints", {"upper-rod", "lower-rod"}),
        (double_pendulum.problem(), "group orbits", set()),
        (SPHERE.hamiltonized(), "quadratic invariants", {"norm", "tangency"}),
        (SPHERE.ball(), "group orbits", {"K", "momentum", "norm"}),
        (SPHERE.classical(attitude=True), "group orbits", {"K", "area", "norm", "orthogonality"}),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_kinds(problem, kind, names):
    found = kinds(problem, kind)
    assert set(found) == names
    assert all(defect <= 1e-13 for defect in found.values())


@pytest.mark.parametrize("distance", [1e-2, 1e-6, 1e-9, 1e-12, 1e-13])
def test_no_kind_by_mere_size(distance):
    """A tiny energy, or a moment that outweighs all else, must not hide that a quantity changes."""
    D = 4.0
    edge = ch.ChaplyginSphere(np.sqrt(D * (1.0 - distance * np.arange(1.0, 5.0))), D)
    assert "energy" not in kinds(edge.ball(), "group orbits")
    heavy = ch.ChaplyginSphere(a=[1.6, 2.5 * (1.0 - distance), 0.4], D=4.0)
    kept = kinds(heavy.rolling(4.0, 1.0), "quadratic invariants")
    assert not {"energy", "K"} & set(kept)


def test_what_holds_nearly_is_known_by_how_much():
    ball = ch.ChaplyginSphere(a=1.0 + 1e-13 * np.arange(4), D=4.0).ball()
    assert 0.0 < kinds(ball, "group orbits")["energy"] < 1e-12
    other = ch.ChaplyginSphere(a=1.0 + 1e-9 * np.arange(4), D=4.0).ball()
    assert "energy" not in kinds(other, "group orbits")


def test_scale():
    problem, y = spherical_pendulum.problem(), spherical_pendulum.INITIAL
    quantities = Quantities(problem, y)
    expected = np.sum(np.abs(2.0 * y[:3] * 0.8))
    assert quantities.scale("norm", 0.0, y) == pytest.approx(expected, rel=1e-4)
    assert quantities.value("tangency", 0.0, y) == pytest.approx(y[:3] @ y[3:])


@pytest.mark.parametrize("size", [1.0, 1e30])
def test_no_kind_by_a_constant_that_outweighs_the_state(size):
    """|g k − k_0| of a k_0 of 1e30 is the same everywhere, unless k is of that size too."""
    ball = SPHERE.rolling(4.0, 1.0, k0=size * np.array([0.3, -1.0, 0.7]))
    assert "spatial-momentum" not in kinds(ball, "group orbits", size)


def test_scale_of_a_piece_that_is_zero():
    problem = spherical_pendulum.problem()
    y = np.array([0.6, 0.0, -0.8, 0.0, 0.0, 0.0])
    assert Quantities(problem, y).scale("tangency", 0.0, y) > 0.5
