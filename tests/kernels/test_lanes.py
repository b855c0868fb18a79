"""Every operator and function of numbers: compiled = lanes = plain Python, bit for bit."""

from __future__ import annotations

import functools
import itertools
import math
import sys
from collections.abc import Collection
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import LANE, SCALAR
from geomint.kernels.numbers.arithmetic import epsilon, lane, like, total
from geomint.kernels.numbers.blocks import Block, LaneBlock
from geomint.kernels.numbers.lanes import Lanes

pytestmark = pytest.mark.nojit

LANES = 8
SPECIAL = np.array(
    [0.0, 1.0, 3.0, 0.1, 5e-324, 1e-310, 2.0**-1022, 1e-160, 1e160, 1.7976931348623157e308]
)
SPECIAL = np.concatenate([SPECIAL, -SPECIAL, [np.inf, -np.inf, np.nan]])


def numbers(count: int, seed: int) -> np.ndarray:
    """Numbers of all sizes."""
    rng = np.random.default_rng(seed)
    size = np.where(rng.random(count) < 0.5, 1.0, 10.0 ** rng.uniform(-300, 300, count))
    return rng.standard_normal(count) * size


def pairs() -> tuple[np.ndarray, np.ndarray]:
    """All pairs of special numbers, and random ones; as many as fill lanes."""
    x, y = map(list, zip(*itertools.product(SPECIAL, SPECIAL), strict=True))
    count = -len(x) % LANES + 10 * LANES
    return np.append(x, numbers(count, 1)), np.append(y, numbers(count, 2))


X, Y = pairs()
Z = np.roll(X, 7)


def assert_same_bits(found: np.ndarray, expected: np.ndarray) -> None:
    """Equality of bits, zeros with their signs; any NaN is like any other."""
    found, expected = np.asarray(found).ravel(), np.asarray(expected).ravel()
    same = (found.view(np.int64) == expected.view(np.int64)) | (
        np.isnan(found) & np.isnan(expected)
    )
    assert same.all(), (np.flatnonzero(~same)[:5], found[~same][:5], expected[~same][:5])


def sweep(names: Collection[str]) -> Any:
    """Apply operations of three numbers to the rows of three blocks, one after the other.

    Each would take a fifth of a second to compile alone.
    """
    space = {f"f{k}": gi.helper(OPERATIONS[name]) for k, name in enumerate(names)}
    space["__name__"] = __name__
    lines = [f"out[{k} * n + i] = f{k}(x[i], y[i], z[i])" for k in range(len(names))]
    head = f"def rows(x, y, z, out):\n    n = len(out) // {len(names)}\n    for i in range(n):\n"
    exec(head + "".join(f"        {line}\n" for line in lines), space)
    return gi.helper(space["rows"])


def run(function: Any, *arrays: np.ndarray, lanes: str, results: int = 1) -> list[np.ndarray]:
    """Results of plain and of compiled code, for arguments whose kinds `lanes` tells.

    ``lanes`` holds an L for each argument in lanes, S for a scalar one. The function writes so many
    results for every row, one after the other.
    """
    from numba.core import types

    kinds = [LANE if letter == "L" else SCALAR for letter in lanes]
    rows = max(len(a) for a in arrays) // (LANES if "L" in lanes else 1)
    target = LANE if "L" in lanes else SCALAR
    signature = types.void(*(kind.block for kind in kinds), target.block)
    found = []
    for entry in (function, compile_function(function, signature)):
        blocks = [
            LaneBlock(a.reshape(-1, LANES).copy()) if kind is LANE else Block(a[:rows].copy())
            for a, kind in zip(arrays, kinds, strict=True)
        ]
        size = results * rows
        out = LaneBlock(np.zeros((size, LANES))) if target is LANE else Block(np.zeros(size))
        with np.errstate(all="ignore"):
            entry(*blocks, out)
        found.append(out.data.ravel())
    return found


@gi.helper
def in_place(x, y, z):
    w = x
    w += y
    w *= z
    w -= y
    w /= z
    return w


