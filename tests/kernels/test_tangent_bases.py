"""Compiled tangent numbers of double-double numbers, and of tangent numbers: second derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from test_tangent import MOST, most_operations

import geomint as gi
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import EXTENDED, NumberType, tangent, tangent_lanes
from geomint.kernels.compiling.recorded import helper
from geomint.kernels.compiling.signatures import BLOCK, GIVEN, takes
from geomint.kernels.numbers import arithmetic as ar
from geomint.kernels.numbers.blocks import Block, scalar_block
from geomint.kernels.numbers.tangent import Tangent, tangent_block

DIGITS = 2.0**-95  # relative, of double-double numbers
OUTER = 2  # directions beside each number


@dataclass(frozen=True)
class Base:
    """What values and slopes are: its type, and how its numbers lie in memory."""

    kind: NumberType
    shape: tuple[int, ...]  # of one of them
    single: bool = False  # whether memory's numbers are meant, where others are eight of them

    @property
    def of_tangents(self) -> NumberType:
        """Return the type of their tangent numbers."""

        def load() -> tuple[Any, Any, Any]:
            from geomint.kernels.numbers.typing_blocks import BlockType
            from geomint.kernels.numbers.typing_tangent import TangentType

            base = self.kind.memory.row if self.single else self.kind.number
            number = TangentType(base, base, OUTER)
            block = BlockType(number, held=tangent_block((1 + OUTER) * self.width - 1))
            return number, block, block

        return NumberType(f"TANGENT_OVER_{self.kind.name}", load, True)

    @property
    def width(self) -> int:
        """Return float64 numbers in one of them."""
        return int(np.prod(self.shape))


INNER = 3  # directions of inner numbers, where they are not in lanes
DOUBLE = {"one": Base(EXTENDED, (2,), True), "eight": Base(EXTENDED, (2, 8))}
NESTED = {
    "one": Base(tangent_lanes(INNER), (1 + INNER,), True),
    "eight": Base(tangent_lanes(INNER), (1 + INNER, 8)),
    "directions in lanes": Base(tangent(8), (9,)),
}


def called(function, base: Base, given, rows: int, params=(), work: int = 0):
    """Return what compiled code makes of numbers, in the shape (rows, 1 + OUTER, of a number)."""
    kind = base.of_tangents
    signature = takes(params=GIVEN, y=BLOCK, out=BLOCK, work=BLOCK).of(kind)
    held = kind.block.held
    y, out, scratch = (
        held(scalar_block(n * (1 + OUTER) * base.width).data) for n in (len(given), rows, work)
    )
    y.data[:] = given.ravel()
    compile_function(function, signature)(Block(np.array(params, float)), y, out, scratch)
    return out.data.reshape(rows, 1 + OUTER, *base.shape)


@helper
def operations(params, y, out, work):
    most_operations(y, out)
    out[MOST] = params[0] * y[0]


COUNT = MOST + 1


@helper
def with_logarithm(params, y, out, work):
    """Double-double numbers have none."""
    operations(params, y, out, work)
    out[COUNT] = ar.log(y[0] * y[0] + 1.0)


def field_of(problem):
    """Return the field as a function without a time."""
    f = problem.field

    @helper
    def field(params, y, out, work):
        f(params, ar.like(0.0, y[0]), y, out, work)

    return field


SCENES = ["ball-3d", "hamiltonized-n3", "veselova-classical"]


def digits(pair):
    """Return double-double numbers (…, hi and lo) as mpmath numbers."""
    return np.vectorize(lambda hi, lo: mp.mpf(hi) + mp.mpf(lo), otypes=[object])(*pair)


def tangents(values, slopes):
    """Return numbers of any kind with their slopes."""
    return [Tangent(v, s) for v, s in zip(values, slopes, strict=True)]


def uncompiled(function, given, rows: int, params=(), work: int = 0):
    """Return what plain Python makes of tangent numbers of any kind."""
    y, out, scratch = (Block(np.empty(n, dtype=object)) for n in (len(given), rows, work))
    for i, number in enumerate(given):
        y[i] = number
    function.function(Block(np.array(params, float)), y, out, scratch)
    return out.data


def double_doubles(rng, rows: int, base: Base):
    """Return random numbers as memory has them: a value and slopes each, to 32 digits."""
    given = rng.normal(size=(rows, 1 + OUTER, *base.shape))
    given[:, :, 1] *= 2.0**-54 * np.abs(given[:, :, 0])
    return given


def check_digits(found, truth) -> None:
    """Hold double-double numbers to mpmath ones; slopes to the largest of a number's."""
    for row, number in zip(found, truth, strict=True):
        parts = [number.value, *number.slopes] if isinstance(number, Tangent) else [number, 0, 0]
        size = 1 + max(abs(p) for p in parts)
        for part, right in zip(row, parts, strict=True):
            assert abs(part - right) <= DIGITS * size


