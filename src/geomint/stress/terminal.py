"""Progress of a sweep on a terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..reports.text import number
from .judge import FORBIDDEN, Cell


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


def quoted(cell: Cell) -> str:
    """Return a forbidden cell in a line."""
    where = f"{cell.method} on {cell.system}, {cell.axis} {cell.label}"
    return f"{cell.verdict}: {where}: {why(vars(cell))}"


def why(cell: Mapping[str, Any]) -> str:
    """Return what is wrong with a cell: in a record an error that is not finite is None."""
    error, allowed = cell["error"], cell["allowed"]
    off = f" off by {number(error)}, allowed {number(allowed)}" * bool(error or allowed)
    return "; ".join(filter(None, (cell["quantity"] + off, cell["message"])))
