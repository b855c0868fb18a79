"""Volumes that steps make: of linear maps, where they are known, and along many directions."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given, strategies as st

import geomint as gi
from tests.measure.exact_maps import exact_defect
from tests.measure.test_defect import NOISE, observed, volume
from tests.rows import examples

pytestmark = pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")


@gi.field
def linear(params, t, y, out, work):
    """A y, whose matrix is given row after row."""
    for i in range(len(y)):
        out[i] = 0.0 * y[i]
        for k in range(len(y)):
            out[i] += params[i * len(y) + k] * y[k]


@pytest.mark.nojit
@examples(5)
@given(st.integers(1, 9), st.floats(-12.0, 0.5), st.integers(0, 10**6))
def test_determinants_of_linear_maps(d: int, exponent: float, seed: int) -> None:
    """Near 1 to the rounding of their distance from it, and far from it."""
    rng = np.random.default_rng(seed)
    A, y0 = 10.0**exponent / d * rng.normal(size=(d, d)), rng.normal(size=d)
    measure = gi.Measure(volume)
    p = gi.Problem("linear", (("y", d),), A.ravel(), field=linear, measure=measure)
    drift = observed(p, "rk-4", y0, 0.5, compiled=False)
    with mpmath.workdps(60):
        hA = mpmath.matrix(A.tolist()) / 2
        terms = [hA**k / mpmath.factorial(k) for k in range(1, 5)]
        R = mpmath.eye(d) + terms[0] + terms[1] + terms[2] + terms[3]
        expected = float(mpmath.log(abs(mpmath.det(R))))
    assert abs(drift.final_error - expected) <= 1e-13 * 10.0**exponent + drift.scale * NOISE


@pytest.mark.nojit
def test_no_volume() -> None:
    """What a step folds up has no number that looks like its volume."""
    A, measure = [-2.0, -2.0, 2.0, -2.0], gi.Measure(volume)  # 1 + hA + (hA)²/2 = 0
    p = gi.Problem("folded", (("y", 2),), A, field=linear, measure=measure)
    drift = observed(p, "heun-2", [1.0, 0.5], 0.5, compiled=False)
    assert not np.isfinite(drift.final_error)


@gi.field
def turning(params, t, y, out, work):
    """Nine points on circles, each turned by how far the next one is."""
    for i in range(9):
        speed = 1.0 + 0.3 * y[2 * ((i + 1) % 9)] * y[2 * i]
        out[2 * i] = -speed * y[2 * i + 1]
        out[2 * i + 1] = speed * y[2 * i]


@gi.field
def on_circles(params, t, y, out, work):
    for i in range(9):
        out[i] = y[2 * i] * y[2 * i] + y[2 * i + 1] * y[2 * i + 1] - 1.0


MEASURES = {"circles": gi.Measure(volume, on_circles, 9), "free": gi.Measure(volume)}
ANGLES = np.linspace(0.2, 5.0, 9)
ROUND = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1).ravel()


@pytest.mark.parametrize(
    ("name", "method", "compiled"),
    [
        ("circles", "rk-4", False),
        ("free", "rk-4", False),
        pytest.param("free", "rk-4", True, marks=pytest.mark.nightly),
        pytest.param("circles", "rk-4", True, marks=pytest.mark.nightly),
        pytest.param("circles", "gauss-1", True, marks=pytest.mark.nightly),
    ],
)
def test_many_directions(name: str, method: str, compiled: bool) -> None:
    """More than eight, and more than eight conditions; the first step and later ones."""
    h = 0.1
    p = gi.Problem(name, (("x", 18),), field=turning, measure=MEASURES[name])
    expected = exact_defect(p, method, 0.0, ROUND, h)
    assert abs(expected) > 1e-9
    single = observed(p, method, ROUND, h, compiled=compiled)
    assert single.final_error == pytest.approx(expected, abs=2e-15)
    if name == "free":
        run = {"method": method, "step": h, "observe": ["measure"], "save_every": 1}
        sol = gi.solve(p, ROUND, t_end=2 * h, compiled=compiled, **run)
        later = exact_defect(p, method, 0.0, sol.y[1], h)
        assert sol.drift["measure"].final_error == pytest.approx(expected + later, abs=5e-15)
