"""``geomint run``."""

from pathlib import Path
from typing import Any

import click

from . import options


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
    from ..run.files.outputs import check_file

    chosen = options.chosen_scene(scene, **changes)

    from ..arguments import file_path
    from ..errors import OutputError
    from ..plan import expected_time, make_plan, run_plan
    from ..run.storage import ENDINGS, holds_run, save_solution

    plan = make_plan(chosen)
    given, out = out, out or Path(f"{chosen.name}.nc")
    options.print_notes(chosen)
    options.check_time(lambda: expected_time([plan]), yes)
    file_path("--out", out, ENDINGS, strict=False)
    check_file(out)
    if not given and out.exists() and not holds_run(out):
        raise OutputError(out, "another file is there, which is left alone; name one with --out")
    result = run_plan(plan, not quiet)
    options.tell_failure(result[0])
    solution = result[0].solution
    assert solution is not None

    from ..scene.provenance import scene_record

    asked = scene_record(chosen, options.reproducing_command())
    save_solution(solution, out, {**asked, **solution.provenance})
    if not quiet:
        from ..report.summary import print_runs

        print_runs(result)
        options.say(f"written{options.partly(result.status)}", out)
    return options.exit_code(result.status)
