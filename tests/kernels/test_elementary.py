"""Elementary functions of our own against 60 digits; their bits in all kinds of numbers: test_lanes."""

from __future__ import annotations

import math
from collections.abc import Callable

import mpmath
import numpy as np
import pytest
from hypothesis import given, strategies as st

import geomint as gi
from geomint.kernels.numbers.lanes import Lanes
from geomint.kernels.numbers.tangent import Tangent

pytestmark = pytest.mark.nojit

BOUNDS = {gi.sin: 0.76, gi.cos: 0.76, gi.tan: 0.76, gi.atan2: 0.6, gi.tanh: 0.65}
BOUNDS |= {gi.exp: 0.76, gi.log: 0.51, gi.pow: 0.8}
LARGEST, TINY = 1.7976931348623157e308, 5e-324
INF, NAN = math.inf, math.nan
FAR = 2.0**30  # of angles: what is beyond is the library's


def exact(function: Callable[..., float]) -> Callable[..., mpmath.mpf]:
    return getattr(mpmath, function.__name__, mpmath.power)


def error(found: float, truth: mpmath.mpf) -> float:
    """In units in the last place of what is true; those of subnormal numbers are all alike."""
    near = float(truth)
    if math.isinf(near) or math.isinf(found):
        return 0.0 if near == found else math.inf
    return float(abs(mpmath.mpf(float(found)) - truth) / float(np.spacing(abs(near))))


def off(function: Callable[..., float], *numbers: np.ndarray) -> float:
    """The largest error."""
    found = function(*map(Lanes, numbers))
    with mpmath.workdps(60):
        rows = [[mpmath.mpf(float(x)) for x in row] for row in zip(*numbers, strict=True)]
        return max(error(f, exact(function)(*row)) for f, row in zip(found, rows, strict=True))


def uniform(low: float, high: float, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).uniform(low, high, 700)


def signs(seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).choice([-1.0, 1.0], 700)


def sizes(low: float, high: float, seed: int = 1) -> np.ndarray:
    return 10.0 ** uniform(low, high, seed)


def near_one(least: float, most: float) -> np.ndarray:
    return 1.0 + signs(2) * sizes(least, most)


