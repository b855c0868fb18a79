"""``geomint drift``."""

from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

import click

from . import options
from .meanwhile import import_meanwhile


@click.command("drift")
@options.scene_options
@options.methods_option
@options.folder_option("report", "report.html, drift.json, drift.png and drift.svg")
@options.paper_option
@options.yes_option
@options.quiet_option
def command(
    scene: str,
    methods: list[str] | None,
    out: Path,
    paper: bool,
    yes: bool,
    quiet: bool,
    **changes: Any,
) -> int:
    """Integrate a scene for a long time and report the drift of its invariants.

    If --methods or the [drift] section of the scene lists several methods, one report shows them all.
    Each method integrates the representation that suits it.
    """
    from ..kernels.compiling.beside import compiled_beside
    from ..plan import Plan, common_notes, expected_plans, expected_time, run_methods
    from ..plan.several import warming
    from ..report import DRIFT_FILES
    from ..run.files.outputs import check_folder

    chosen = options.chosen_scene(scene, drift=True, **changes)
    names = options.methods_of(chosen, methods, changes)
    plans = [p for p in expected_plans(chosen, names).values() if isinstance(p, Plan)]
    options.print_notes(chosen, common_notes(plans))
    options.check_time(lambda: expected_time(plans), yes)
    check_folder(out, DRIFT_FILES)
    import_meanwhile("drift_page")
    several = len(plans) > 1
    with compiled_beside(partial(warming, plans)) if several else nullcontext():
        result = run_methods(chosen, names, not quiet, options.tell_failure)

    from ..report.drift_page import write_drift_report

    page = write_drift_report(result, out, options.reproducing_command(), paper)
    if not quiet:
        from ..report.summary import print_runs

        print_runs(result)
        options.say_report(f"report{options.partly(result.status)}", page, paper)
    return options.exit_code(result.status)
