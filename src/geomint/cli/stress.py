"""``geomint stress``."""

from pathlib import Path

import click

from . import options


@click.command("stress")
@options.folder_option("stress", "stress.html, stress.json, stress.png and stress.svg")
@options.list_option("--methods", help="Methods, separated by commas; default: all.")
@options.list_option("--systems", help="Systems, separated by commas; default: all.")
@options.list_option("--axis", help="Axes of the map, separated by commas; default: all.")
@click.option("--quick", is_flag=True, help="Run a small part, in less than a minute.")
@click.option(
    "--seconds",
    type=click.FloatRange(min=0.0, min_open=True),
    default=60.0,
    show_default=True,
    help="Time limit of one test, in seconds.",
)
@click.option(
    "--workers", type=click.IntRange(1), default=2, show_default=True, help="Number of processes."
)
@options.quiet_option
@options.debug_option
def command(
    out: Path,
    methods: list[str] | None,
    systems: list[str] | None,
    axis: list[str] | None,
    quick: bool,
    seconds: float,
    workers: int,
    quiet: bool,
) -> int:
    """Test all methods on all systems until each fails.

    The exit code is 1 if geomint returns a number that is not finite, loses accuracy or a conserved
    quantity without a warning, raises an error without a type, or hangs.
    """
    from ..report import STRESS_FILES
    from ..run.files.outputs import check_folder
    from ..stress.judge import forbidden
    from ..stress.page import stress_record, write_stress_report
    from ..stress.sweep import Selection, run_selection
    from ..stress.terminal import Watch

    selection = Selection(tuple(methods or ()), tuple(systems or ()), tuple(axis or ()), quick)
    check_folder(out, STRESS_FILES)
    with Watch(not quiet) as watch:
        result = run_selection(selection, watch, seconds=seconds, workers=workers)
    record = stress_record(
        result.cells, result.axes, result.seconds, options.reproducing_command(), result.interrupted
    )
    page = write_stress_report(record, result.methods, out)
    if not quiet:
        watch.summary(result.cells)
        options.say("report (interrupted)" if result.interrupted else "report", page)
    done = "forbidden" if forbidden(result.cells) else "success"
    return options.exit_code("interrupted" if result.interrupted else done)
