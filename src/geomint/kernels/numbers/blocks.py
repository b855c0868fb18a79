"""Blocks: the arrays that fields read and write, one number or one lane value a row.

A *block* has ``len(y)`` rows; ``y[i]``, i ≥ 0, is a number (float64) or a lane value (eight of
them), ``y[i] = v`` stores one. Compiled code sees a pointer and a row count
(`geomint.kernels.numbers.typing_blocks`); this module is the object that Python code holds, which
is also all that an uncompiled run needs.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
import numpy.typing as npt

from .lanes import LANES, Lanes

_FLOAT64 = np.dtype(np.float64)

REST = -1  # any negative number of rows of the last part of a layout: all that are left


class Block:
    """Rows of float64 numbers (or, uncompiled, of any number type).

    Parameters
    ----------
    data : numpy.ndarray, shape (rows,)
        Shared, not copied. For compiled code it must be a C-contiguous float64 array.
    """

    __slots__ = ("_known", "data")
    row_shape: tuple[int, ...] = ()  # of the data of a row

    def __init__(self, data: npt.NDArray[Any]) -> None:
        self.data = data
        self._known: tuple[Any, int] = (None, 0)  # data, and where they begin

    @property
    def address(self) -> int:
        """Where the numbers begin in memory, for compiled code.

        Raises
        ------
        TypeError
            If they are not what compiled code takes them for.
        """
        data = self.data
        known, where = self._known
        if known is data:
            return where
        if (
            data.dtype != _FLOAT64
            or data.shape[1:] != self.row_shape
            or not data.flags.c_contiguous
        ):
            raise TypeError(
                f"compiled code needs contiguous float64 numbers in rows of shape {self.row_shape}, "
                f"got {data.dtype} of shape {data.shape}"
            )
        try:  # in a quarter of the time
            where = ctypes.addressof(ctypes.c_char.from_buffer(data))  # type: ignore[arg-type]
        except (TypeError, ValueError):  # nothing, or read-only
            where = data.__array_interface__["data"][0]
        self._known = data, where
        return where

    def __len__(self) -> int:
        return len(self.data)

    def __getitem__(self, row: int):
        return self.data[_counted(row)]

    def __setitem__(self, row: int, value) -> None:
        self.data[_counted(row)] = value

    def part(self, start: int, rows: int) -> Block:
        """Return `rows` rows from `start` on, sharing memory."""
        if not 0 <= start <= start + rows <= len(self.data):
            raise IndexError(f"rows {start}..{start + rows} of a block of {len(self.data)}")
        return type(self)(self.data[start : start + rows])

    def as_lanes(self, start: int, rows: int) -> LaneBlock:
        """Return ``rows * LANES`` numbers from `start` on as `rows` lane values."""
        return LaneBlock(self.part(start, rows * LANES).data.reshape(rows, LANES))


class LaneBlock(Block):
    """Rows of lane values: `data` has shape (rows, LANES).

    Uncompiled, any number of lanes and any dtype will do.
    """

    __slots__ = ()
    row_shape = (LANES,)

    def __getitem__(self, row: int):
        return Lanes(self.data[_counted(row)])

    def as_singles(self) -> Block:
        """Return the numbers, lane after lane and row after row, sharing memory."""
        return Block(self.data.reshape(-1))

    def set_lane(self, row: int, index: int, value) -> None:
        """Store one of the numbers of a row."""
        self.data[_counted(row), index] = value


def _counted(row: int) -> int:
    """Return a row's number; a negative one is refused here as everywhere, not counted from the end."""
    if row < 0:
        raise IndexError(f"row {row} of a block: rows are counted from 0")
    return row


def as_singles(block) -> Any:
    """Return the memory of a block of eight numbers a row as a block of single ones."""
    return block.as_singles()


def as_numbers(block: Block) -> Block:
    """Return the float64 numbers that a block of any numbers is made of, sharing memory."""
    return Block(block.data.reshape(-1))


def set_lane(block, row: int, index: int, value) -> None:
    """Store one of the eight numbers of a row."""
    block.set_lane(row, index, value)


def scalar_block(size: int) -> Block:
    """Return a block of `size` zeros, aligned so that lane values in it load fast."""
    raw: Any = np.zeros(size + LANES)
    begin = ctypes.addressof(ctypes.c_char.from_buffer(raw))
    skip = (-begin // 8) % LANES
    block = Block(raw[skip : skip + size])
    block._known = block.data, begin + 8 * skip
    return block


def part(block: Block, start: int, rows: int) -> Block:
    """Return rows ``start … start + rows − 1`` of a block, sharing memory."""
    return block.part(start, rows)


def section(block: Block, layout, name: str) -> Block:
    """Return a part of a block by its name, sharing memory.

    Parameters
    ----------
    layout : named tuple of int
        The parts of the whole block in their order, and how many rows each has.
    name : str
        A constant: compiled code knows where the part lies, as far as it knows the layout.

    Raises
    ------
    IndexError
        If the layout is of another number of rows than the block has. Compiled code does not look.
    """
    if layout[-1] >= 0 and sum(layout) != len(block):
        raise IndexError(f"{layout} of a block of {len(block)} rows")
    at = layout._fields.index(name)
    first, rows = sum(layout[:at]), layout[at]
    return block.part(first, len(block) - first if rows < 0 else rows)


def sections(block: Block, layout):
    """Return all parts of a block, each as `section` gives it: a named tuple like the layout."""
    return type(layout)(*(section(block, layout, name) for name in layout._fields))


def packed(layout, /, **values) -> Block:
    """Return a block of the numbers given for each part of a layout.

    A last part of `REST` rows has as many as there are numbers for it.

    Raises
    ------
    ValueError
        If a part is missing, unknown, or of another length. Padding is 0.
    """
    if "padding" in layout._fields:
        values["padding"] = np.zeros(layout.padding)
    parts = {name: np.ravel(np.asarray(x, dtype=np.float64)) for name, x in values.items()}
    last = layout._fields[-1]
    if layout[-1] < 0 and last in parts:
        layout = layout._replace(**{last: len(parts[last])})
    if {name: len(numbers) for name, numbers in parts.items()} != layout._asdict():
        raise ValueError(f"{layout} filled with {[(name, len(x)) for name, x in parts.items()]}")
    block = scalar_block(sum(layout))
    block.data[:] = np.concatenate([parts[name] for name in layout._fields])
    return block


def as_lanes(block: Block, start: int, rows: int) -> LaneBlock:
    """Return ``8 * rows`` numbers of a scalar block as `rows` lane values, sharing memory."""
    return block.as_lanes(start, rows)


def fixed_rows(block, rows: int):
    """Return the block; compiled, its row count becomes a constant, and loops over it unroll."""
    return block


def filled_block(*parts) -> Block:
    """Return a block of all the numbers given, one after the other."""
    numbers = np.concatenate([np.ravel(np.asarray(p, dtype=np.float64)) for p in parts])
    block = scalar_block(len(numbers))
    block.data[:] = numbers
    return block
