"""Integrate a scene and write states and drifts to a NetCDF file."""

import os
from itertools import count
from pathlib import Path
from typing import Any

import click

from .. import options


@click.command("run")
@options.scene_options
@click.option(
    "--out",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Output file: NAME.nc, or NAME.csv for states only; default: SCENE.nc.",
)
@options.yes_option
@options.quiet_option
def command(
    scene: str,
    out: Path | None,
    yes: bool,
    quiet: bool,
    **changes: Any,
) -> int:
    """Integrate a scene and write states and drifts to a NetCDF file."""
    from ...run.files.outputs import check_file

    chosen = options.chosen_scene(scene, **changes)

    from ...arguments import file_path
    from ...errors import OutputError
    from ...plan import expected_time, make_plan, run_plan
    from ...run.storage import ENDINGS, check_own, save_solution

    plan = make_plan(chosen)
    given, out = out, out or Path(f"{chosen.name}.nc")
    options.print_notes(chosen)
    options.check_time(lambda: expected_time([plan]), yes)
    file_path("--out", out, ENDINGS, strict=False)
    check_file(out)
    if not given:
        check_own(out)
    result = run_plan(plan, not quiet)
    options.tell_failure(result[0])
    solution = result[0].solution
    assert solution is not None

    from ...scene.provenance import scene_record

    asked = scene_record(chosen, options.reproducing_command())
    told = {**asked, **solution.provenance}
    try:
        save_solution(solution, out, told, own=not given)
    except OutputError as refused:  # for what came there meanwhile; the run is not lost either
        if refused.errno is not None:
            raise
        names = (out.with_stem(f"{out.stem}-{k}") for k in count(2))
        out = next(name for name in names if not os.path.lexists(name))
        save_solution(solution, out, told, own=True)
        options.print_message(f"{refused}; the run is in {out}")
    if not quiet:
        from ...reports.drift_report import told_report
        from ...reports.terminal import show

        show(told_report(result))
        options.say(f"written{options.partly(result.status)}", out)
    return options.exit_code(result.status)
