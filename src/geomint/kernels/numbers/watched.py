"""Blocks that watch what a function does to them, in plain Python.

Compiled code checks no row number, and its blocks hold what was left in them. These refuse what it
would do silently: a row outside of the block, from the end (negative) too; a row that is read before it
is written; a row written that belongs to others. Parts of them watch as well.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from .blocks import Block


class AccessError(Exception):
    """A row that a function may not read or write.

    Attributes
    ----------
    name, index, size
        The block, the row (of the whole block, where a part was addressed), and how many there are.
    """

    def __init__(self, what: str, name: str, index, size: int) -> None:
        super().__init__(what)
        self.name, self.index, self.size = name, index, size


class Given(Block):
    """Rows that are only read."""

    __slots__ = ("first", "name", "size")

    def __init__(self, name: str, data: npt.NDArray[Any], first: int = 0, size: int = -1) -> None:
        self.data, self.name, self.first = data, name, first
        self.size = len(data) if size < 0 else size

    def __getitem__(self, row: int):
        self._check("reads", row)
        return self.data[row]

    def __setitem__(self, row: int, value) -> None:
        self._check("writes", row)
        raise self._error(
            f"writes row {row + self.first} of {self.name}, which is not its own", row
        )

    def __iter__(self):
        raise self._misused(f"takes {self.name} apart: rows are {self.name}[i], i in range(…)")

    def __array__(self, *args, **options):
        raise self._misused(f"hands {self.name} to numpy: write a loop over its rows")

    def part(self, start: int, rows: int) -> Block:
        """Return rows that share memory with these, and watch for the same block."""
        if not 0 <= start <= start + rows <= len(self.data):
            end = start + rows - 1
            what = f"takes rows {self.first + start} … {self.first + end} of {self.name}, which has"
            raise self._error(f"{what} {self.count}", min(start, end) if start < 0 else end)
        return self._piece(slice(start, start + rows), self.first + start)

    def _piece(self, rows: slice, first: int) -> Block:
        return Given(self.name, self.data[rows], first, self.size)

    @property
    def count(self) -> str:
        """How many rows the whole block has, in words."""
        plural = "" if self.size == 1 else "s"
        return f"{self.size} row{plural}, counted from 0" if self.size else "no rows"

    def _check(self, verb: str, row) -> None:
        if isinstance(row, slice):
            one = f"{self.name}[i] one by one; a part is gi.part({self.name}, start, rows)"
            raise self._misused(f"{verb} a slice of {self.name}: rows are {one}")
        if not isinstance(row, int | np.integer):
            raise self._misused(f"{verb} {self.name}[{row!r}]: rows are counted by whole numbers")
        if not 0 <= row < len(self.data):
            raise self._outside(verb, row)

    def _misused(self, what: str) -> AccessError:
        return AccessError(what, self.name, None, self.size)

    def _outside(self, verb: str, row) -> AccessError:
        at = row + self.first
        what = f"{verb} row {at} of {self.name}, which has {self.count}"
        if 0 <= at < self.size:  # inside of the block, but outside of the part that was taken
            last = self.first + len(self.data) - 1
            what = f"{verb} row {at} of {self.name} through a part of rows {self.first} … {last}"
        return self._error(what, row)

    def _error(self, what: str, row) -> AccessError:
        return AccessError(what, self.name, row + self.first, self.size)


class Fresh(Given):
    """Rows that are NaN until they are written, and not read before."""

    __slots__ = ("written",)

    def __init__(self, name: str, size: int) -> None:
        super().__init__(name, np.full(size, np.nan))
        self.written = memoryview(bytearray(size))

    def __getitem__(self, row: int):
        self._check("reads", row)
        if not self.written[row]:
            at = row + self.first
            raise self._error(f"reads row {at} of {self.name} before it is written", row)
        return self.data[row]

    def __setitem__(self, row: int, value) -> None:
        self._check("writes", row)
        try:
            self.data[row] = [] if value is None else value  # of None numpy makes NaN
        except (TypeError, ValueError):
            what = f"writes {value!r} to row {row + self.first} of {self.name}, which is no number"
            raise self._error(what, row) from None
        self.written[row] = 1

    def _piece(self, rows: slice, first: int) -> Block:
        piece = Fresh.__new__(Fresh)
        Given.__init__(piece, self.name, self.data[rows], first, self.size)
        piece.written = self.written[rows]
        return piece

    @property
    def unwritten(self) -> int | None:
        """The first row that nothing was written to, by functions that do not watch either."""
        rows = enumerate(zip(self.written, np.isnan(self.data), strict=True))
        return next((row for row, (written, blank) in rows if blank and not written), None)
