"""Sine and cosine of our own, against 60 digits; their bits in all kinds of numbers: test_lanes."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, strategies as st

import geomint as gi
from geomint.kernels.numbers.circular import FAR
from geomint.kernels.numbers.lanes import Lanes

FUNCTIONS = {"sin": (gi.sin, mpmath.sin), "cos": (gi.cos, mpmath.cos)}
both = pytest.mark.parametrize("name", FUNCTIONS)


def off(name: str, x: np.ndarray) -> float:
    """The largest error in units in the last place."""
    function, exact = FUNCTIONS[name]
    found, worst = function(Lanes(x)), 0.0
    with mpmath.workdps(60):
        for value, argument in zip(found, x, strict=True):
            truth = exact(mpmath.mpf(float(argument)))
            error = abs(mpmath.mpf(float(value)) - truth)
            worst = max(worst, float(error / float(np.spacing(abs(float(truth))))))
    return worst


def arguments(kind: str) -> np.ndarray:
    rng = np.random.default_rng(5)
    half = 0.5 * np.pi * np.concatenate([np.arange(1, 200), rng.integers(200, 680_000_000, 200)])
    return {
        "first quarter": rng.uniform(-0.8, 0.8, 700),
        "some turns": rng.uniform(-20.0, 20.0, 700),
        "many turns": rng.uniform(-1.0, 1.0, 700) * FAR,
        "all sizes": 10.0 ** rng.uniform(-300.0, 9.0, 700),
        "multiples of a quarter": np.concatenate([half, np.nextafter(half, 0.0), 0.5 * half]),
        "next to the last": FAR - np.arange(200.0),
    }[kind]


@both
@pytest.mark.parametrize(
    "kind",
    ["first quarter", "some turns", "many turns", "all sizes", "multiples of a quarter",
     "next to the last"],
)  # fmt: skip
def test_errors_are_below_an_ulp(name: str, kind: str) -> None:
    assert off(name, arguments(kind)) < 0.76


@both
def test_beyond_they_are_the_library(name: str) -> None:
    far = np.array([np.nextafter(FAR, np.inf), 1e22, -1e300])
    expected = [getattr(math, name)(x) for x in far]
    np.testing.assert_array_equal(FUNCTIONS[name][0](Lanes(far)), expected)
    assert [FUNCTIONS[name][0](float(x)) for x in far] == expected
    for x in (np.inf, -np.inf, np.nan):
        assert np.isnan(FUNCTIONS[name][0](x))
    mixed = FUNCTIONS[name][0](Lanes([0.5, 1e22, np.inf, 0.5]))
    assert mixed[0] == mixed[3] == FUNCTIONS[name][0](0.5)
    assert mixed[1] == getattr(math, name)(1e22)
    assert np.isnan(mixed[2])


@given(st.floats(-FAR, FAR))
def test_symmetry_and_signs(x: float) -> None:
    assert gi.sin(-x) == -gi.sin(x)
    assert gi.cos(-x) == gi.cos(x)
    assert abs(gi.sin(x)) <= 1.0
    assert abs(gi.cos(x)) <= 1.0


def test_at_zero_and_next_to_it() -> None:
    assert math.copysign(1.0, gi.sin(0.0)) == 1.0
    assert math.copysign(1.0, gi.sin(-0.0)) == -1.0
    assert gi.cos(0.0) == gi.cos(-0.0) == 1.0
    for tiny in (5e-324, 1e-310, 2.0**-1022, 1e-160, 1e-9):
        assert gi.sin(tiny) == tiny
        assert gi.cos(tiny) == 1.0
