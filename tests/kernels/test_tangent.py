"""Tangent numbers against differences in many digits, and against what each operation should give."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest

import geomint as gi
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import SCALAR, tangent, tangent_lanes
from geomint.kernels.compiling.signatures import BLOCK, MEMORY, takes
from geomint.kernels.numbers import arithmetic as ar, circular, exponential
from geomint.kernels.numbers.blocks import as_lanes, scalar_block
from geomint.kernels.numbers.lanes import Lanes
from geomint.kernels.numbers.tangent import Tangent, tangent_block

OPERATIONS = {
    "add": lambda x, y: x + y,
    "add a number": lambda x, y: 2.5 + x + 1,
    "subtract": lambda x, y: x - y,
    "from a number": lambda x, y: 2.5 - x - 1,
    "multiply": lambda x, y: x * y,
    "by a number": lambda x, y: 3.0 * x * 2,
    "divide": lambda x, y: x / y,
    "into a number": lambda x, y: 2.0 / x,
    "by number": lambda x, y: x / 3.0,
    "negative": lambda x, y: -x + +y,
    "size": lambda x, y: abs(x) + abs(-y),
    "fma": lambda x, y: ar.fma(x, y, x),
    "fma of numbers": lambda x, y: ar.fma(x, 3.0, y) + ar.fma(2.0, y, 1.0) + ar.fma(2.0, 3.0, y),
    "sqrt": lambda x, y: ar.sqrt(x * x + y * y),
    "sin": lambda x, y: circular.sin(x * y),
    "cos": lambda x, y: circular.cos(x - y),
    "tan": lambda x, y: circular.tan(x * y),
    "atan2": lambda x, y: circular.atan2(x, y) * x,
    "atan2 of a number": lambda x, y: circular.atan2(2.0, y) + circular.atan2(x, -0.5),
    "exp": lambda x, y: exponential.exp(x * y),
    "log": lambda x, y: exponential.log(x * x + 0.5),
    "pow": lambda x, y: exponential.pow(x * x, y),
    "pow of a number": lambda x, y: exponential.pow(x, 3) + exponential.pow(2, y),
    "tanh": lambda x, y: exponential.tanh(x + y) * y,
    "larger": lambda x, y: ar.maximum(x, y) * x,
    "select": lambda x, y: ar.select(x < y, x * x, y),
    "select a number": lambda x, y: ar.select(x < y, 1.0, y) * x,
    "like": lambda x, y: ar.like(2.0, x) * x,
}


def test_what_a_number_carries() -> None:
    """Its value alone, and how many slopes; of plain numbers none."""
    x = Tangent(2.0, np.array([3.0, 4.0]))
    assert (ar.plain(x), ar.slope_count(x)) == (2.0, 2)
    assert (ar.plain(2.0), ar.slope_count(2.0)) == (2.0, 0)
    assert ar.magnitude(x) == 4.0


@pytest.fixture(autouse=True)
def _precision():
    with mp.workdps(60):
        yield


def exact(f, x, y, directions):
    """Return the value and its derivatives, from differences in 60 digits."""
    h = mp.mpf(10) ** -25

    def at(s, u):
        return f(mp.mpf(x) + s * mp.mpf(u[0]), mp.mpf(y) + s * mp.mpf(u[1]))

    value = at(mp.mpf(0), (0, 0))
    return value, [(at(h, u) - at(-h, u)) / (2 * h) for u in directions]


@pytest.mark.parametrize("name", OPERATIONS)
def test_operations(name: str) -> None:
    """Of float64, of lanes, of mpmath numbers, and of tangent numbers again."""
    f, rng = OPERATIONS[name], np.random.default_rng(3)
    for _ in range(5):
        x, y = rng.normal(size=2)
        u = rng.normal(size=(4, 2))
        value, slopes = exact(f, x, y, u)
        of_numbers = f(Tangent(np.float64(x), u[:, 0]), Tangent(np.float64(y), u[:, 1]))
        np.testing.assert_allclose(float(of_numbers.value), float(value), rtol=1e-12)
        np.testing.assert_allclose(of_numbers.slopes, [float(s) for s in slopes], rtol=1e-12)
        eight = [Lanes(np.full(8, v)) for v in (x, y)]
        of_lanes = f(*(Tangent(v, np.repeat(u[:, i : i + 1], 8, 1)) for i, v in enumerate(eight)))
        np.testing.assert_array_equal(of_lanes.slopes, np.repeat(of_numbers.slopes[:, None], 8, 1))
        digits = [np.array([mp.mpf(a) for a in u[:, i]]) for i in range(2)]
        of_digits = f(Tangent(mp.mpf(x), digits[0]), Tangent(mp.mpf(y), digits[1]))
        for found, s in zip(of_digits.slopes, slopes, strict=True):
            assert abs(found - s) <= mp.mpf(10) ** -30 * (1 + abs(s))


@gi.helper
def most_operations(y, out):
    x, z = y[0], y[1]
    out[0] = x + z
    out[1] = 2.5 + x + 1
    out[2] = x - z
    out[3] = 2.5 - x - 1
    out[4] = x * z
    out[5] = 3.0 * x * 2
    out[6] = x / z
    out[7] = 2.0 / x
    out[8] = x / 3.0
    out[9] = -x + +z
    out[10] = abs(x) + abs(-z)
    out[11] = ar.fma(x, z, x) + ar.fma(x, 3.0, z) + ar.fma(2.0, z, 1.0) + ar.fma(2.0, 3.0, z)
    out[12] = ar.sqrt(x * x + z * z)
    out[13] = circular.sin(x * z) + circular.cos(x - z)
    out[14] = ar.maximum(x, z) * x + ar.maximum(x, 0.5)
    out[15] = ar.select(x < z, x * x, z) + ar.select(x >= 0.0, 1.0, z)
    out[16] = ar.like(2.0, x) * x
    out[17] = 1.5
    out[17] += x
    out[17] *= z
    out[17] -= 1
    out[17] /= x
    out[18] = exponential.exp(x) * exponential.tanh(z) + exponential.pow(3.0, x)
    out[19] = exponential.pow(abs(x), z) + exponential.pow(x, 3) * circular.tan(z)
    out[20] = circular.atan2(x, z) + circular.atan2(1.0, x) + circular.atan2(z, 2)
    out[21] = exponential.log(x * x + 1.0)


MOST = 22


@gi.helper
def all_operations(y, out):
    most_operations(y, out)
    out[MOST] = ar.top(y[0]) * ar.epsilon(y[0]) * y[1]


COUNT = MOST + 1


@gi.helper
def all_in_lanes(y, out):
    all_operations(as_lanes(y, 0, 2), as_lanes(out, 0, COUNT))
    eight, results = as_lanes(y, 0, 2), as_lanes(out, 8 * COUNT, 3)
    results[0] = eight[0] * ar.lane(eight[1], 3) + y[2]
    results[1] = ar.fma(0.0 * ar.top(eight[0]) + ar.lane(eight[0], 5), eight[1], y[1])
    results[2] = ar.select(eight[0] < eight[1], eight[0], eight[1])


def blocks(kind, memory: bool, sizes):
    """Return blocks of random numbers, and of zeros."""
    held = (kind.memory if memory else kind.block).held
    made = [held(scalar_block(size * held.width).data) for size in sizes]
    made[0].data[:] = np.random.default_rng(5).normal(size=len(made[0].data))
    return made


@pytest.mark.parametrize("directions", [8, 16])
def test_compiled_numbers(directions: int) -> None:
    """To the bits of plain Python; the values are those of plain numbers."""
    kind = tangent(directions)
    entry = compile_function(all_operations, takes(y=BLOCK, out=BLOCK).of(kind))
    y, out, again = blocks(kind, False, (2, COUNT, COUNT))
    entry(y, out)
    all_operations.function(y, again)
    np.testing.assert_array_equal(out.data, again.data)
    rows = out.data.reshape(COUNT, -1)
    assert (rows[:, 0] != 0).all()
    assert (np.abs(rows[:, 1:]).max(axis=1) > 0).all()
    plain, values = scalar_block(COUNT), scalar_block(2)
    values.data[:] = y.data[:: 1 + directions]
    compile_function(all_operations, takes(y=BLOCK, out=BLOCK).of(SCALAR))(values, plain)
    np.testing.assert_array_equal(plain.data, rows[:, 0])


@pytest.mark.parametrize("directions", [1, 8])
def test_compiled_lanes(directions: int) -> None:
    """Lane by lane what single numbers give."""
    kind = tangent_lanes(directions)
    entry = compile_function(all_in_lanes, takes(y=MEMORY, out=MEMORY).of(kind))
    y, out = blocks(kind, True, (16, 8 * (COUNT + 3)))
    entry(y, out)
    width = 1 + directions
    found = out.data.reshape(COUNT + 3, width, 8)
    given = y.data.reshape(2, width, 8)
    held = tangent_block(directions)
    for lane in range(8):
        one, expected = held(given[:, :, lane].ravel()), held(np.zeros(COUNT * width))
        all_operations.function(one, expected)
        np.testing.assert_array_equal(
            found[:COUNT, :, lane][:-1], expected.data.reshape(COUNT, width)[:-1]
        )
    numbers = y.data.reshape(16, width)
    x = [Tangent(Lanes(row[0]), row[1:]) for row in given]
    third = Tangent(given[1, 0, 3], given[1, 1:, 3])
    fifth = Tangent(given[0, 0, 5], given[0, 1:, 5])
    single = [Tangent(row[0], row[1:]) for row in numbers[:3]]
    expected = (
        x[0] * third + single[2],
        ar.fma(fifth, x[1], single[1]),
        ar.select(x[0] < x[1], x[0], x[1]),
    )
    for row, number in zip(found[COUNT:], expected, strict=True):
        np.testing.assert_array_equal(row[0], number.value)
        np.testing.assert_array_equal(row[1:], number.slopes)
