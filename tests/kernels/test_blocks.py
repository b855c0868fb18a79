"""Blocks: rows, views of them, and what the Python and the compiled half agree on."""

from __future__ import annotations

import contextlib
import os
import sys
import weakref
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import LANE, SCALAR
from geomint.kernels.numbers.blocks import Block, LaneBlock, as_lanes, as_singles, fixed_rows

pytestmark = pytest.mark.nojit
LANES = 8


def both_ways(function: Any, *kinds: str) -> tuple[Any, Any]:
    """Return (plain, compiled) entries for blocks of the kinds S and L."""
    from numba.core import types

    blocks = [LANE.block if kind == "L" else SCALAR.block for kind in kinds]
    return function, compile_function(function, types.int64(*blocks))


@gi.helper
def lengths(y, out):
    """Write the row counts of parts and of parts of parts."""
    middle = gi.part(y, 2, 5)
    inner = gi.part(middle, 1, 3)
    nothing = gi.part(inner, 3, 0)
    out[0] = 1.0 * len(y)
    out[1] = 1.0 * len(middle)
    out[2] = 1.0 * len(inner)
    out[3] = 1.0 * len(nothing)
    for i in range(len(inner)):
        inner[i] = inner[i] + 100.0 * (i + 1)
    return len(fixed_rows(inner, 3))


@pytest.mark.parametrize("kind", "SL")
def test_parts_share_memory(kind: str) -> None:
    """A part of a part addresses the same numbers; a row of a lane block is eight of them."""
    shape, held = ((10,), Block) if kind == "S" else ((10, LANES), LaneBlock)
    for entry in both_ways(lengths, kind, "S"):
        data = np.arange(float(np.prod(shape))).reshape(shape)
        y, out = held(data.copy()), Block(np.zeros(4))
        assert entry(y, out) == 3
        np.testing.assert_array_equal(out.data, [10, 5, 3, 0])
        data[3:6] += np.array([100.0, 200.0, 300.0]).reshape(3, *[1] * (len(shape) - 1))
        np.testing.assert_array_equal(y.data, data)


def test_calls_keep_no_arrays() -> None:
    """Compiled code gives back what it was called with, also after a call that fails."""
    for entry in both_ways(lengths, "S", "S"):
        held = [Block(np.arange(10.0)), Block(np.zeros(4))]
        arrays = [weakref.ref(block.data) for block in held]
        entry(*held)  # blocks remember where their numbers lie
        before = [sys.getrefcount(block.data) for block in held]
        for _ in range(3):
            entry(*held)
        with contextlib.suppress(TypeError, IndexError):
            entry(held[0], Block(np.zeros(4, dtype=np.float32)))
        assert [sys.getrefcount(block.data) for block in held] == before
        held.clear()
        assert [array() for array in arrays] == [None, None]


@gi.helper
def through_lanes(y, out):
    """Double the lanes of rows 1 … 2 of the numbers from 3 on, and count as scalars again."""
    lanes = as_lanes(y, 3, 3)
    two = gi.part(lanes, 1, 2)
    for i in range(len(two)):
        two[i] = two[i] * 2.0
    flat = as_singles(two)
    for i in range(len(flat)):
        out[i] = flat[i]
    return len(flat)


def test_numbers_as_lanes_and_back() -> None:
    """The order is lane after lane, row after row; nothing need be aligned."""
    expected = 2.0 * np.arange(3.0 + LANES, 3.0 + 3 * LANES)
    for entry in both_ways(through_lanes, "S", "S"):
        y, out = Block(np.arange(30.0)), Block(np.zeros(2 * LANES))
        assert entry(y, out) == 2 * LANES
        np.testing.assert_array_equal(out.data, expected)
        np.testing.assert_array_equal(y.data[3 + LANES : 3 + 3 * LANES], expected)


@gi.helper
def gather(y, out):
    for i in range(len(out)):
        out[i] = y[i]
    return len(out)


def test_bad_rows_are_refused_in_python() -> None:
    """Where compiled code would read other memory, and -1 is no last row."""
    block, lanes = Block(np.arange(6.0)), LaneBlock(np.zeros((2, LANES)))
    for rows, row in ((block, -1), (block, 6), (lanes, -1), (lanes, 2)):
        with pytest.raises(IndexError):
            rows[row]
        with pytest.raises(IndexError):
            rows[row] = 1.0
    for start, count in ((-1, 2), (0, 7), (6, 1), (0, -1), (7, 0)):
        with pytest.raises(IndexError):
            gi.part(block, start, count)
    with pytest.raises(IndexError):
        as_lanes(block, 0, 1)
    assert len(gi.part(block, 6, 0)) == 0


@pytest.mark.skipif(bool(os.environ.get("NUMBA_DISABLE_JIT")), reason="nothing is compiled")
def test_only_float64_is_compiled() -> None:
    """Another dtype, a strided array or a wrong kind is refused, never reinterpreted."""
    _, entry = both_ways(gather, "S", "S")
    good = Block(np.zeros(4))
    for bad in (
        Block(np.zeros(4, dtype=np.float32)),
        Block(np.zeros(4, dtype=np.int64)),
        Block(np.zeros(8)[::2]),
        LaneBlock(np.zeros((4, LANES))),
        LaneBlock(np.zeros((4, 3))),
        Block(np.zeros((4, 1))),
        np.zeros(4),
        [0.0],
    ):
        with pytest.raises(TypeError):
            entry(bad, good)


@gi.field
def sizes(params, t, y, out, work):
    """Count all rows, by loops over them."""
    for i in range(len(out)):
        out[i] = 0.0 * t
    for i in range(len(params)):
        out[0] += params[i]
    for i in range(len(y)):
        out[1] += 1.0 + 0.0 * y[i]
    for i in range(len(work)):
        work[i] = 1.0 + 0.0 * y[0]
        out[2] += work[i]


@pytest.mark.parametrize("compiled", [True, False])
def test_functions_see_the_sizes_of_their_problem(compiled: bool) -> None:
    problem = gi.Problem("sizes", (("x", 3),), [1.0, 2.0, 4.0, 8.0], field=sizes, work=7)
    end = gi.solve(problem, np.zeros(3), t_end=1.0, step=0.5, method="rk-4", compiled=compiled)
    np.testing.assert_allclose(end.y[-1], [15.0, 3.0, 7.0], rtol=1e-15)
