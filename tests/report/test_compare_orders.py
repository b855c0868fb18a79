"""Orders fitted to errors: known slopes come back, what is no slope is none."""

import numpy as np
import pytest

from geomint.reports.compare_orders import FittedOrder, fitted_order, fitted_orders


def falling(order, steps, constant=1.0, floor=0.0):
    return [(h, constant * h**order + floor) for h in steps]


HALVED = [0.4 / 2**k for k in range(5)]


@pytest.mark.parametrize(("order", "factor"), [(1, 1.0), (2, 1e-290), (4, 1e100), (32, 1.0)])
def test_a_pure_power_is_its_order(order, factor):
    """Of whatever size, in any order of the points."""
    measured = falling(order, HALVED, factor)
    found = fitted_order(order, measured)
    assert found.fitted == pytest.approx(order, abs=1e-9)
    assert found.error < 1e-9
    assert found.steps == tuple(HALVED)
    assert fitted_order(order, measured[::-1]) == found


def test_rounding_and_large_steps_are_left_out():
    fine = [(h / 32, 1e-14 * (1 + 0.3 * k)) for k, h in enumerate(HALVED)]
    coarse = [(3.2, 1.7), (1.6, 1.5), (0.8, 1.6)]
    found = fitted_order(4, coarse + falling(4, HALVED) + fine)
    assert found.fitted == pytest.approx(4.0, abs=0.3)
    assert set(found.steps) >= set(HALVED[:4])
    assert not {3.2, 1.6, HALVED[-1] / 32} & set(found.steps)


def test_the_error_is_that_of_the_line():
    noise = [1.1, 0.9, 1.1, 0.9, 1.1]
    measured = [(h, e * f) for (h, e), f in zip(falling(4, HALVED), noise, strict=True)]
    found = fitted_order(4, measured)
    (slope, _), covariance = np.polyfit(*np.log(measured).T, 1, cov=True)
    assert found.fitted == pytest.approx(slope)
    assert found.error == pytest.approx(covariance[0, 0] ** 0.5)


def test_without_a_steady_fall_there_is_no_order():
    """Of too few points, a plateau, growing errors, one step that is measured often."""
    few = [], [(0.1, 1e-3)], falling(4, HALVED[:2])
    for measured in (
        *few, [(h, 1e-14) for h in HALVED], [(h, 1e-3 / h) for h in HALVED], [(0.1, 1e-3)] * 5,
    ):  # fmt: skip
        assert fitted_order(4, measured) == FittedOrder(4)
    assert FittedOrder(4).text == "—"


def test_the_text():
    given = (4.0163, 0.0061), (3.75, 0.072), (4.0, 0.0), (3.2, 1.4)
    texts = [FittedOrder(4, fitted, error).text for fitted, error in given]
    assert texts == ["4.016 ± 0.006", "3.75 ± 0.07", "4.0000 ± 0.0000", "3.2 ± 1.4"]


def test_points_of_a_comparison():
    plain = {"order": 4, "representation": "own", "rtol": None}
    points = [{**plain, "method": "a", "step": h, "error": e} for h, e in falling(4, HALVED)]
    points += [{**plain, "method": "b", "step": 0.1, "error": None}]
    points += [{**plain, "method": "c", "step": 0.0, "error": None, "representation": ""}]
    points += [{**plain, "method": "d", "step": 0.1, "error": 1e-3, "rtol": 1e-8}]
    found = fitted_orders(points)
    assert list(found) == ["a", "b"]
    assert found["a"].fitted == pytest.approx(4.0)
    assert found["b"].fitted is None
