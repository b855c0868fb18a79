"""``geomint drift``."""

from __future__ import annotations

from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

import click

from .meanwhile import import_meanwhile
from .options import (
    check_time,
    chosen_scene,
    exit_code,
    folder_option,
    methods_of,
    methods_option,
    paper_option,
    partly,
    print_notes,
    reproducing_command,
    say_report,
    scene_options,
    tell_failure,
    yes_option,
)

__all__ = ["command"]


@click.command("drift")
@scene_options
@methods_option
@folder_option("report", "report.html, drift.json, drift.png and drift.svg")
@paper_option
@yes_option
@click.option("--quiet", is_flag=True, help="No progress, no summary.")
def command(
    scene: str,
    methods: list[str] | None,
    out: Path,
    paper: bool,
    yes: bool,
    quiet: bool,
    **changes: Any,
) -> int:
    """Integrate a scene for long and report how its invariants drift.

    With --methods, or methods in the scene's [drift] section, each method runs in the
    representation that suits it, and one report shows them all.
    """
    from ..kernels.compiling.beside import compiled_beside
    from ..plan import Plan, common_notes, expected_plans, expected_time, run_methods
    from ..plan.warm import warming
    from ..report import DRIFT_FILES
    from ..run.files.outputs import check_folder

    chosen = chosen_scene(scene, drift=True, **changes)
    names = methods_of(chosen, methods, changes)
    plans = [p for p in expected_plans(chosen, names).values() if isinstance(p, Plan)]
    print_notes(chosen, common_notes(plans))
    check_time(lambda: expected_time(plans), yes)
    check_folder(out, DRIFT_FILES)
    import_meanwhile("drift_page")
    several = len(plans) > 1
    with compiled_beside(partial(warming, plans)) if several else nullcontext():
        result = run_methods(chosen, names, not quiet, tell_failure)

    from ..report.drift_page import write_drift_report

    page = write_drift_report(result, out, reproducing_command(), paper)
    if not quiet:
        from ..report.summary import print_runs

        print_runs(result)
        say_report(f"report{partly(result.status)}", page, paper)
    return exit_code(result.status)
