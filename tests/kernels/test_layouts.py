"""Layouts: named parts of blocks follow one another, cover the block, and mean the same compiled."""

from __future__ import annotations

from collections import namedtuple

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.compiling.bound import Bound
from geomint.kernels.compiling.recorded import Recorded, inlined
from geomint.kernels.compiling.signatures import BLOCK, WHOLE, takes
from geomint.kernels.numbers.blocks import Block, part, scalar_block, sections
from geomint.kernels.solve import (
    adaptive,
    commutator_free,
    compensated,
    gauss,
    lobatto,
    rattle,
    rattle_separable,
    rkmk,
    runge_kutta,
    splitting,
)
from geomint.kernels.tangent.layout import Sizes, kept_layout, work_layout

SIZES = Sizes(n=6, rows=7, m=2, d=4, at_once=4, memory_rows=20, stages=16, scratch=3)
LAYOUTS = {
    "state": compensated.compensated_state(5),
    "runge-kutta": runge_kutta.runge_kutta_coefficients(4, 8),
    "runge-kutta-work": runge_kutta.runge_kutta_work(5, 4, 3),
    "adaptive": adaptive.adaptive_coefficients(5, 40),
    "adaptive-memory": adaptive.adaptive_memory(6, 5),
    "adaptive-work": adaptive.adaptive_work(5, 3, 20),
    "cf": commutator_free.commutator_free_coefficients(3, 4, 30),
    "cf-work": commutator_free.commutator_free_work(6, 3, 4, 2, 5),
    "rkmk": rkmk.rkmk_coefficients(3, 4, 0),
    "rkmk-work": rkmk.rkmk_work(6, 3, 4, 2, 5),
    "series": rkmk.dexpinv_work(6, 4),
    "gauss": gauss.gauss_coefficients(6, 2, 3),
    "gauss-memory": gauss.gauss_memory(7, 1),
    "gauss-work": gauss.gauss_work(7, 2, 16),
    "lobatto": lobatto.lobatto_coefficients(3),
    "lobatto-memory": lobatto.lobatto_memory(3, 1, 1),
    "lobatto-work": lobatto.lobatto_work(3, 2, 4),
    "rattle": rattle.RATTLE,
    "rattle-memory": rattle.rattle_memory(3, 1, 1),
    "rattle-work": rattle.rattle_work(3, 2, 4),
    "separable-memory": rattle_separable.separable_rattle_memory(3, 2, 0),
    "separable-work": rattle_separable.separable_rattle_work(3, 2, 4),
    "splitting": splitting.SPLITTING,
    "splitting-memory": splitting.splitting_memory(4, 1),
    "splitting-work": splitting.splitting_work(4, 3),
    "directions": kept_layout(SIZES),
    "directions-work": work_layout(SIZES),
}
Three = namedtuple("Three", "head matrix rest")


@pytest.mark.parametrize("name", LAYOUTS)
def test_parts_cover_the_block_once(name: str) -> None:
    layout = LAYOUTS[name]
    block = Block(np.arange(float(sum(layout))))
    parts = [gi.section(block, layout, part).data for part in layout._fields]
    assert np.concatenate(parts).tolist() == block.data.tolist()
    assert [len(part) for part in parts] == list(layout)
    assert min(layout) >= 0


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_block_of_another_size_is_refused(name: str) -> None:
    layout = LAYOUTS[name]
    for size in (sum(layout) - 1, sum(layout) + 1):
        with pytest.raises(IndexError):
            gi.section(scalar_block(size), layout, layout._fields[0])


@pytest.mark.parametrize("rows", range(1, 20))
@pytest.mark.parametrize("groups", [1, 2])
def test_lanes_begin_at_whole_lane_values(rows: int, groups: int) -> None:
    """One across two cache lines loads twice as slowly."""
    for layout, names in (
        (gauss.gauss_coefficients(rows, groups, 3), ("c", "b", "mu", "predictors")),
        (gauss.gauss_memory(rows, groups), ("stages",)),
        (gauss.gauss_work(rows, groups, 16), ("Y", "F", "scratch")),
    ):
        for name in names:
            at = layout._fields.index(name)
            assert sum(layout[:at]) % 8 == 0
            assert layout.padding < 8


