"""``geomint drift``."""

from __future__ import annotations

from pathlib import Path

import click

from .options import chosen_scene, exit_code, reproducing_command, scene_options, tell_notes

__all__ = ["command"]


@click.command("drift")
@scene_options
@click.option(
    "--out",
    default="report",
    show_default=True,
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder for report.html, drift.json, drift.png and drift.svg.",
)
@click.option("--quiet", is_flag=True, help="No progress, no summary.")
def command(
    scene: str,
    method: str | None,
    step: float | None,
    t_end: float | None,
    tau_end: float | None,
    out: Path,
    quiet: bool,
) -> int:
    """Integrate a scene for long and report how its invariants drift."""
    from ..errors import StepError

    chosen = chosen_scene(scene, method, step, t_end, tau_end, drift=True)

    from ..plan import make_plan

    plan = make_plan(chosen, "drift")
    tell_notes(chosen)
    out.mkdir(parents=True, exist_ok=True)
    failure: StepError | None = None
    try:
        solution = plan.solve(progress=not quiet)
    except StepError as error:
        failure, solution = error, error.partial

    from ..report import write_drift_report

    page = write_drift_report(solution, chosen, out, plan, reproducing_command())
    if not quiet:
        from ..report.summary import print_summary

        print_summary(solution, chosen)
        click.echo(f"report: {page}")
    if failure is not None:
        raise failure
    return exit_code(solution)
