"""The drifts of a run on the terminal."""

from __future__ import annotations

from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from ..compare.runs import Comparison, Point
from ..errors import printable
from ..plan import MethodRun, SeveralRuns
from ..run.solution import Solution
from ..scene import Scene
from ..watch.drift import Drift
from .kinds import kinds_in_words, names_by_kind
from .text import duration, number, short_slope, spanned, step_of, verdict

__all__ = ["print_comparison", "print_several", "print_summary"]

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


def print_several(result: SeveralRuns) -> None:
    """Print a row for each method: largest error and class of each quantity, time per step."""
    console = Console()
    console.print(Text(printable(result.scene.title), style="bold"))
    table = _by_method(result)
    if _too_wide(console, table):
        table = _by_quantity(result)
    console.print(table)
    for kind, outcome in kinds_in_words(result):
        console.print(Text(f"{kind} – {outcome}"))


def _too_wide(console: Console, table: Table) -> bool:
    """Tell whether a table without wrapped cells is wider than the terminal."""
    unbounded = console.options.update_width(10_000)
    return Measurement.get(console, unbounded, table).maximum > console.width


def _by_method(result: SeveralRuns) -> Table:
    """Return a table with a row for each method and a column for each quantity."""
    names = [name for group in names_by_kind(result).values() for name in group]
    table = Table(box=None, header_style="bold")
    table.add_column("method", no_wrap=True)
    for name in (*names, "per step", "run time"):
        table.add_column(name, justify="right")
    for run in result:
        cells = [_cell(run.drift.get(name)) for name in names]
        table.add_row(run.title, *cells, *_times(run))
    return table


def _by_quantity(result: SeveralRuns) -> Table:
    """Return a narrow table with a row for each quantity of each method."""
    names = [name for group in names_by_kind(result).values() for name in group]
    table = Table("method", "quantity", box=None, header_style="bold", pad_edge=False)
    for column in ("max |error|, class", "per step", "run time"):
        table.add_column(column, justify="right", no_wrap=True)
    for run in result:
        first: tuple[str, ...] = _times(run)
        label = run.title
        for name in names:
            table.add_row(label, name, _cell(run.drift.get(name)), *first)
            label, first = "", ()
    return table


def _times(run: MethodRun) -> tuple[str, str]:
    if run.solution is None or not run.solution.steps:
        return "–", "–"
    seconds = run.solution.run_seconds
    return duration(seconds / run.solution.steps), duration(seconds)


def _cell(drift: Drift | None) -> Text:
    if drift is None:
        return Text("–")
    return Text(
        f"{number(drift.max_abs_error, 2)} {drift.drift_class}", style=_COLOURS[drift.drift_class]
    )


def print_summary(solution: Solution, scene: Scene) -> None:
    """Print what was run and a row for each quantity."""
    console = Console()
    console.print(Text(printable(scene.title), style="bold"))
    rate = solution.steps / solution.run_seconds if solution.run_seconds > 0.0 else 0.0
    told = (
        f"{solution.method.name}, step {step_of(solution)}, {solution.steps} steps in "
        f"{solution.run_seconds:.3g} s ({rate:.3g} a second), "
        f"{solution.evaluations:.4g} field evaluations"
    )
    console.print(Text(told if solution.steps or not solution.route else solution.route))
    if solution.status != "success":
        console.print(Text(f"{solution.status} {solution.message}".strip(), style="bold red"))
    if solution.drift:
        table = _drifts(solution, True)
        console.print(_drifts(solution, False) if _too_wide(console, table) else table)
        console.print(Text("trend ≤: the largest rise or fall over the run not excluded at 95 %"))
    console.print(Text(verdict(solution)))


def _drifts(solution: Solution, wide: bool) -> Table:
    """Return the table of a run; if it must be narrow, slopes without their errors."""
    table = Table(box=None, header_style="bold", pad_edge=wide)
    table.add_column("quantity", overflow="fold")
    for column in ("initial", "max |error|", "final error", "slope", "trend ≤"):
        table.add_column(column, justify="right")
    table.add_column("class", no_wrap=True)
    for name, drift in solution.drift.items():
        slope = short_slope(drift.slope, drift.slope_stderr) if wide else number(drift.slope, 2)
        table.add_row(
            spanned(name, drift, solution),
            number(drift.initial, 6 if wide else 4),
            number(drift.max_abs_error),
            number(drift.final_error),
            slope,
            number(drift.trend_bound, 2),
            Text(drift.drift_class, style=_COLOURS[drift.drift_class]),
        )
    return table


def print_comparison(result: Comparison, scene: Scene) -> None:
    """Print a row for each point: step or tolerance, error, run time; below, what has no result."""
    console = Console()
    console.print(Text(printable(scene.title), style="bold"))
    table = Table(box=None, header_style="bold")
    table.add_column("method", overflow="fold")
    for column in ("step", "rtol", "steps", "error", "run time"):
        table.add_column(column, justify="right", no_wrap=True)
    table.add_column("status", no_wrap=True)
    reasons = {(p.method, p.status) for p in result.points if p.status != "ok"}
    for p in result.points:
        error = number(p.error, 2)
        if p.error is None and p.bound is not None:
            error = f"≤ {number(p.bound, 2)}"
        table.add_row(
            p.method,
            number(p.step or None, 4),
            number(p.rtol, 1),
            "—" if p.steps is None else str(p.steps),
            error,
            "—" if p.seconds is None else duration(p.seconds),
            Text(_outcome(p), style="green" if p.status == "ok" else "yellow"),
        )
    console.print(table)
    for method, status in sorted(reasons):
        console.print(Text(f"{method}: {status}"))


def _outcome(point: Point) -> str:
    """Return a word or two for what became of a point; the whole status is below the table."""
    if point.status == "ok":
        return "ok"
    return point.status.partition(":")[0] if point.representation else "does not fit"
