"""Layouts: named parts of blocks follow one another, cover the block, and mean the same compiled."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import SCALAR
from geomint.kernels.numbers.blocks import Block, sections

Three = namedtuple("Three", "head matrix rest")
Padded = namedtuple("Padded", "y padding stages")


@gi.helper
def three(n, rest):
    return Three(2, n * n, rest)


@pytest.mark.parametrize("layout", [Three(2, 9, 4), Three(2, 0, 0), Padded(3, 5, 8)])
def test_parts_cover_the_block_once(layout: Any) -> None:
    block = Block(np.arange(float(sum(layout))))
    parts = [gi.section(block, layout, part).data for part in layout._fields]
    assert np.concatenate(parts).tolist() == block.data.tolist()
    assert [len(part) for part in parts] == list(layout)
    assert [part.data.tolist() for part in sections(block, layout)] == [x.tolist() for x in parts]
    for size in (sum(layout) - 1, sum(layout) + 1):
        with pytest.raises(IndexError):
            gi.section(Block(np.zeros(size)), layout, layout._fields[0])


@gi.helper
def parts_of(block, n):
    rest = gi.part(block, 2 + n * n, len(block) - 2 - n * n)
    return gi.part(block, 0, 2), gi.part(block, 2, n * n), rest


# How parts are made, and what they are called then. The last use of a view is no dead code; numba looks
# for that where it inlines.
WAYS = {
    "by name": (
        "layout = three(n, gi.REST)",
        *(f'gi.section(block, layout, "{name}")' for name in Three._fields),
    ),
    "unpacked": (
        "head, matrix, rest = sections(block, three(n, gi.REST))",
        *("head", "matrix", "rest"),
    ),
    "named": (
        "parts = sections(block, three(n, gi.REST))",
        *("parts.head", "parts.matrix", "parts.rest"),
    ),
    "returned": ("head, matrix, rest = parts_of(block, n)", "head", "matrix", "rest"),
    "gathered": ("every = (*parts_of(block, n), block)", "every[0]", "every[1]", "every[2]"),
}


@pytest.mark.parametrize("way", WAYS)
def test_compiled_parts_lie_where_python_finds_them(way: str) -> None:
    from numba.core import types

    made, head, matrix, rest = WAYS[way]
    space = {**globals()}
    exec(
        f"""def write(block, n, row):
    {made}
    for i in range(len({matrix})):
        {matrix}[i] = 1.0 + i
    for i in range(len({rest})):
        {rest}[i] = -1.0 * len({rest})
    {head}[row] = gi.sqrt(49.0)
""",
        space,
    )
    write = gi.helper(space["write"])
    entry = compile_function(write, types.void(SCALAR.block, types.int64, types.int64))
    for n, rows in ((0, 0), (0, 4), (1, 0), (3, 4)):
        for call in (write, entry):
            block = Block(np.zeros(2 + n * n + rows))
            call(block, n, 1)
            assert block.data.tolist() == [0.0, 7.0, *range(1, n * n + 1), *[-float(rows)] * rows]


def test_packing() -> None:
    """Every part is taken in its length, the last one as long as it is; padding is 0."""
    layout = three(2, 1)
    packed = gi.packed(layout, rest=9, matrix=[[1, 2], [3, 4]], head=(5, 6)).data
    assert packed.tolist() == [5.0, 6.0, 1.0, 2.0, 3.0, 4.0, 9.0]
    for tail in ([], [7], [7, 8]):
        block = gi.packed(three(1, gi.REST), head=(5, 6), matrix=4, rest=tail)
        assert block.data.tolist() == [5, 6, 4, *tail]
    padded = gi.packed(Padded(1, 7, 2), y=1, stages=(2, 3)).data
    assert padded.tolist() == [1.0, *[0.0] * 7, 2.0, 3.0]
    assert padded.ctypes.data % 64 == 0  # lane values in it load fast
    good = {"rest": 9, "matrix": [1, 2, 3, 4], "head": (5, 6)}
    for wrong in ({"rest": [1, 2]}, {"rest": []}, {"tail": 0}, {"head": 5}):
        with pytest.raises(ValueError, match="filled with"):
            gi.packed(layout, **{**good, **wrong})
    for missing in good:
        with pytest.raises(ValueError, match="filled with"):
            gi.packed(layout, **{k: x for k, x in good.items() if k != missing})
