"""Progress and summary of a sweep on a terminal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from .judge import FORBIDDEN, VERDICTS, Cell, forbidden
from .references import references_in_words, references_of

MOST = 20  # forbidden cells that the summary lists


class Watch:
    """Shows how far a sweep is, and what is forbidden as it is found; nothing unless `show`."""

    def __init__(self, show: bool) -> None:
        self._show, self._bar, self._task = show, None, None

    def __enter__(self) -> Watch:
        return self

    def __exit__(self, *error: object) -> None:
        if self._bar is not None:
            self._bar.stop()

    def begin(self, total: int) -> None:
        """Open the bar."""
        if not self._show:
            return
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeRemainingColumn,
        )

        bar: Any = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        self._bar, self._task = bar, bar.add_task("stress", total=total)
        bar.start()

    def cell_done(self, cell: Cell) -> None:
        """Show one more cell."""
        if self._bar is None:
            return
        if cell.verdict in FORBIDDEN:
            self._bar.console.print(quoted(cell), markup=False, highlight=False)
        self._bar.update(self._task, advance=1, description=f"stress: {cell.axis}")

    def summary(self, cells: Sequence[Cell]) -> None:
        """Print the number of each verdict by axis, what they rest on, and what is forbidden."""
        from rich.console import Console
        from rich.table import Column

        from ..report.columns import fitted

        console = Console()
        columns = [
            Column("axis"),
            *(Column(verdict, justify="right", no_wrap=True) for verdict in VERDICTS),
        ]
        rows = []
        for axis in dict.fromkeys(cell.axis for cell in cells):
            counts = Counter(cell.verdict for cell in cells if cell.axis == axis)
            rows.append((axis, *(str(counts[verdict] or "") for verdict in VERDICTS)))
        empty = [verdict for verdict in VERDICTS if all(c.verdict != verdict for c in cells)]
        console.print(fitted(console, columns, rows, empty))
        console.print(references_in_words(references_of(cells)), highlight=False)
        bad = forbidden(cells)
        for cell in bad[:MOST]:
            console.print(quoted(cell), markup=False, highlight=False)
        if len(bad) > MOST:
            console.print(f"… and {len(bad) - MOST} more: see the report")


def quoted(cell: Cell) -> str:
    """Return a forbidden cell in a line."""
    off = "" if cell.error is None else f" off by {cell.error:.3g}, allowed {cell.allowed or 0:.3g}"
    why = "; ".join(part for part in (f"{cell.quantity}{off}", cell.message) if part)
    return f"{cell.verdict}: {cell.method} on {cell.system}, {cell.axis} {cell.label}: {why}"
