"""``geomint exact``."""

import math
from pathlib import Path
from typing import Any

import click

import geomint as gi
from geomint.arguments import file_path
from geomint.cli import options

ENDINGS = (".gif", ".html", ".mp4")
FRAMES = 200
FRAMES_PER_SECOND = 20.0
MOST_FRAMES = 10_000  # the writers of .gif and .html hold all of them
FRAME = 0.2  # time between frames over the time of a turn of the fastest angle by one


@click.command("exact")
@click.argument("scene")
@options.list_option(
    "--at", "times", of=float, metavar="T,T,…", help="Print the state at these physical times."
)
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    help="Write exact.html, exact.csv, exact.json, exact.png and exact.svg to this folder.",
)
@options.paper_option
@click.option(
    "--animate",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write a film of the rolling ball (n = 3) to this file: .gif, .html or .mp4.",
)
@click.option(
    "--frames",
    type=click.IntRange(min=2, max=MOST_FRAMES),
    show_default=str(FRAMES),
    help="Number of frames of the film.",
)
@click.option("--debug", is_flag=True, hidden=True, expose_value=False)
def exact(
    scene: str,
    times: list[float] | None,
    out: Path | None,
    paper: bool,
    animate: Path | None,
    frames: int | None,
) -> None:
    """Solve an integrable scene by formulas: frequencies, states at any time.

    The command solves the Chaplygin sphere with zero momentum, the rubber ball, the ball in R³ with any
    momentum, and Veselova's problem. It refuses times so large that rounding errors make the
    phase meaningless.
    """
    times = times or []
    if not all(map(math.isfinite, times)):
        raise gi.DomainError("--at", times, "finite numbers with commas between")
    if animate is not None:
        file_path("--animate", animate, ENDINGS)
    if animate is None and frames is not None:
        raise gi.DomainError("--frames", frames, "--animate, of which they are the frames")
    if paper and out is None:
        raise gi.DomainError("--paper", paper, "--out, the folder of what is for a paper")
    chosen = gi.load_scene(scene)
    if out is not None:
        from .report import EXACT_FILES

        gi.check_folder(out, EXACT_FILES)
        if animate is not None and animate.resolve() in {(out / n).resolve() for n in EXACT_FILES}:
            raise gi.OutputError(animate, "it is a file of the report; expected another place")
    if animate is not None:
        gi.check_file(animate)
    model = chosen.model
    name, motion = _motion(model)
    if out is not None and not hasattr(motion, "lam"):
        raise gi.DomainError("--out", str(out), "a motion that separates: this is a steady turn")
    path = _path(model) if out or animate else None

    from geomint.reports.files import write
    from geomint.reports.terminal import show

    from .report import exact_report

    command, drawn = options.reproducing_command(), out is not None
    report = exact_report(chosen, name, motion, path, times, command, drawn)
    show(report)
    for row in report.record["states"]:
        click.echo(f"t = {row['t']:.17g}: [" + ", ".join(f"{x:.16g}" for x in row["state"]) + "]")
    if out is not None:
        options.say_report("report", write(report, out, paper), report.stem if paper else "")
    if animate is not None:
        if path is None:
            raise gi.DomainError("--animate", str(animate), "a scene of the ball in R³")
        _animate(model, path, animate, FRAMES if frames is None else frames)
        options.print_line(f"animation: {animate}")


def _motion(model: gi.Model) -> tuple[str, Any]:
    """Return the first representation with an exact flow, and the scene's motion."""
    for name, problem in model.problems.items():
        if problem.make_exact is not None:
            return name, problem.exact(model.states[name])
    offered = ", ".join(model.problems)
    raise gi.FormError(f"no representation of this scene has an exact flow: {offered}")


def _path(model: gi.Model) -> Any:
    """Return the contact path of the scene's ball in R³; None of other systems."""
    problem = model.problems.get("classical")
    if problem is None or problem.name != "classical-ball":
        return None
    from ..exact.reconstruction import ContactPath

    rho = next((p.parameters["rho"] for p in model.problems.values() if "rho" in p.parameters), 1.0)
    return ContactPath(problem.exact(model.states["classical"]), rho)


def _animate(model: gi.Model, path: Any, file: Path, frames: int) -> None:
    import numpy as np
    from rich.console import Console
    from rich.progress import Progress

    fastest = float(np.max(np.abs(path.exact.mean_frequencies)))
    end = FRAME / fastest * (frames - 1)
    problem, state = model.problems["classical"], model.states["classical"]
    solution = gi.solve(problem, state, t_end=end, method="exact", dense=True, progress=False)
    screen = Console(stderr=True)
    with Progress(console=screen, transient=True, disable=not screen.is_terminal) as bar:
        task = bar.add_task("frames", total=frames)
        solution.animate(
            file,
            fps=FRAMES_PER_SECOND,
            speed=end * FRAMES_PER_SECOND / (frames - 1),
            progress=lambda done, total: bar.update(task, completed=done),
        )
