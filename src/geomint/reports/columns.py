"""Tables of the terminal in which no word is broken: neither names nor numbers."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from rich.measure import Measurement
from rich.table import Column, Table

if TYPE_CHECKING:
    from rich.console import Console
    from rich.text import Text

__all__ = ["fitted"]


def fitted(
    console: Console,
    columns: Sequence[str | Column],
    rows: Collection[Sequence[str | Text]],
    spare: Sequence[str] = (),
    pad_edge: bool = True,
) -> Table:
    """Return a table in which columns are as wide as their longest word at least.

    Parameters
    ----------
    console : Console
    columns : sequence of str or Column
        Headings; columns that do not wrap are as wide as their longest line.
    rows : sequence of sequences of str or Text
    spare : sequence of str
        Headings of columns that are left out, one after the other, where there is no room for all.
    pad_edge : bool
        Whether there is a blank at both sides.
    """
    found = [column if isinstance(column, Column) else Column(column) for column in columns]
    least, most = [], []
    for i, column in enumerate(found):
        cells = [column.header, *(row[i] for row in rows)]
        sizes = [Measurement.get(console, console.options.update_width(10_000), c) for c in cells]
        most.append(max(size.maximum for size in sizes))
        least.append(most[-1] if column.no_wrap else max(size.minimum for size in sizes))
    kept, left = list(range(len(found))), list(spare)

    def room() -> int:
        """Return the width that is left for what columns contain."""
        return console.width - 2 * len(kept) + (0 if pad_edge else 2)

    while left and sum(least[i] for i in kept) > room():
        heading = left.pop(0)
        kept = [i for i in kept if found[i].header != heading]
    widths = _levelled([least[i] for i in kept], [most[i] for i in kept], room())
    headed = any(found[i].header for i in kept)
    table = Table(box=None, header_style="bold", pad_edge=pad_edge, show_header=headed)
    for i, width in zip(kept, widths, strict=True):
        column = found[i]
        options = {"justify": column.justify, "no_wrap": column.no_wrap}
        table.add_column(column.header, width=width, **options)  # type: ignore[arg-type]
    for row in rows:
        table.add_row(*(row[i] for i in kept))
    return table


def _levelled(least: list[int], most: list[int], room: int) -> list[int | None]:
    """Return widths from the least to the most, alike as far as that goes; None where all fit.

    Also where words fit as they are cut down to one level anyhow, or not at all: rich does that.
    """
    level = max(most, default=0)
    while level > 0 and sum(max(a, min(b, level)) for a, b in zip(least, most, strict=True)) > room:
        level -= 1
    needed = level > 0 and level < max(most, default=0) and any(a > level for a in least)
    pairs = zip(least, most, strict=True)
    return [max(a, min(b, level)) if needed else None for a, b in pairs]
