"""``geomint audit``."""

from __future__ import annotations

from pathlib import Path

import click

import geomint as gi
from geomint.cli.options import (
    exit_code,
    paper_option,
    print_message,
    reproducing_command,
    say_report,
)

__all__ = ["audit"]

DIMENSIONS = "2,3,4,5,6,7"


def _dimensions(text: str) -> tuple[int, ...]:
    try:
        values = sorted({int(part) for part in text.split(",")})
    except ValueError:
        values = []
    if not values or values[0] < 2 or values[-1] > 7:
        raise gi.DomainError("--n", text, "dimensions between 2 and 7, with commas between")
    return tuple(values)


@click.command("audit")
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    help="Write audit.html, audit.csv, audit.json, audit.png and audit.svg to this folder.",
)
@paper_option
@click.option(
    "--n",
    "dimensions",
    metavar="N,N,…",
    default=DIMENSIONS,
    show_default=True,
    help="Dimensions n.",
)
@click.option(
    "--points",
    type=click.IntRange(min=1),
    default=20,
    show_default=True,
    help="Least number of random points for each statement, over all dimensions.",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Random seed of the points.",
)
@click.option(
    "--markdown",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write the table of the docs page to this file.",
)
@click.option(
    "--list",
    "listed",
    type=click.Choice(["findings", "all"]),
    help="Also print the statements that do not hold as printed, or all of them.",
)
@click.option("--quiet", is_flag=True, help="Print no progress and no table.")
@click.option("--debug", is_flag=True, hidden=True, expose_value=False)
def audit(
    out: Path | None,
    paper: bool,
    dimensions: str,
    points: int,
    seed: int,
    markdown: Path | None,
    listed: str | None,
    quiet: bool,
) -> int:
    """Check the formulas of Jovanović's paper at random points.

    The exit code is 1 if a statement holds neither as printed nor as corrected.
    """
    chosen = _dimensions(dimensions)
    if listed is not None and quiet:
        raise gi.DomainError("--list", listed, "no --quiet beside it, which prints no table at all")
    if paper and out is None:
        raise gi.DomainError("--paper", paper, "--out, the folder of what is for a paper")
    if out is not None:
        from .report import AUDIT_FILES

        gi.check_folder(out, AUDIT_FILES)
    if markdown is not None:
        gi.check_file(markdown)

    from rich.console import Console
    from rich.progress import Progress

    from geomint.reports.files import write
    from geomint.reports.terminal import show

    from .report import audit_report, markdown as table
    from .run import audit as evaluate_all

    screen = Console(stderr=True)
    with Progress(console=screen, transient=True, disable=quiet or not screen.is_terminal) as bar:
        task = bar.add_task("claims", total=None)
        found = evaluate_all(
            chosen,
            points,
            seed,
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )
    report = audit_report(found, reproducing_command(), listed)
    if not quiet:
        show(report)
    if out is not None:
        say_report("report", write(report, out, paper), report.stem if paper else "")
    if markdown is not None:
        with gi.whole_file(markdown) as unfinished:
            unfinished.write_text(table(found), encoding="utf-8")
        click.echo(f"table: {markdown}")
    for line in report.failures:
        print_message(line)
    return exit_code(report.outcome or report.status)
