"""``geomint scan``."""

from pathlib import Path
from typing import Any

import click

from . import options
from .meanwhile import import_meanwhile


def _pairs(context: click.Context, option: click.Parameter, given: tuple[str, ...]) -> Any:
    pairs = dict(text.partition("=")[::2] for text in given)
    bad = [text for text in given if "=" not in text]
    if bad or len(pairs) < len(given):
        raise click.BadParameter(f"{bad or list(given)}: expected KEY=A:B:N, each key once")
    return pairs or None


@click.command("scan")
@options.scene_choice
@options.end_options
@click.option(
    "--vary",
    multiple=True,
    metavar="KEY=A:B:N",
    callback=_pairs,
    help="N values from A to B of a number of [system] or [initial], such as D or gamma[2]; "
    "A:B:N:log, or numbers with commas between. Twice for a map.",
)
@click.option(
    "--draws", type=click.IntRange(min=1), help="Random states, by the invariant measure."
)
@options.list_option(
    "--keep", metavar="LIST", help="Quantities that draws have as the scene's state has."
)
@click.option("--temperature", type=float, help="Draws have the weight exp(−energy/temperature).")
@click.option("--seed", type=click.IntRange(min=0), help="Of the draws.")
@options.list_option(
    "--show",
    metavar="LIST",
    help="What is read off: final:NAME, drift:NAME, lowest:, highest:, mean:, digits:, frequency:, "
    "exponent (with its error, and whether it is above 0).",
)
@click.option("--workers", type=click.IntRange(min=1), help="Threads; else as many as cores.")
@options.folder_option("scan", "scan.html, scan.csv, scan.json, scan.png and scan.svg")
@options.paper_option
@options.quiet_option
@options.debug_option
def command(
    scene: str, workers: int | None, out: Path, paper: bool, quiet: bool, **keys: Any
) -> int:
    """Integrate a scene with many values of its numbers, or from many states, and chart the outcome.

    The end is the scene's own, unless another one is given.
    """
    from ..plan import plan_scan
    from ..report import SCAN_FILES
    from ..run.files.outputs import check_folder

    chosen = options.chosen_scene(scene, **options.taken(keys, "t_end", "tau_end"))
    plan = plan_scan(chosen, **keys)
    options.print_notes(chosen, plan.notes)
    check_folder(out, SCAN_FILES)
    import_meanwhile("scan_page", at_once=True)
    many = plan.run(not quiet, workers)

    from ..report.scan_page import scan_lines, scan_record, scan_status, write_scan_report

    page = write_scan_report(plan, many, out, options.reproducing_command(), paper)
    if many.errors:
        number, error = next(iter(sorted(many.errors.items())))
        options.print_message(
            f"{len(many.errors)} of {len(many)} members failed; {number}: {error}"
        )
    status = scan_status(many)
    if not quiet:
        for line in scan_lines(scan_record(plan, many, None)):
            options.print_line(line)
        options.say_report(f"report{options.partly(status)}", page, paper)
    return options.exit_code(status)
