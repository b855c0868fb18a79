"""Tangent numbers against differences in many digits, and against what each operation should give."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, strategies as st

import geomint as gi
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import tangent, tangent_lanes
from geomint.kernels.numbers.arithmetic import epsilon, lane, like
from geomint.kernels.numbers.blocks import Block, as_lanes
from geomint.kernels.numbers.lanes import Lanes
from geomint.kernels.numbers.tangent import Tangent

fma, maximum, pow, select = gi.fma, gi.maximum, gi.pow, gi.select


@gi.helper
def in_place(x, y):
    z = 1.5 * x
    z += x
    z *= y
    z -= 1
    z /= x
    return z


OPERATIONS: dict[str, Callable[[Any, Any], Any]] = {
    "add": lambda x, y: x + y,
    "add a number": lambda x, y: 2.5 + x + 1,
    "subtract": lambda x, y: x - y,
    "from a number": lambda x, y: 2.5 - x - 1,
    "multiply": lambda x, y: x * y,
    "by a number": lambda x, y: 3.0 * x * 2,
    "divide": lambda x, y: x / y,
    "into a number": lambda x, y: 2.0 / x,
    "by number": lambda x, y: x / 3.0,
    "in place": lambda x, y: in_place(x, y),
    "negative": lambda x, y: -x + +y,
    "size": lambda x, y: abs(x) + abs(-y),
    "fma": lambda x, y: fma(x, y, x),
    "fma of numbers": lambda x, y: fma(x, 3.0, y) + fma(2.0, y, 1.0) + fma(2.0, 3.0, y),
    "sqrt": lambda x, y: gi.sqrt(x * x + y * y),
    "sin": lambda x, y: gi.sin(x * y),
    "cos": lambda x, y: gi.cos(x - y),
    "tan": lambda x, y: gi.tan(x * y),
    "atan2": lambda x, y: gi.atan2(x, y) * x,
    "atan2 of a number": lambda x, y: gi.atan2(2.0, y) + gi.atan2(x, -0.5),
    "exp": lambda x, y: gi.exp(x * y),
    "log": lambda x, y: gi.log(x * x + 0.5),
    "pow": lambda x, y: pow(x * x, y),
    "pow of a number": lambda x, y: pow(x, 3) + pow(2, y),
    "tanh": lambda x, y: gi.tanh(x + y) * y,
    "larger": lambda x, y: maximum(x, y) * x + maximum(x, 0.5),
    "select": lambda x, y: select(x < y, x * x, y),
    "select a number": lambda x, y: select(x < y, 1.0, y) * x + select(x >= 0.0, 1.0, y),
    "like": lambda x, y: like(2.0, x) * x,
}
MOST, COUNT = len(OPERATIONS), len(OPERATIONS) + 1


def exact(f: Any, x: float, y: float, directions: np.ndarray) -> tuple[Any, list[Any]]:
    """Return the value and its derivatives, from differences in 60 digits."""
    h = mp.mpf(10) ** -25

    def at(s: Any, u: Any) -> Any:
        return f(mp.mpf(x) + s * mp.mpf(u[0]), mp.mpf(y) + s * mp.mpf(u[1]))

    return at(mp.mpf(0), (0, 0)), [(at(h, u) - at(-h, u)) / (2 * h) for u in directions]


@given(st.integers(0, 10**6))
def test_operations(seed: int) -> None:
    """Of float64, of lanes, of mpmath numbers."""
    rng = np.random.default_rng(seed)
    (x, y), u = rng.normal(size=2), rng.normal(size=(4, 2))
    for name, f in OPERATIONS.items():
        with mp.workdps(60):
            value, slopes = exact(f, x, y, u)
            digits = [np.array([mp.mpf(a) for a in u[:, i]]) for i in range(2)]
            many = f(Tangent(mp.mpf(x), digits[0]), Tangent(mp.mpf(y), digits[1]))
            for found, s in zip(many.slopes, slopes, strict=True):
                assert abs(found - s) <= mp.mpf(10) ** -30 * (1 + abs(s)), name
        found = f(Tangent(np.float64(x), u[:, 0]), Tangent(np.float64(y), u[:, 1]))
        near = {"rtol": 1e-11, "atol": 1e-13, "err_msg": name}
        np.testing.assert_allclose(float(found.value), float(value), **near)
        np.testing.assert_allclose(found.slopes, [float(s) for s in slopes], **near)
        eight = [Lanes(np.full(8, v)) for v in (x, y)]
        lanes = f(*(Tangent(v, np.repeat(u[:, i : i + 1], 8, 1)) for i, v in enumerate(eight)))
        np.testing.assert_array_equal(lanes.slopes, np.repeat(found.slopes[:, None], 8, 1), name)


def swept() -> Any:
    """Write the results of all operations, and one that looks at all lanes."""
    space = {f"f{k}": gi.helper(f) for k, f in enumerate(OPERATIONS.values())}
    lines = [f"    out[{k}] = f{k}(y[0], y[1])\n" for k in range(MOST)]
    exec("def all_operations(y, out):\n" + "".join(lines), space)
    operations = gi.helper(space["all_operations"])

    @gi.helper
    def all_operations(y, out):
        operations(y, out)
        out[MOST] = gi.top(y[0]) * epsilon(y[0]) * y[1]

    return all_operations


all_operations = swept()


@gi.helper
def all_in_lanes(y, out):
    all_operations(as_lanes(y, 0, 2), as_lanes(out, 0, COUNT))
    eight, results = as_lanes(y, 0, 2), as_lanes(out, 8 * COUNT, 3)
    results[0] = eight[0] * lane(eight[1], 3) + y[2]
    results[1] = fma(0.0 * gi.top(eight[0]) + lane(eight[0], 5), eight[1], y[1])
    results[2] = select(eight[0] < eight[1], eight[0], eight[1])


def compiled(function: Any, block: Any, *sizes: int) -> list[Any]:
    """Run a function on blocks of random numbers, and of zeros; return the blocks."""
    from numba.core import types

    made = [block.held(np.zeros(size * block.held.width)) for size in sizes]
    made[0].data[:] = np.random.default_rng(5).normal(size=len(made[0].data))
    compile_function(function, types.void(block, block))(*made)
    return made


@pytest.mark.parametrize("directions", [8, pytest.param(16, marks=pytest.mark.nightly)])
def test_compiled_numbers(directions: int) -> None:
    """To the bits of plain Python; the values are those of plain numbers."""
    y, out = compiled(all_operations, tangent(directions).block, 2, COUNT)
    again, plain = type(out)(np.zeros(len(out.data))), Block(np.zeros(COUNT))
    all_operations.function(y, again)
    np.testing.assert_array_equal(out.data, again.data)
    rows = out.data.reshape(COUNT, -1)
    assert (rows[:, 0] != 0).all()
    assert (np.abs(rows[:, 1:]).max(axis=1) > 0).all()
    all_operations.function(Block(y.data[:: 1 + directions].copy()), plain)
    np.testing.assert_array_equal(plain.data, rows[:, 0])


def test_what_python_holds_follows_from_the_rows() -> None:
    """Whichever of the types of equal blocks numba has made first, and still keeps."""
    inner = tangent(64).memory.of_rows(4)
    assert [type(inner)(inner.row).held.width, tangent(64).memory.held.width] == [65, 65]


@pytest.mark.parametrize("directions", [1, pytest.param(8, marks=pytest.mark.nightly)])
def test_compiled_lanes(directions: int) -> None:
    """Lane by lane what single numbers give."""
    y, out = compiled(all_in_lanes, tangent_lanes(directions).memory, 16, 8 * (COUNT + 3))
    width = 1 + directions
    found = out.data.reshape(COUNT + 3, width, 8)
    given = y.data.reshape(2, width, 8)
    for k in range(8):
        one, expected = type(y)(given[:, :, k].ravel()), type(y)(np.zeros(COUNT * width))
        all_operations.function(one, expected)
        np.testing.assert_array_equal(found[:MOST, :, k].ravel(), expected.data[: MOST * width])
    numbers = y.data.reshape(16, width)
    x = [Tangent(Lanes(row[0]), row[1:]) for row in given]
    third = Tangent(given[1, 0, 3], given[1, 1:, 3])
    fifth = Tangent(given[0, 0, 5], given[0, 1:, 5])
    single = [Tangent(row[0], row[1:]) for row in numbers[:3]]
    expected = (
        x[0] * third + single[2],
        fma(fifth, x[1], single[1]),
        select(x[0] < x[1], x[0], x[1]),
    )
    for row, number in zip(found[COUNT:], expected, strict=True):
        np.testing.assert_array_equal(row[0], number.value)
        np.testing.assert_array_equal(row[1:], number.slopes)
