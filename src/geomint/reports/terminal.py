"""Reports on a terminal."""

from __future__ import annotations

from rich.console import Console
from rich.table import Column, Table as Shown
from rich.text import Text

from ..errors import printable
from .columns import fitted
from .report import Cell, Report, Stack, Table

COLOURS = {
    "roundoff": "green",
    "bounded": "green",
    "ok": "green",
    "jump": "yellow",
    "sqrt": "cyan",
    "linear": "yellow",
    "faster": "red",
    "not finite": "bold red",
    **dict.fromkeys(("wrong", "untyped", "hung", "unexplained"), "bold red"),
    "undetermined": "magenta",
}


def show(report: Report, console: Console | None = None) -> None:
    """Print title, what was run, the tables, and what was found."""
    console = console or Console()

    def say(text: str, style: str = "") -> None:
        if text:
            console.print(Text(printable(text).replace("`", ""), style=style))

    say(report.title, "bold")
    say(report.summary)
    for what, text in report.alerts:
        say(f"{what} {text}", "bold red")
    for summary, table in report.tables():
        if table.told and table.rows:
            say(summary, "bold")
            console.print(_fitted(console, table))
    words = [("", report.verdict)] if isinstance(report.verdict, str) else report.verdict
    for what, found in words:
        say(f"{what} – {found}" if what else found)


def _fitted(console: Console, table: Table) -> Shown:
    columns, breaks = [], "counts" in table.kind
    for k, heading in enumerate(table.columns or [""] * max(map(len, table.rows))):
        words = k < table.words
        whole = not breaks and (not words or not k)
        columns.append(Column(str(heading), justify="left" if words else "right", no_wrap=whole))
    rows = []
    for row in table.rows:
        cells = [_text(cell) for cell in row]
        rows.append([*cells, *[Text("")] * (len(columns) - len(cells))])
    return fitted(console, columns, rows, table.spare)


def _text(cell: Cell) -> Text:
    cell = cell[0] if isinstance(cell, Stack) else cell  # what is beside it is on pages
    text = printable(str(cell)).replace("`", "")
    return Text(text, style=COLOURS.get(getattr(cell, "word", ""), ""))