def to_reach(x: np.ndarray, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """Bases, and exponents whose powers have logarithms in a range."""
    x = x[x != 1.0]
    return x, (uniform(low, high, 4)[: len(x)] / np.log(x))


HALF = 0.5 * np.pi * np.concatenate([np.arange(1, 200), np.linspace(200, 680_000_000, 200) // 1])
QUARTERS = np.concatenate([HALF, np.nextafter(HALF, 0.0), 0.5 * HALF])
ANGLES = {
    "first quarter": (uniform(-0.8, 0.8),),
    "some turns": (uniform(-20.0, 20.0),),
    "many turns": (FAR * uniform(-1.0, 1.0),),
    "all sizes": (sizes(-320.0, 9.0),),
    "multiples of a quarter": (QUARTERS,),
    "next to the last": (FAR - np.arange(200.0),),
}
# Regimes of each function: where another part of it decides, and its borders.
REGIMES = {
    gi.sin: ANGLES,
    gi.cos: ANGLES,
    gi.tan: ANGLES,
    gi.exp: {
        "all": (uniform(-708.0, 709.78),),
        "near 0": (uniform(-1.0, 1.0),),
        "tiny": (signs() * sizes(-320.0, 0.0),),
        "subnormal": (uniform(-745.2, -708.0),),
        "next to overflow": (709.782712893384 - sizes(-13.0, -3.0),),
        "halves of log 2": (math.log(2.0) * (np.arange(-1020.0, 1020.0, 3.0) + 0.5),),
    },
    gi.log: {
        "all": (sizes(-307.0, 308.0),),
        "subnormal": (sizes(-323.0, -307.0),),
        "near 1": (near_one(-16.0, -0.3),),
        "next to the root of 2": (np.sqrt(2.0) * near_one(-16.0, -3.0),),
        "ends": (np.array([TINY, 2.0**-1022, LARGEST]),),
    },
    gi.pow: {
        "some": (sizes(-3.0, 3.0), uniform(-100.0, 100.0)),
        "all": to_reach(sizes(-300.0, 300.0), -745.0, 709.7),
        "large powers": to_reach(uniform(0.71, 1.41), 600.0, 709.7),
        "large exponents": to_reach(near_one(-15.0, -0.5), -745.0, 709.7),
        "subnormal powers": to_reach(near_one(-15.0, -0.5), -745.0, -708.0),
        "subnormal bases": (sizes(-323.0, -308.0), uniform(-0.95, 2.0)),
        "whole": (-sizes(-10.0, 10.0), np.round(uniform(-30.0, 30.0))),
        "halves": (sizes(-300.0, 300.0), np.round(uniform(-3.0, 3.0)) / 2.0),
        "tiny exponents": (sizes(-300.0, 300.0), signs() * sizes(-300.0, -1.0, 3)),
    },
    gi.tanh: {
        "all": (uniform(-20.0, 20.0),),
        "near 0": (uniform(-1.0, 1.0),),
        "tiny": (signs() * sizes(-320.0, 0.0),),
        "next to 1": (uniform(18.0, 20.0),),
    },
    gi.atan2: {
        "all": (signs() * sizes(-320.0, 308.0), signs(2) * sizes(-320.0, 308.0, 2)),
        "square": (uniform(-1.0, 1.0), uniform(-1.0, 1.0, 2)),
        "large": (uniform(-1.0, 1.0) * LARGEST, uniform(-1.0, 1.0, 2) * LARGEST),
        "subnormal": (uniform(-1.0, 1.0) * 1e-310, uniform(-1.0, 1.0, 2) * 1e-309),
        "subnormal angles": (uniform(-1.0, 1.0) * 1e-308, sizes(-1.0, 14.0)),
        "subnormal heights": (uniform(-1.0, 1.0) * 1e-310, signs() * sizes(-310.0, -290.0)),
        "next to a quarter of the plane": (signs() * near_one(-16.0, -1.0), signs(3)),
        "between pieces": (signs() * near_one(-16.0, -2.0) * 0.25, np.ones(700)),
        "between other pieces": (signs() * near_one(-16.0, -2.0) * 0.75, -np.ones(700)),
    },
}  # fmt: skip


@pytest.mark.parametrize(
    ("function", "kind"), [(f, kind) for f, kinds in REGIMES.items() for kind in kinds]
)
def test_errors_are_below_an_ulp(function: Callable[..., float], kind: str) -> None:
    assert off(function, *REGIMES[function][kind]) < BOUNDS[function]


finite = st.floats(allow_nan=False, allow_infinity=False)


@given(finite, finite)
def test_any_numbers(x: float, y: float) -> None:
    """Within a unit in the last place, or what mathematics has no number for."""
    with mpmath.workdps(60):
        u, v = mpmath.mpf(x), mpmath.mpf(y)
        assert error(gi.exp(x), exact(gi.exp)(max(min(u, 1e4), -1e4))) < 1.0
        assert error(gi.tanh(x), exact(gi.tanh)(max(min(u, 1e4), -1e4))) < 1.0
        if x:  # there is no −0 of many digits
            assert error(gi.atan2(x, y), exact(gi.atan2)(u, v)) < 1.0
        if x > 0.0:
            assert error(gi.log(x), exact(gi.log)(u)) < 1.0
            if abs(y) * abs(math.log(x)) < 1e4:
                assert error(gi.pow(x, y), exact(gi.pow)(u, v)) < 1.0


@given(st.integers(-2000, 2000), st.integers(0, 12))
def test_powers_that_are_numbers_are_exact(base: int, exponent: int) -> None:
    """Those that have 53 bits, to the last; and roots of squares, and inverses of powers of two."""
    if abs(base**exponent) < 2**53:
        assert gi.pow(base, exponent) == base**exponent
        assert gi.pow(float(abs(base**exponent)) ** 2, 0.5) == abs(base**exponent)
    assert gi.pow(2.0, -exponent) == 2.0**-exponent
    assert gi.pow(float(base), 1.0) == base


# --- special values -------------------------------------------------------------------------------

SPECIAL = [
    (gi.exp, (0.0,), 1.0), (gi.exp, (-0.0,), 1.0), (gi.exp, (INF,), INF), (gi.exp, (-INF,), 0.0),
    (gi.exp, (709.782712893384,), 1.7976931348622732e308), (gi.exp, (709.7827128933841,), INF),
    (gi.exp, (LARGEST,), INF), (gi.exp, (-LARGEST,), 0.0), (gi.exp, (-745.1332191019411,), TINY),
    (gi.exp, (-745.1332191019412,), 0.0), (gi.exp, (NAN,), NAN),
    (gi.log, (0.0,), -INF), (gi.log, (-0.0,), -INF), (gi.log, (1.0,), 0.0), (gi.log, (INF,), INF),
    (gi.log, (-TINY,), NAN), (gi.log, (-INF,), NAN), (gi.log, (NAN,), NAN),
    (gi.tanh, (0.0,), 0.0), (gi.tanh, (-0.0,), -0.0), (gi.tanh, (INF,), 1.0),
    (gi.tanh, (-INF,), -1.0), (gi.tanh, (NAN,), NAN), (gi.tanh, (-TINY,), -TINY),
    (gi.tan, (0.0,), 0.0), (gi.tan, (-0.0,), -0.0), (gi.tan, (TINY,), TINY),
    *((f, (x,), NAN) for f in (gi.sin, gi.cos, gi.tan) for x in (INF, -INF, NAN)),
    (gi.sqrt, (-1.0,), NAN), (gi.sqrt, (-0.0,), -0.0),
    # C99, F.9.4.4.
    (gi.pow, (0.0, -3.0), INF), (gi.pow, (-0.0, -3.0), -INF), (gi.pow, (-0.0, -2.0), INF),
    (gi.pow, (-0.0, -0.5), INF), (gi.pow, (-0.0, 3.0), -0.0), (gi.pow, (-0.0, 2.0), 0.0),
    (gi.pow, (-0.0, 0.5), 0.0), (gi.pow, (0.0, 3.0), 0.0), (gi.pow, (-1.0, INF), 1.0),
    (gi.pow, (-1.0, -INF), 1.0), (gi.pow, (1.0, NAN), 1.0), (gi.pow, (1.0, INF), 1.0),
    *((gi.pow, (x, zero), 1.0) for x in (0.0, -0.0, NAN, INF, -2.0) for zero in (0.0, -0.0)),
    (gi.pow, (-2.0, 0.5), NAN), (gi.pow, (-2.0, 3.0), -8.0), (gi.pow, (-2.0, -2.0), 0.25),
    (gi.pow, (0.5, -INF), INF), (gi.pow, (-2.0, -INF), 0.0), (gi.pow, (-0.5, INF), 0.0),
    (gi.pow, (2.0, INF), INF), (gi.pow, (-INF, -3.0), -0.0), (gi.pow, (-INF, -2.0), 0.0),
    (gi.pow, (-INF, 3.0), -INF), (gi.pow, (-INF, 2.0), INF), (gi.pow, (-INF, 0.5), INF),
    (gi.pow, (INF, -0.5), 0.0), (gi.pow, (INF, 0.5), INF), (gi.pow, (NAN, 1.0), NAN),
    (gi.pow, (2.0, NAN), NAN), (gi.pow, (-1.0, 2.0**53 - 1.0), -1.0),
    (gi.pow, (-1.0, 2.0**52 + 0.0), 1.0), (gi.pow, (-1.0, 2.0**53), 1.0), (gi.pow, (2.0, 1024.0), INF),
    (gi.pow, (-2.0, 1025.0), -INF), (gi.pow, (-2.0, -1075.0), -0.0), (gi.pow, (2.0, -1074.0), TINY),
    (gi.pow, (0.0, 5e-324), 0.0), (gi.pow, (-1.0, 2.0**52 - 0.5), NAN), (gi.pow, (10.0, 308.0), 1e308),
    # C99, F.9.1.4.
    (gi.atan2, (0.0, 0.0), 0.0), (gi.atan2, (-0.0, 0.0), -0.0), (gi.atan2, (0.0, -0.0), math.pi),
    (gi.atan2, (-0.0, -0.0), -math.pi), (gi.atan2, (0.0, -1.0), math.pi),
    (gi.atan2, (-0.0, -1.0), -math.pi), (gi.atan2, (1.0, 0.0), math.pi / 2),
    (gi.atan2, (-1.0, -0.0), -math.pi / 2), (gi.atan2, (1.0, -INF), math.pi),
    (gi.atan2, (-1.0, -INF), -math.pi), (gi.atan2, (1.0, INF), 0.0), (gi.atan2, (-1.0, INF), -0.0),
    (gi.atan2, (INF, 5.0), math.pi / 2), (gi.atan2, (-INF, -5.0), -math.pi / 2),
    (gi.atan2, (INF, INF), math.pi / 4), (gi.atan2, (INF, -INF), 3 * math.pi / 4),
    (gi.atan2, (-INF, INF), -math.pi / 4), (gi.atan2, (-INF, -INF), -3 * math.pi / 4),
    (gi.atan2, (NAN, 1.0), NAN), (gi.atan2, (1.0, NAN), NAN), (gi.atan2, (NAN, INF), NAN),
    (gi.atan2, (INF, NAN), NAN), (gi.atan2, (TINY, LARGEST), 0.0), (gi.atan2, (TINY, 1.0), TINY),
    (gi.atan2, (1.0, 1.0), math.pi / 4), (gi.atan2, (TINY, TINY), math.pi / 4),
    (gi.atan2, (LARGEST, LARGEST), math.pi / 4), (gi.atan2, (TINY, -LARGEST), math.pi),
]  # fmt: skip


@pytest.mark.parametrize(("function", "numbers", "expected"), SPECIAL)
def test_special_values(
    function: Callable[..., float], numbers: tuple[float, ...], expected: float
) -> None:
    """Of one number and of lanes, zeros with their signs; silently."""
    for found in (function(*numbers), function(*(Lanes([x, x]) for x in numbers))[1]):
        if math.isnan(expected):
            assert math.isnan(found)
        else:
            assert found == expected
            assert math.copysign(1.0, found) == math.copysign(1.0, expected)


@pytest.mark.parametrize("function", [gi.sin, gi.cos, gi.tan])
def test_beyond_they_are_the_library(function: Callable[..., float]) -> None:
    far = np.array([np.nextafter(FAR, np.inf), 1e22, -1e300])
    expected = [getattr(math, function.__name__)(x) for x in far]
    np.testing.assert_array_equal(function(Lanes(far)), expected)
    assert [function(float(x)) for x in far] == expected
    mixed = function(Lanes([0.5, 1e22, np.inf, 0.5]))
    assert mixed[0] == mixed[3] == function(0.5)
    assert mixed[1] == getattr(math, function.__name__)(1e22)
    assert np.isnan(mixed[2])


@given(st.floats(-FAR, FAR), finite)
def test_symmetry_and_signs(x: float, y: float) -> None:
    for odd in (gi.sin, gi.tan, gi.tanh):
        assert odd(-x) == -odd(x)
    assert gi.cos(-x) == gi.cos(x)
    for most_one in (gi.sin, gi.cos, gi.tanh):
        assert abs(most_one(x)) <= 1.0
    assert gi.atan2(-y, x) == -gi.atan2(y, x)
    assert abs(gi.atan2(y, x)) <= math.pi


def test_at_zero_and_next_to_it() -> None:
    assert math.copysign(1.0, gi.sin(0.0)) == 1.0
    assert math.copysign(1.0, gi.sin(-0.0)) == -1.0
    assert gi.cos(0.0) == gi.cos(-0.0) == 1.0
    for tiny in (5e-324, 1e-310, 2.0**-1022, 1e-160, 1e-9):
        assert gi.sin(tiny) == gi.tan(tiny) == gi.tanh(tiny) == gi.atan2(tiny, 1.0) == tiny
        assert gi.cos(tiny) == 1.0
        assert gi.exp(tiny) == 1.0 + tiny


# --- derivatives ----------------------------------------------------------------------------------

SLOPES = {  # where, and what the derivatives by the numbers are, in 60 digits
    gi.sqrt: (1e-300, 0.3, 7.0, 1e300),
    gi.exp: (-700.0, -1e-9, 0.3, 700.0),
    gi.log: (1e-300, 0.3, 1.0, 1e300),
    gi.tanh: (-30.0, -12.0, 1e-9, 0.3, 5.0, 300.0),
    gi.sin: (1e-9, 0.3, 1.5, 100.0),
    gi.cos: (1e-9, 0.3, 1.5, 100.0),
    gi.tan: (1e-9, 0.3, 1.5, 100.0),
    gi.pow: ((0.3, 2.5), (7.0, -0.5), (1e-180, 1.6), (1e200, 1.5), (2.0, 0.0), (1e-3, 2.0)),
    gi.atan2: ((0.3, 0.2), (-2.0, 1e-3), (1e-200, -2e-200), (3e200, -1e200), (1e-9, -1.0)),
}


def tangents(*numbers: float) -> list[Tangent]:
    """Numbers, each with a direction of its own."""
    return [
        Tangent(np.float64(x), row) for x, row in zip(numbers, np.eye(len(numbers)), strict=True)
    ]


@pytest.mark.parametrize(
    ("function", "at"), [(f, at) for f, places in SLOPES.items() for at in places]
)
def test_derivatives(function: Callable[..., float], at: float | tuple[float, ...]) -> None:
    """To some roundings, as far as there are numbers for them; the value is that of plain numbers."""
    numbers = at if isinstance(at, tuple) else (at,)
    found = function(*tangents(*numbers))
    assert found.value == function(*numbers)
    with mpmath.workdps(400):
        given = [mpmath.mpf(x) for x in numbers]
        for k, slope in enumerate(found.slopes):
            h = mpmath.mpf(10) ** -40 * abs(given[k]) or mpmath.mpf(10) ** -40
            ends = [exact(function)(*given[:k], given[k] + s, *given[k + 1 :]) for s in (h, -h)]
            true = (ends[0] - ends[1]) / (2 * h)
            assert abs(mpmath.mpf(slope) - true) <= 3e-15 * abs(true) + TINY
    if len(numbers) == 2:  # a constant has none
        for k in (0, 1):
            mixed = [x.value if i == k else x for i, x in enumerate(tangents(*numbers))]
            assert function(*mixed).slopes[1 - k] == found.slopes[1 - k]


@pytest.mark.parametrize("function", SLOPES)
def test_second_derivatives(function: Callable[..., float]) -> None:
    """Numbers nest: second derivatives are those of 60 digits, and symmetric."""
    count = function.__code__.co_argcount
    numbers = (0.7, 1.9)[:count]

    def nested(i: int, j: int) -> float:
        made = []
        for k, x in enumerate(numbers):
            inner = Tangent(np.float64(x), np.array([float(k == j)]))
            outer = np.empty(1, dtype=object)
            outer[0] = Tangent(np.float64(k == i), np.zeros(1))
            made.append(Tangent(inner, outer))
        return float(function(*made).slopes[0].slopes[0])

    with mpmath.workdps(80):
        for i in range(count):
            for j in range(count):
                orders = tuple((k == i) + (k == j) for k in range(count))
                true = mpmath.diff(exact(function), numbers, orders)
                assert nested(i, j) == pytest.approx(float(true), rel=1e-14)


def test_derivatives_at_borders() -> None:
    """Where there is one it is right; where there is none it is no number, and a run says so."""
    for function, x, exponent, slope in (
        (gi.pow, 0.0, (1.0,), 1.0),
        (gi.pow, 0.0, (0.0,), 0.0),
        (gi.pow, 0.0, (0.5,), INF),
        (gi.pow, -3.0, (3.0,), 27.0),
        (gi.pow, -3.0, (-1.0,), pytest.approx(-1.0 / 9.0)),
        (gi.tanh, 0.0, (), 1.0),
        (gi.exp, -800.0, (), 0.0),
    ):
        with np.errstate(all="ignore"):
            assert function(tangents(x)[0], *exponent).slopes[0] == slope
    with np.errstate(all="ignore"):
        assert gi.pow(*tangents(0.0, 2.0)).slopes.tolist() == [0.0, 0.0]
        assert np.isnan(gi.atan2(*tangents(0.0, 0.0)).slopes).all()
        assert np.isnan(gi.pow(*tangents(-2.0, 3.0)).slopes[1])
