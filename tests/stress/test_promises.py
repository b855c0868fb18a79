"""Which quantities are of which kind is found without being told."""

import numpy as np
import pytest

import chaplygin as ch
from geomint.stress.promises import Quantities
from geomint.testproblems import double_pendulum, pulsating_body, spherical_pendulum

SPHERE = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)


@pytest.mark.parametrize(
    ("problem", "kind", "names"),
    [
        (
            pulsating_body.problem(),
            "group orbits",
            {"momentum-squared", "direction-squared", "inclination"},
        ),
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
    assert set(Quantities(problem).of_kind(kind)) == names


def test_scale():
    problem, y = spherical_pendulum.problem(), spherical_pendulum.INITIAL
    quantities = Quantities(problem)
    expected = np.sum(np.abs(2.0 * y[:3] ** 2))
    assert quantities.scale("sphere", 0.0, y) == pytest.approx(expected, rel=1e-4)
    assert quantities.value("tangency", 0.0, y) == pytest.approx(y[:3] @ y[3:])
