"""Progress and summary of a sweep on a terminal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from types import TracebackType
from typing import Any

from .judge import FORBIDDEN, VERDICTS, Cell

__all__ = ["Watch"]

MOST = 20  # forbidden cells that the summary lists


class Watch:
    """Shows how far a sweep is, and what it has found; does nothing unless `show`."""

    def __init__(self, show: bool) -> None:
        self._show, self._bar, self._task = show, None, None
        self._bad = 0

    def __enter__(self) -> Watch:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
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

    def tell(self, cell: Cell) -> None:
        """Show one more cell."""
        self._bad += cell.verdict in FORBIDDEN
        if self._bar is not None:
            found = f", {self._bad} forbidden" if self._bad else ""
            self._bar.update(self._task, advance=1, description=f"stress: {cell.axis}{found}")

    def summary(self, cells: Sequence[Cell]) -> None:
        """Print the number of each verdict by axis, and what is forbidden."""
        from rich.console import Console
        from rich.table import Table

        console = Console()
        table = Table(box=None, header_style="bold")
        table.add_column("axis")
        for verdict in VERDICTS:
            table.add_column(verdict, justify="right")
        for axis in dict.fromkeys(cell.axis for cell in cells):
            counts = Counter(cell.verdict for cell in cells if cell.axis == axis)
            table.add_row(axis, *(str(counts[verdict] or "") for verdict in VERDICTS))
        console.print(table)
        bad = [cell for cell in cells if cell.verdict in FORBIDDEN]
        for cell in bad[:MOST]:
            place = f"{cell.method} on {cell.system}, {cell.axis} {cell.label}"
            console.print(f"{cell.verdict}: {place}: {cell.quantity} {cell.message}", markup=False)
        if len(bad) > MOST:
            console.print(f"… and {len(bad) - MOST} more: see the report")