OPERATIONS = {
    "+": lambda x, y, z: x + y,
    "-": lambda x, y, z: x - y,
    "*": lambda x, y, z: x * y,
    "/": lambda x, y, z: x / y,
    "in place": lambda x, y, z: in_place(x, y, z),
    "contraction": lambda x, y, z: x * y + z,
    "negative": lambda x, y, z: -x,
    "positive": lambda x, y, z: +x,
    "abs": lambda x, y, z: abs(x),
    "sqrt": lambda x, y, z: gi.sqrt(x),
    "sin": lambda x, y, z: gi.sin(x),
    "cos": lambda x, y, z: gi.cos(x),
    "tan": lambda x, y, z: gi.tan(x),
    "atan2": lambda x, y, z: gi.atan2(x, y),
    "exp": lambda x, y, z: gi.exp(x),
    "log": lambda x, y, z: gi.log(x),
    "pow": lambda x, y, z: gi.pow(x, y),
    "tanh": lambda x, y, z: gi.tanh(x),
    "integer arguments": lambda x, y, z: gi.pow(x, 3) * gi.pow(2, y) + gi.atan2(1, x) + gi.exp(1),
    "fma": lambda x, y, z: gi.fma(x, y, z),
    "maximum": lambda x, y, z: gi.maximum(x, y),
    "<": lambda x, y, z: gi.select(x < y, x, z),
    "<=": lambda x, y, z: gi.select(x <= y, x, z),
    ">": lambda x, y, z: gi.select(x > y, x, z),
    ">=": lambda x, y, z: gi.select(x >= y, x, z),
    "==": lambda x, y, z: gi.select(x == y, x, z),
    "!=": lambda x, y, z: gi.select(x != y, x, z),
    "and": lambda x, y, z: gi.select((x > y) & (x > z), x, y),
    "or": lambda x, y, z: gi.select((x > y) | (x > z), x, y),
    "select constants": lambda x, y, z: gi.select(x < y, 1.0, 2),
    "select mixed": lambda x, y, z: gi.select(x < y, 0.5, z),
    "integers": lambda x, y, z: 2 * x - 1 + (x / 3 - 7) * 5,
    "integers on the left": lambda x, y, z: 1 - x + 3 / x,
    "like": lambda x, y, z: x * like(0.3, y) + like(z, x) + like(2, x),
}
MIXED = ("+", "-", "*", "/", "fma", "maximum", "<", "select mixed", "pow", "atan2")


@functools.cache
def plain_and_compiled(kinds: str) -> dict[str, list[np.ndarray]]:
    """Results of all operations that are tried on arguments of those kinds."""
    names = OPERATIONS if len(set(kinds)) == 1 else MIXED
    rows = len(X) // LANES
    arrays = [
        values[:rows] if letter == "S" and "L" in kinds else values
        for values, letter in zip((X, Y, Z), kinds, strict=True)
    ]
    found = run(sweep(names), *arrays, lanes=kinds, results=len(names))
    parts = zip(*(np.split(one, len(names)) for one in found), strict=True)
    return dict(zip(names, map(list, parts), strict=True))


@pytest.mark.parametrize("name", OPERATIONS)
def test_operation(name: str) -> None:
    """Scalars and lanes, compiled and plain, agree in every bit."""
    expected, compiled = plain_and_compiled("SSS")[name]
    assert_same_bits(compiled, expected)
    for found in plain_and_compiled("LLL")[name]:
        assert_same_bits(found, expected)


@pytest.mark.parametrize("kinds", ["LSL", "SLS", pytest.param("LSS", marks=pytest.mark.nightly)])
@pytest.mark.parametrize("name", MIXED)
def test_scalars_mix_with_lanes(name: str, kinds: str) -> None:
    """A scalar on either side counts for every lane."""
    rows = len(X) // LANES
    spread = [
        np.repeat(values[:rows], LANES) if letter == "S" else values
        for values, letter in zip((X, Y, Z), kinds, strict=True)
    ]
    operation = OPERATIONS[name]
    with np.errstate(all="ignore"):
        wanted = np.array([operation(*row) for row in zip(*spread, strict=True)])
    for found in plain_and_compiled(kinds)[name]:
        assert_same_bits(found, wanted)


@gi.helper
def aliases(x, y, z, out):
    for i in range(len(out)):
        kept = x[i]
        moved = kept
        moved += y[i]
        moved *= 3.0
        moved -= z[i]
        moved /= 7.0
        out[i] = kept
        out[i] += 0.0
        y[i] *= 2.0


