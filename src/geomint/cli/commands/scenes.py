"""List the built-in scenes."""

import click

WIDE = 100  # columns


@click.command("scenes")
def command() -> None:
    """List the built-in scenes; a wide terminal also shows their systems."""
    from rich.console import Console
    from rich.table import Column

    from ...errors import printable
    from ...reports.columns import fitted
    from ...scene.load import builtin_scenes, parse, read_text

    console = Console()
    wide = console.width >= WIDE  # else titles would be columns of single words
    columns = [Column("scene", no_wrap=True), Column("title"), Column("system", no_wrap=True)]
    columns = [*(columns if wide else columns[:2]), Column("method", no_wrap=True)]
    rows = []
    for name, file in builtin_scenes().items():
        try:
            content = parse(name, read_text(file))
            system = printable(content.get("system", {}).get("name", ""))
            method = printable(content.get("integrate", {}).get("method", "gauss-8"))
            title = printable(content.get("title", ""))
        except Exception as error:  # a file that is broken must not take the others with it
            system, method, title = "", "", printable(f"broken: {error}")
        rows.append((printable(name), title, *([system] if wide else []), method))
    console.print(fitted(console, columns, rows, ["method", "title"], pad_edge=wide))
