"""The drifts of a run on the terminal."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..scene import Scene
from ..solution import Solution
from .text import number, verdict, with_error

__all__ = ["print_summary"]

_COLOURS = {
    "roundoff": "green",
    "bounded": "green",
    "sqrt": "cyan",
    "linear": "yellow",
    "faster": "red",
    "undetermined": "magenta",
}


def print_summary(solution: Solution, scene: Scene) -> None:
    """Print what was run and a row for each quantity."""
    console = Console()
    console.print(Text(scene.title, style="bold"))
    rate = solution.steps / solution.run_seconds if solution.run_seconds > 0.0 else 0.0
    console.print(
        Text(
            f"{solution.method.name}, step {abs(solution.step):g}, {solution.steps} steps in "
            f"{solution.run_seconds:.3g} s ({rate:.3g} a second), "
            f"{solution.evaluations:.4g} field evaluations"
        )
    )
    if solution.status != "success":
        console.print(Text(f"{solution.status} {solution.message}".strip(), style="bold red"))
    if solution.drift:
        table = Table(box=None, header_style="bold")
        table.add_column("quantity")
        for column in ("initial", "max |error|", "final error", "slope"):
            table.add_column(column, justify="right")
        table.add_column("class")
        for name, drift in solution.drift.items():
            table.add_row(
                name,
                number(drift.initial, 6),
                number(drift.max_abs_error),
                number(drift.final_error),
                with_error(drift.slope, drift.slope_stderr),
                Text(drift.kind, style=_COLOURS[drift.kind]),
            )
        console.print(table)
    console.print(Text(verdict(solution)))
