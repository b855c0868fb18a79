"""``geomint compare``."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

import click

from . import options


@click.command("compare")
@click.argument("scene")
@options.list_option("--methods", help="Methods, separated by commas, such as gauss-8,cf-4,rk-4.")
@options.list_option(
    "--steps", of=float, help="Step sizes, separated by commas; default: chosen for each method."
)
@click.option(
    "--repeats",
    type=click.IntRange(min=1),
    help="Number of timed runs of each point; default: 3, or fewer if one takes a second.",
)
@options.folder_option("report", "compare.html, compare.json and the plots")
@options.paper_option
@click.option(
    "--reference",
    type=click.Choice(["auto", "extended", "exact"]),
    help="Reference solution: by double-double arithmetic, by the exact flow, or the faster one.",
)
@click.option(
    "--peers",
    is_flag=True,
    help="Also run integrators of other installed packages that can solve the problem.",
)
@options.end_options
@options.yes_option
@options.quiet_option
@options.debug_option
def command(
    scene: str,
    methods: list[str] | None,
    steps: list[float] | None,
    repeats: int | None,
    reference: Literal["auto", "extended", "exact"] | None,
    peers: bool,
    out: Path,
    paper: bool,
    yes: bool,
    quiet: bool,
    t_end: float | None,
    tau_end: float | None,
) -> int:
    """Compare methods on a scene: run time against error, drift against time.

    The exit code is 2 if a method has no result: it does not fit the scene, or its runs fail.
    """
    from ..arguments import positive
    from ..compare.of_scene import compare_scene, comparison_time, warming
    from ..compare.peers import PEERS
    from ..kernels.compiling.beside import compiled_beside
    from ..report import COMPARE_FILES
    from ..report.compare_page import reference_text, write_compare_report
    from ..report.summary import print_comparison
    from ..run.files.outputs import check_folder

    chosen = options.chosen_scene(scene).for_compare()
    if t_end is not None or tau_end is not None:
        chosen = chosen.changed(time={"t_end": t_end, "tau_end": tau_end})
    section = chosen.content.compare
    names = section.methods or [chosen.method.name] if methods is None else methods
    given = section.steps if steps is None else [positive("--steps", step) for step in steps]
    repeats = repeats or section.repeats
    reference = reference or section.reference or "auto"
    options.print_notes(chosen)
    options.check_time(lambda: comparison_time(chosen, names, given, repeats, reference), yes)
    check_folder(out, COMPARE_FILES)
    at = [""]

    def tasks() -> list[Callable[[], object]]:
        return warming(chosen, names, at[0])

    with _status_line(not quiet) as show, compiled_beside(tasks):

        def report(text: str) -> None:
            at[0] = text
            show(text)

        others = PEERS if peers else ()
        result = compare_scene(chosen, names, given, repeats, reference, others, report)
    write_compare_report(result, chosen, out, options.reproducing_command(), paper)
    for method, status in result.without_result.items():
        options.print_message(f"{method}: no result: {status}")
    if not quiet:
        print_comparison(result, chosen)
        click.echo(f"reference: {' '.join(reference_text(result.reference))}")
        options.say_report(f"report{options.partly(result.status)}", out / "compare.html", paper)
    if result.without_result and result.status == "success":
        return options.exit_code("failed")
    return options.exit_code(result.status)


@contextmanager
def _status_line(show: bool) -> Iterator[Callable[[str], None]]:
    """Show on standard error what is being done, or nothing."""
    if not show:
        yield lambda text: None
        return
    from rich.console import Console

    with Console(stderr=True).status("comparing") as status:
        yield lambda text: status.update(f"comparing: {text}")
