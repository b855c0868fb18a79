"""What of a drift report is for a paper."""

from collections.abc import Iterable, Iterator
from typing import Any

from ..plan import MethodRun, SeveralRuns
from ..watch.kinds import KINDS
from .cite import Citation, cite
from .kinds import conserved_by_kind
from .report import Printed, Table, Verdict
from .text import Record, number, scene_facts, short_slope, step_of, symbol

__all__ = ["drift_paper"]


def drift_paper(result: SeveralRuns, provenance: Record) -> Printed:
    """Return caption, table, facts and data of a report on one or several methods."""
    title = f"{result.scene.title}, to {symbol(result.time)} = {_end(result)}"
    shown = _and(
        KINDS[kind].title + ("" if names == [KINDS[kind].one] else f" ({', '.join(names)})")
        for kind, names in conserved_by_kind(result).items()
    )
    if len(result) > 1:
        caption = (
            f"{title}. The largest deviation of {shown} in windows of time, relative to the scale of "
            f"each quantity, a line a method; dashed: the level of round-off."
        )
    else:
        motion = "The first turns of the motion; below, the" if result.motion else "The"
        caption = (
            f"{title}. {motion} largest deviation of {shown} in windows of time, beyond round-off; "
            f"dashed: the level of round-off."
        )
    forms = " and ".join(dict.fromkeys(r.representation for r in result if r.representation))
    methods = "; ".join(_method(run) for run in result)
    facts = scene_facts(provenance, methods, forms)
    return Printed(caption, _table(result), facts, list(_rows(result)))


def citation_of(result: SeveralRuns) -> Citation:
    """Return what to cite for the runs of a report."""
    plans = [run.plan for run in result if run.plan is not None]
    methods = [run.solution.method for run in result if run.solution is not None]
    return cite(*(plan.problem for plan in plans), *methods)


def _and(words: Iterable[str]) -> str:
    """Return words with commas between, and an ``and`` before the last."""
    *first, last = [*words] or ["no quantity"]
    return f"{', '.join(first)} and {last}" if first else last


def _end(result: SeveralRuns) -> str:
    ends = dict.fromkeys(f"{run.end:.6g}" for run in result if run.solution is not None)
    return " or ".join(ends) or "0"


def _method(run: MethodRun) -> str:
    if run.solution is None:
        return f"{run.label} ({run.status})"
    if not run.solution.steps:
        return run.label
    step = f"step {step_of(run.solution)} in {symbol(run.solution.problem.time)}"
    return f"{run.solution.method.name}, order {run.solution.method.order}, {step}"


def _table(result: SeveralRuns) -> Table:
    names = [name for ones in conserved_by_kind(result).values() for name in ones]
    units = dict.fromkeys(_unit(run, n) for run in result for n in names if n in run.drift)
    one = f" ({next(iter(units))})" if len(units) == 1 else ""
    per = f"slope, per unit of {symbol(result.time)}"
    columns = ["method", "quantity", "unit", "class", f"largest error{one}", per]
    left_out = {0} if len(result) == 1 else set()
    left_out |= {2} if one else set()
    rows = [
        [run.label, *_cells(run, name)] for name in names for run in result if name in run.drift
    ]
    kept = [k for k in range(len(columns)) if k not in left_out]
    rows = [[row[k] for k in kept] for row in rows]
    return Table([columns[k] for k in kept], rows, len(kept) - 2)


def _unit(run: MethodRun, name: str) -> str:
    assert run.plan is not None
    return run.plan.problem.unit(name)


def _cells(run: MethodRun, name: str) -> tuple[str, ...]:
    drift = run.drift[name]
    slope = short_slope(drift.slope, drift.slope_stderr)
    return (
        name,
        _unit(run, name),
        str(Verdict(drift.drift_class)),
        number(drift.max_abs_error),
        slope,
    )


def _rows(result: SeveralRuns) -> Iterator[tuple[Any, ...]]:
    """Yield the windows that the figure shows, a row each."""
    yield ("method", "quantity", result.time, "largest deviation", "mean deviation", "scale")
    for run in result:
        for name, drift in run.drift.items():
            windows = drift.windows
            for numbers in zip(windows.times, windows.maxima, windows.means, strict=True):
                yield (run.label, name, *map(float, numbers), drift.scale)
