"""``geomint scenes``."""

from __future__ import annotations

import click

__all__ = ["command"]

WIDE = 100  # columns


@click.command("scenes")
def command() -> None:
    """List the built-in scenes; on a wide terminal with their systems."""
    from rich.console import Console
    from rich.table import Table

    from ..errors import printable
    from ..scene.load import builtin_scenes, parse

    console = Console()
    wide = console.width >= WIDE  # else titles would be columns of single words
    columns = ["scene", "title", *(["system"] if wide else []), "method"]
    table = Table(*columns, box=None, header_style="bold", pad_edge=wide)
    for column in table.columns[:1] + table.columns[2:]:
        column.no_wrap = True
    for name, file in builtin_scenes().items():
        content = parse(name, file.read_text(encoding="utf-8"))
        system = content.get("system", {}).get("name", "")
        method = content.get("integrate", {}).get("method", "gauss-8")
        table.add_row(
            name, printable(content.get("title", "")), *([system] if wide else []), method
        )
    console.print(table)
