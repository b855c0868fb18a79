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
    help="Vary a number of [system] or [initial], such as D or gamma[2], with N values from A to B. "
    "Or write A:B:N:log, or values separated by commas. Give --vary twice for a map.",
)
@click.option(
    "--draws", type=click.IntRange(min=1), help="Random states to draw from the invariant measure."
)
@options.list_option(
    "--keep", metavar="LIST", help="Give random states the scene's values of these quantities."
)
@click.option("--temperature", type=float, help="Weight random states by exp(−energy/temperature).")
@click.option("--seed", type=click.IntRange(min=0), help="Random seed of the states.")
@options.list_option(
    "--show",
    metavar="LIST",
    help="Results to plot: final:NAME, drift:NAME, lowest:NAME, highest:NAME, mean:NAME, digits:NAME, "
    "frequency:NAME, exponent (the largest Lyapunov exponent, with its error).",
)
@click.option("--workers", type=click.IntRange(min=1), help="Threads to use; default: all cores.")
@options.folder_option("scan", "scan.html, scan.csv, scan.json, scan.png and scan.svg")
@options.paper_option
@options.quiet_option
@options.debug_option
def command(
    scene: str, workers: int | None, out: Path, paper: bool, quiet: bool, **keys: Any
) -> int:
    """Integrate a scene for many parameter values or initial states and plot the results.

    By default all runs end at the end time of the scene.
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