@pytest.fixture(autouse=True)
def _precision():
    with mp.workdps(60):
        yield


@pytest.mark.parametrize("count", DOUBLE)
def test_operations_of_double_doubles(count: str) -> None:
    """To 2⁻⁹⁵ of those of mpmath numbers, each lane for itself."""
    base, rng = DOUBLE[count], np.random.default_rng(7)
    given = double_doubles(rng, 2, base)
    found = called(operations, base, given, COUNT, [0.7])
    for lane in range(8 if count == "eight" else 1):
        at = (..., lane) if count == "eight" else (...,)
        numbers = digits(np.moveaxis(given[at], 2, 0))
        truth = uncompiled(operations, tangents(numbers[:, 0], numbers[:, 1:]), COUNT, [0.7])
        check_digits(digits(np.moveaxis(found[at], 2, 0)), truth)


def nested(given):
    """Return tangent numbers of tangent numbers."""
    return [
        Tangent(
            Tangent(row[0, 0], row[0, 1:]),
            np.array([*tangents(row[1:, 0], row[1:, 1:]), None], dtype=object)[:-1],
        )
        for row in given
    ]


def flat(number):
    """Return the numbers of a tangent number of tangent numbers, or of a plain one."""
    if not isinstance(number, Tangent):
        return flat(Tangent(number, np.zeros(OUTER)))
    each = [number.value, *number.slopes]
    return [[n.value, *n.slopes] if isinstance(n, Tangent) else [n, 0.0] for n in each]


@pytest.mark.parametrize("count", NESTED)
def test_operations_of_tangents(count: str) -> None:
    """To the bits of plain Python."""
    base, rng = NESTED[count], np.random.default_rng(8)
    given = rng.normal(size=(2, 1 + OUTER, *base.shape))
    found = called(with_logarithm, base, given, COUNT + 1, [0.7])
    for lane in range(8 if count == "eight" else 1):
        at = (..., lane) if count == "eight" else (...,)
        truth = uncompiled(with_logarithm, nested(given[at]), COUNT + 1, [0.7])
        for row, number in zip(found[at], truth, strict=True):
            for part, right in zip(row, flat(number), strict=True):
                np.testing.assert_array_equal(part[: len(right)], right)


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_fields(name: str) -> None:
    """Of every base: double-double ones as mpmath's, nested ones to the bits of plain Python."""
    problem, rng = gi.load_scene(name).problem, np.random.default_rng(9)
    field, rows = field_of(problem), problem.rows
    y0 = problem.random_state(1)
    more = rows, problem.params, problem.work
    base = DOUBLE["one"]
    given = double_doubles(rng, rows, base)
    given[:, 0, 0], given[:, 0, 1] = y0, 0.0
    numbers = digits(np.moveaxis(given, 2, 0))
    truth = uncompiled(field, tangents(numbers[:, 0], numbers[:, 1:]), *more)
    check_digits(digits(np.moveaxis(called(field, base, given, *more), 2, 0)), truth)
    base = NESTED["one"]
    given = rng.normal(size=(rows, 1 + OUTER, *base.shape))
    given[:, 0, 0] = y0
    found = called(field, base, given, *more)
    for row, number in zip(found, uncompiled(field, nested(given), *more), strict=True):
        np.testing.assert_array_equal(row, flat(number))