@inlined
def three(n: int, rest: int) -> Three:
    return Three(head=2, matrix=n * n, rest=rest)


@gi.helper
def write_parts(block, n, row):
    layout = three(n, gi.REST)
    matrix = gi.section(block, layout, "matrix")
    for i in range(len(matrix)):
        matrix[i] = 1.0 + i
    rest = gi.section(block, layout, "rest")
    for i in range(len(rest)):
        rest[i] = -1.0 * len(rest)
    gi.section(block, layout, "head")[row] = 7.0  # the last use of a view, which is no dead code


@gi.helper
def write_unpacked(block, n, row):
    head, matrix, rest = sections(block, three(n, gi.REST))
    for i in range(len(matrix)):
        matrix[i] = 1.0 + i
    for i in range(len(rest)):
        rest[i] = -1.0 * len(rest)
    head[row] = gi.sqrt(49.0)  # numba looks for dead code where it inlines


@gi.helper
def write_named(block, n, row):
    parts = sections(block, three(n, gi.REST))
    for i in range(len(parts.matrix)):
        parts.matrix[i] = 1.0 + i
    for i in range(len(parts.rest)):
        parts.rest[i] = -1.0 * len(parts.rest)
    parts.head[row] = gi.sqrt(49.0)


@gi.helper
def parts_of(block, n):
    return part(block, 0, 2), part(block, 2, n * n), part(block, 2 + n * n, len(block) - 2 - n * n)


@gi.helper
def write_returned(block, n, row):
    head, matrix, rest = parts_of(block, n)
    for i in range(len(matrix)):
        matrix[i] = 1.0 + i
    for i in range(len(rest)):
        rest[i] = -1.0 * len(rest)
    head[row] = gi.sqrt(49.0)


@gi.helper
def write_gathered(block, n, row):
    all_parts = (*parts_of(block, n), block)
    for i in range(len(all_parts[1])):
        all_parts[1][i] = 1.0 + i
    for i in range(len(all_parts[2])):
        all_parts[2][i] = -1.0 * len(all_parts[2])
    all_parts[0][row] = gi.sqrt(49.0)


@pytest.mark.parametrize(
    "write", [write_parts, write_unpacked, write_named, write_returned, write_gathered]
)
@pytest.mark.parametrize("n", [0, 1, 3])
@pytest.mark.parametrize("rest", [0, 4])
def test_compiled_parts_lie_where_python_finds_them(write: Recorded, n: int, rest: int) -> None:
    found = []
    for compiled in (True, False):
        block = scalar_block(2 + n * n + rest)
        Bound(write, takes(block=BLOCK, n=WHOLE, row=WHOLE)).entry(compiled)(block, n, 1)
        found.append(block.data.tolist())
    assert found[0] == found[1] == [0.0, 7.0, *range(1, n * n + 1), *[-float(rest)] * rest]


def test_packing_takes_every_part_in_its_length() -> None:
    layout = three(2, 1)
    assert gi.packed(layout, rest=9, matrix=[[1, 2], [3, 4]], head=(5, 6)).data.tolist() == [
        *(5.0, 6.0, 1.0, 2.0, 3.0, 4.0, 9.0)
    ]
    for wrong in ({"rest": [1, 2]}, {"rest": []}, {"tail": 0}, {"head": 5}):
        with pytest.raises(ValueError, match="filled with"):
            gi.packed(layout, **{"rest": 9, "matrix": [1, 2, 3, 4], "head": (5, 6), **wrong})
    with pytest.raises(ValueError, match="filled with"):
        gi.packed(layout, rest=9, head=(5, 6))


def test_packing_takes_what_is_left() -> None:
    for tail in ([], [7], [7, 8]):
        block = gi.packed(three(1, gi.REST), head=(5, 6), matrix=4, rest=tail)
        assert block.data.tolist() == [5, 6, 4, *tail]
    with pytest.raises(ValueError, match="filled with"):
        gi.packed(three(1, gi.REST), head=5, matrix=4, rest=[])


def test_padding_is_zero() -> None:
    layout = gauss.gauss_memory(1, 1)
    assert layout.padding == 6
    block = gi.packed(layout, y=1, carry=2, stages=np.ones(8))
    assert block.data.tolist() == [1.0, 2.0, *[0.0] * 6, *[1.0] * 8]
