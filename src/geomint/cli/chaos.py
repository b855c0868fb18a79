"""``geomint chaos``."""

from pathlib import Path
from typing import Any

import click

from . import options
from .meanwhile import import_meanwhile


@click.command("chaos")
@options.scene_choice
@options.end_options
@click.option("--count", type=click.IntRange(min=1), help="Number of exponents; default: all.")
@options.folder_option("chaos", "chaos.html, chaos.csv, chaos.json, chaos.png and chaos.svg")
@options.paper_option
@options.quiet_option
@options.debug_option
def command(
    scene: str, count: int | None, out: Path, paper: bool, quiet: bool, **changes: Any
) -> int:
    """Compute Lyapunov exponents of a scene and test whether its motion is chaotic.

    By default the run ends where the drift report of the scene ends.
    """
    from ..errors import StepError
    from ..plan import plan_chaos
    from ..report import CHAOS_FILES
    from ..run.exponents import Lyapunov
    from ..run.files.outputs import check_folder

    chosen = options.chosen_scene(scene, drift=True, **changes)
    plan = plan_chaos(chosen, count)
    options.print_notes(chosen)
    check_folder(out, CHAOS_FILES)
    try:
        import_meanwhile("chaos_page", at_once=True)
        found = plan.run(not quiet)
    except StepError as error:
        if not isinstance(error.partial, Lyapunov) or not len(error.partial.t):
            raise
        options.print_failure(error)
        found = error.partial

    from ..report.chaos_page import chaos_lines, chaos_record, write_chaos_report

    page = write_chaos_report(plan, found, out, options.reproducing_command(), paper)
    if not quiet:
        for line in chaos_lines(chosen.title, chaos_record(plan, found, None)):
            options.print_line(line)
        options.say_report(f"report{options.partly(found.status)}", page, paper)
    return options.exit_code(found.status)
