"""Results on the terminal: drifts of runs, points of a comparison."""

from rich.console import Console
from rich.measure import Measurement
from rich.table import Column, Table
from rich.text import Text

from ..compare.point import Point
from ..compare.runs import Comparison
from ..errors import printable
from ..plan import MethodRun, SeveralRuns
from ..run.solution import Solution, told_errors
from ..scene import Scene
from .columns import fitted
from .kinds import outcomes
from .text import duration, number, short_slope, step_of, watched_to

__all__ = ["print_comparison", "print_runs"]

_COLOURS = {
    "roundoff": "green",
    "bounded": "green",
    "jump": "yellow",
    "sqrt": "cyan",
    "linear": "yellow",
    "faster": "red",
    "not finite": "bold red",
    "undetermined": "magenta",
}


def print_runs(result: SeveralRuns) -> None:
    """Print what was run, a row for each quantity of each method, and the outcome in words."""
    console = Console()
    console.print(Text(printable(result.scene.title), style="bold"))
    unbounded = Console(width=10_000)  # measured without wrapped cells
    tables = [_drifts(unbounded, run, True) for run in result]
    widths = [Measurement.get(unbounded, unbounded.options, table).maximum for table in tables]
    wide = max(widths) <= console.width
    for run in result:
        if run.solution is not None:
            console.print(Text(_cost(run.solution)))
            for name, what in told_errors(run.solution).items():
                console.print(Text(f"{name}: {what}"))
            if run.solution.events:
                console.print(Text(_events(run.solution)))
        if run.status != "success":
            console.print(Text(f"{run.title} {run.message}".rstrip(), style="bold red"))
        if run.drift:
            console.print(_drifts(console, run, wide))
    if any(run.drift for run in result):
        console.print(Text("trend ≤: the largest rise or fall over the run not excluded at 95 %"))
    for kind, outcome in outcomes(result):
        console.print(Text(f"{kind} – {outcome}" if kind else outcome))


def _cost(solution: Solution) -> str:
    """Return a line on what a run took; of an exact motion what was followed."""
    if solution.route and not solution.steps:
        return solution.route
    seconds, steps = solution.run_seconds, solution.steps
    rate = steps / seconds if seconds > 0.0 else 0.0
    return (
        f"{solution.method.name}, step {step_of(solution)}, {steps} steps in {seconds:.3g} s "
        f"({rate:.3g} a second), {solution.evaluations:.4g} field evaluations"
    )


def _events(solution: Solution) -> str:
    """Return how often each event happened, and whether one of them ended the run."""
    counts = ", ".join(f"{name} {len(met)}" for name, met in solution.events.items())
    return f"events: {counts}" + (f"; {solution.message}" if solution.success else "").rstrip("; ")


def _drifts(console: Console, run: MethodRun, wide: bool) -> Table:
    """Return the table of a run; if it must be narrow, slopes without their errors."""
    numbers = ("initial", "max |error|", "final error", "slope", "trend ≤")
    columns: list[str | Column] = [
        "quantity",
        *(Column(name, justify="right", no_wrap=True) for name in numbers),
        Column("class", no_wrap=True),
    ]
    rows = []
    for name, drift in run.drift.items():
        slope = short_slope(drift.slope, drift.slope_stderr) if wide else number(drift.slope, 2)
        until = watched_to(drift, run)
        row = (
            f"{name} ({until})" if until else name,
            number(drift.initial, 6 if wide else 4),
            number(drift.max_abs_error),
            number(drift.final_error),
            slope,
            number(drift.trend_bound, 2),
            Text(drift.drift_class, style=_COLOURS[drift.drift_class]),
        )
        rows.append(row)
    spare = () if wide else ("initial", "final error", "trend ≤", "slope")
    return fitted(console, columns, rows, spare, pad_edge=wide)


def print_comparison(result: Comparison, scene: Scene) -> None:
    """Print a row for each point: step or tolerance, error, run time; below, what has no result."""
    console = Console()
    console.print(Text(printable(scene.title), style="bold"))
    numbers = ("step", "rtol", "steps", "error", "run time")
    columns: list[str | Column] = [
        "method",
        *(Column(name, justify="right", no_wrap=True) for name in numbers),
        Column("status", no_wrap=True),
    ]
    rows = []
    reasons = {(p.method, p.status) for p in result.points if p.status != "ok"}
    for p in result.points:
        error = number(p.error, 2)
        if p.error is None and p.bound is not None:
            error = f"≤ {number(p.bound, 2)}"
        row = (
            p.method if p.peer is None else f"{p.method} (peer)",
            number(p.step or None, 4),
            number(p.rtol, 1),
            "—" if p.steps is None else str(p.steps),
            error,
            "—" if p.seconds is None else duration(p.seconds),
            Text(_outcome(p), style="green" if p.status == "ok" else "yellow"),
        )
        rows.append(row)
    console.print(fitted(console, columns, rows, ("steps", "rtol", "status")))
    for method, status in sorted(reasons):
        console.print(Text(f"{method}: {status}"))
    for peer, why in result.left_out.items():
        console.print(Text(f"{peer}: left out: {why}"))


def _outcome(point: Point) -> str:
    """Return a word or two for what became of a point; the whole status is below the table."""
    if point.status == "ok":
        return "ok"
    return point.status.partition(":")[0] if point.representation else "does not fit"