@pytest.mark.parametrize("kinds", ["SSS", "LLL"])
def test_in_place_operators_make_new_values(kinds: str) -> None:
    """After ``b = a``, ``b += 1`` leaves a alone, and the block it came from."""
    for found in run(aliases, X, Y, Z, lanes=kinds):
        assert_same_bits(found, X + 0.0)


@gi.helper
def folds(x, out):
    n = len(out) // 10
    for i in range(n):
        for k in range(8):
            out[k * n + i] = lane(x[i], k) + 0.0 * x[i]
        out[8 * n + i] = gi.top(x[i]) + 0.0 * x[i]
        out[9 * n + i] = total(x[i]) + 0.0 * x[i]


def test_folds() -> None:
    """Reductions of lanes are done in a fixed order; the largest is NaN wherever one stands."""
    table = numbers(64 * LANES, 3).reshape(-1, LANES)
    table[:4] = np.tile([0.0, -0.0], 4)
    s = table[:, :4] + table[:, 4:]
    s = s[:, :2] + s[:, 2:]
    expected = [*table.T, table.max(axis=1), s[:, 0] + s[:, 1]]
    plain, compiled = run(folds, table.ravel(), lanes="L", results=10)
    assert_same_bits(compiled, plain)
    np.testing.assert_array_equal(plain.reshape(10, -1, LANES)[:, :, 0], expected)
    for place in range(LANES):
        values = np.arange(1.0, 1.0 + LANES)
        values[place] = np.nan
        for found in run(folds, values, lanes="L", results=10):
            assert np.isnan(found.reshape(10, LANES)[8]).all()


def test_nan_is_the_maximum() -> None:
    """On either side, for every kind of number."""
    for x, y in ((1.0, math.nan), (math.nan, 1.0), (math.nan, math.nan)):
        assert math.isnan(gi.maximum(np.float64(x), np.float64(y)))
        assert np.isnan(gi.maximum(Lanes([x, 1.0]), Lanes([y, 2.0]))[0])


def test_functions_of_plain_numbers() -> None:
    """Floats, integers and extended precision."""
    from mpmath import mp

    assert gi.sqrt(4) == 2.0
    assert math.isnan(gi.sqrt(-1.0))
    assert math.isnan(gi.sin(math.inf))
    third = np.longdouble(1) / 3
    assert gi.log(0.0) == -math.inf
    assert math.isnan(gi.log(-1.0))
    assert gi.log(math.inf) == math.inf
    for function in (gi.sqrt, gi.sin, gi.cos, gi.tan, gi.atan2, gi.exp, gi.log, gi.pow, gi.tanh):
        count = function.__code__.co_argcount
        thirds = [third] * count
        value = function(*thirds)
        assert value.dtype == np.longdouble
        assert function(*(Lanes([x, x]) for x in thirds))[1] == value
        with mp.workdps(40):
            exact = [mp.mpf(1) / 3] * count
            digits = getattr(mp, function.__name__, mp.power)(*exact)
            assert function(*exact) == digits
            assert function(*(Lanes(np.array([x], dtype=object)) for x in exact))[0] == digits
            assert function(exact[0], *(0.25 for _ in exact[1:])).context is mp
    with mp.workdps(40):
        x = mp.mpf(1) / 3
        lanes = gi.sin(Lanes(np.array([x, 2 * x], dtype=object)))
        assert lanes[0] == mp.sin(x)
        assert gi.sqrt(x) == mp.sqrt(x)
        assert gi.fma(x, x, x) == x * x + x
        assert gi.top(Lanes(np.array([x, 2 * x, x], dtype=object))) == 2 * x
    assert total(Lanes([1.0, 2.0, 4.0])) == 7.0
    assert epsilon(np.float64(1)) == 2.0**-52
    assert epsilon(third) == np.finfo(np.longdouble).eps
    assert epsilon(Lanes([1.0])) == 2.0**-52
    assert like(2, third).dtype == np.longdouble
    assert like(2, 0.5) == 2
    assert lane(3.5, 6) == 3.5


def test_fma_without_a_library(monkeypatch: pytest.MonkeyPatch) -> None:
    """The exact fractions give the same bits."""
    with np.errstate(all="ignore"):
        expected = gi.fma(Lanes(X), Lanes(Y), Lanes(Z))
        monkeypatch.setattr(sys.modules[gi.fma.__module__], "_libm_fma", None)
        assert_same_bits(gi.fma(Lanes(X), Lanes(Y), Lanes(Z)), expected)
