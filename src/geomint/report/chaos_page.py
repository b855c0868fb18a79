"""The report of Lyapunov exponents: page, picture, the exponents over time as CSV, and JSON."""

from pathlib import Path

import numpy as np

from ..plan import ChaosPlan
from ..plots.style import Picture
from ..run.exponents import Lyapunov
from ..run.provenance import finite_json, method_record
from ..scene.provenance import scene_record
from .pages import write_planned
from .paper import Printed, Table
from .text import Record, number, symbol

__all__ = ["chaos_lines", "chaos_record", "write_chaos_report"]

SAID = {
    "chaotic": "Chaotic: neighbouring motions part exponentially.",
    "regular": "Regular: neighbouring motions part like a power of time, as far as this run tells.",
    "undecided": "Undecided: a longer run may tell.",
}


def chaos_record(plan: ChaosPlan, found: Lyapunov, command: str | None) -> Record:
    """Return the content of ``chaos.json``; the exponents over time are in ``chaos.csv``.

    `reference` is ln(t/T)/t at the end, T the characteristic time `unit`: about what a regular motion
    has; `grown` is λ₁ t, and `alignment` the smaller alignment index there.
    """
    end = float(found.t[-1]) if len(found.t) else 0.0
    record = {
        "verdict": found.verdict,
        "exponents": found.exponents.tolist(),
        "errors": found.errors.tolist(),
        "sum": float(np.sum(found.exponents)),
        "all": plan.count is None,
        "grown": float(found.exponents[0] * end),
        "reference": float(np.log(end / found.unit) / end) if end > found.unit else None,
        "alignment": None if found.sali is None or not end else float(found.sali[-1]),
        "end": end,
        "unit": found.unit,
        "status": found.status,
        "representation": plan.route.name,
        "time": plan.route.problem.time,
        "steps": found.steps,
        "iterations": found.iterations,
        **method_record(plan.scene.method),
        "initial": plan.route.state.tolist(),
        "warnings": [warning.as_json() for warning in found.warnings],
        "provenance": scene_record(plan.scene, command),
    }
    return finite_json(record)


def chaos_lines(title: str, record: Record) -> list[str]:
    """Return what a terminal shows."""
    rows = [
        (f"λ{k + 1}", f"{number(value, 4):>11}", "" if error is None else f" ± {error:.1g}")
        for k, (value, error) in enumerate(zip(record["exponents"], record["errors"], strict=True))
    ]
    if record["all"]:
        rows.append(("sum", f"{number(record['sum'], 2):>11}", ""))
    run = f"{record['steps']} steps by {record['method']} to "
    run += f"{symbol(record['time'])} = {record['end']:.6g}"
    lines = [title, run, *(f"  {name:4}{value}{error}" for name, value, error in rows)]
    if record["alignment"] is not None:
        lines.append(f"  alignment index {record['alignment']:.2g}")
    return [*lines, SAID[record["verdict"]]]


def write_chaos_report(
    plan: ChaosPlan, found: Lyapunov, folder: Path, command: str | None = None, paper: bool = False
) -> Path:
    """Write the files of the report, all or none; return the path of the page.

    `paper`: those for a paper too.

    Raises
    ------
    OutputError
    """
    record = chaos_record(plan, found, command)
    picture, said = Picture(found.plot()), SAID[record["verdict"]]
    more = _paper(plan.scene.title, record) if paper else None
    return write_planned("chaos", plan, record, picture, found.save, folder, more, verdict=said)


def _paper(title: str, record: Record) -> Printed:
    """Return caption, table and method; the data are in ``chaos.csv``."""
    time = symbol(record["time"])
    caption = (
        f"{title}. Sizes of the Lyapunov exponents, per unit of {time}, over time up to "
        f"{time} = {number(record['end'], 6)}; dotted: ln t / t, as of a regular motion. "
        f"{SAID[record['verdict']]}"
    )
    rows = [
        [f"λ{k}", number(value, 4), number(error, 2)]
        for k, (value, error) in enumerate(
            zip(record["exponents"], record["errors"], strict=True), start=1
        )
    ]
    rows += [["sum", number(record["sum"], 2), "—"]] if record["all"] else []
    columns = ["exponent", f"per unit of {time}", "standard error"]
    method = f"{record['method']}, order {record['order']}, {record['steps']} steps"
    return caption, Table(columns, rows), method
