"""``geomint drift``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from .options import (
    Asked,
    carried_out,
    check_time,
    chosen_scene,
    exit_code,
    folder_option,
    methods_option,
    partly,
    print_message,
    print_notes,
    reproducing_command,
    say,
    scene_options,
    several_methods,
    yes_option,
)

if TYPE_CHECKING:
    from ..plan import MethodRun
    from ..scene import Scene

__all__ = ["command"]


@click.command("drift")
@scene_options
@methods_option
@folder_option("report", "report.html, drift.json, drift.png and drift.svg")
@yes_option
@click.option("--quiet", is_flag=True, help="No progress, no summary.")
def command(
    asked: Asked,
    methods: str | None,
    out: Path,
    yes: bool,
    quiet: bool,
) -> int:
    """Integrate a scene for long and report how its invariants drift.

    With --methods, or methods in the scene's [drift] section, each method runs in the
    representation that suits it, and one report shows them all.
    """
    chosen = chosen_scene(asked, drift=True)
    several = several_methods(chosen, methods, asked)
    if several is not None:
        return _several(chosen, several, out, yes, quiet)
    return _one(chosen, out, yes, quiet)


def _one(scene: Scene, out: Path, yes: bool, quiet: bool) -> int:
    from ..plan import expected_time, make_plan
    from ..report import DRIFT_FILES
    from ..run.files.outputs import check_folder

    plan = make_plan(scene, "drift")
    print_notes(scene, plan.notes)
    check_time(lambda: expected_time([plan]), yes)
    check_folder(out, DRIFT_FILES)
    solution = carried_out(plan, quiet)

    from ..report import write_drift_report

    page = write_drift_report(solution, scene, out, plan, reproducing_command())
    if not quiet:
        from ..report.summary import print_summary

        print_summary(solution, scene)
        say(f"report{partly(solution)}", page)
    return exit_code(solution.status)


def _several(scene: Scene, methods: list[str], out: Path, yes: bool, quiet: bool) -> int:
    from ..plan import Plan, expected_plans, expected_time, run_methods
    from ..report import DRIFT_FILES
    from ..run.files.outputs import check_folder

    print_notes(scene)
    plans = [p for p in expected_plans(scene, methods).values() if isinstance(p, Plan)]
    check_time(lambda: expected_time(plans), yes)
    check_folder(out, DRIFT_FILES)
    result = run_methods(scene, methods, not quiet, _tell_failure)

    from ..report import write_several_report

    page = write_several_report(result, out, reproducing_command())
    if not quiet:
        from ..report.summary import print_several

        print_several(result)
        say(f"report{partly(result)}", page)
    return exit_code(result.status)


def _tell_failure(run: MethodRun) -> None:
    if run.status != "success":
        print_message(f"{run.label}: {run.status}: {run.message}".rstrip(": "))
