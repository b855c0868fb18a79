"""``geomint scenes``."""

from __future__ import annotations

import click

__all__ = ["command"]


@click.command("scenes")
def command() -> None:
    """List the built-in scenes."""
    from rich.console import Console
    from rich.table import Table

    from ..scene.load import builtin_scenes, parse

    table = Table("scene", "title", "system", "method", box=None, header_style="bold")
    for name, file in builtin_scenes().items():
        content = parse(name, file.read_text(encoding="utf-8"))
        system = content.get("system", {}).get("name", "")
        method = content.get("integrate", {}).get("method", "gauss-8")
        table.add_row(name, content.get("title", ""), system, method)
    Console().print(table)
