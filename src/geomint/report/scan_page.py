"""The report of a scan: page, picture, a row for every member as CSV, and JSON."""

import csv
from collections import Counter
from functools import partial
from pathlib import Path

import numpy as np

from ..arguments import Array
from ..plan import ScanPlan
from ..plots.scan_plot import Chart, scan_figure
from ..plots.style import Picture
from ..run.ensemble.readings.of_runs import VERDICTS, ExponentErrors, Exponents, ExponentVerdict
from ..run.ensemble.result import Ensemble
from ..run.provenance import finite_json, method_record
from ..scene.provenance import scene_record
from .pages import write_planned
from .paper import Printed, Table
from .text import Record, number

__all__ = ["scan_lines", "scan_record", "scan_status", "write_scan_report"]

FEW = 20  # members that failed, or warned, as page and JSON name them


def scan_status(many: Ensemble) -> str:
    """Return ``"interrupted"``, ``"failed"`` if no member got anywhere, or ``"success"``."""
    found = set(many.status)
    if found & {"not run", "interrupted"}:
        return "interrupted"
    return "failed" if found == {"failed"} else "success"


def _columns(many: Ensemble) -> dict[str, Array]:
    """Return the readings as columns of numbers, one for each member: of arrays one a number."""
    found = {}
    for name, values in many.readings.items():
        flat = values.reshape(len(many), -1)
        single = values.ndim == 1
        found.update({name if single else f"{name}[{k}]": c for k, c in enumerate(flat.T)})
    return found


def _bars(columns: dict[str, Array]) -> dict[str, Array]:
    """Return the standard errors of columns of exponents, by their names."""
    of = {name: name.replace(ExponentErrors.kind, Exponents.kind, 1) for name in columns}
    return {of[name]: values for name, values in columns.items() if of[name] != name}


def _verdicts(many: Ensemble) -> dict[str, list[int]]:
    """Return which members have an exponent above 0, one compatible with 0, or not enough time."""
    found = many.readings.get(ExponentVerdict.kind)
    if found is None:
        return {}
    return {word: np.flatnonzero(found == number).tolist() for word, number in VERDICTS.items()}


def scan_record(plan: ScanPlan, many: Ensemble, command: str | None) -> Record:
    """Return the content of ``scan.json``; the members are in ``scan.csv``.

    `readings` has least, median and largest values over the members, and how many have one;
    `verdicts`, of exponents, the members that are ``"regular"``: compatible with 0, and so on.
    """
    section = plan.scene.content.ensemble
    record = {
        "members": len(many),
        "status": scan_status(many),
        "statuses": dict(Counter(many.status.tolist())),
        "vary": {v.key: v.values.tolist() for v in plan.variations},
        "draws": section.draws,
        "readings": {name: _summary(values) for name, values in _columns(many).items()},
        "verdicts": _verdicts(many),
        "failed": [
            {"member": k, **_place(plan, k), "error": str(error)}
            for k, error in sorted(many.errors.items())[:FEW]
        ],
        "failures": len(many.errors),
        "warnings": [
            {"member": k, **_place(plan, k), **warning.as_json()}
            for k, told in sorted(many.warnings.items())[:FEW]
            for warning in told
        ],
        "warned": len(many.warnings),
        "representation": plan.route.name,
        "time": plan.route.problem.time,
        "steps": int(many.steps.sum()),
        "run_seconds": many.run_seconds,
        **method_record(plan.scene.method),
        "notes": list(plan.notes),
        "provenance": {**scene_record(plan.scene, command), "seed": section.seed},
    }
    return finite_json(record)


def _place(plan: ScanPlan, k: int) -> dict[str, float]:
    pairs = zip(plan.variations, plan.values[k], strict=True)
    return {variation.key: float(value) for variation, value in pairs}


def _summary(values: Array) -> Record:
    known = values[np.isfinite(values)]
    if not len(known):
        return {"known": 0, "least": None, "median": None, "largest": None}
    least, median, largest = np.quantile(known, [0.0, 0.5, 1.0])
    return {"known": len(known), "least": least, "median": median, "largest": largest}


def scan_lines(record: Record) -> list[str]:
    """Return what a terminal shows."""
    varied = [f"{key}: {len(values)} values" for key, values in record["vary"].items()]
    drawn = [f"{record['draws']} draws"] if record["draws"] else []
    told = ", ".join(f"{n} {status}" for status, n in record["statuses"].items())
    lines = [
        f"{record['members']} members ({'; '.join(varied + drawn)}): {told}",
        f"{record['steps']} steps by {record['method']} ({record['run_seconds']:.3g} seconds)",
        f"{'':24}{'least':>12}{'median':>12}{'largest':>12}",
    ]
    for name, row in record["readings"].items():
        three = (row[key] for key in ("least", "median", "largest"))
        lines.append(f"{name:24}" + "".join(f"{number(x, 4):>12}" for x in three))
    if record["warned"]:
        lines.append(f"{record['warned']} members with warnings")
    if record["verdicts"]:
        lines.append(_told_verdicts(record))
    return lines


def _told_verdicts(record: Record) -> str:
    """Return what exponents say, with the members that are compatible with 0 where they are few."""
    verdicts = record["verdicts"]
    counts = {word: len(members) for word, members in verdicts.items()}
    regular = verdicts["regular"]
    which = f" (members {', '.join(map(str, regular))})" if 0 < len(regular) <= FEW else ""
    return (
        f"largest exponents: {counts['chaotic']} above 0, {counts['regular']} compatible with 0"
        f"{which}, {counts['undecided']} undecided in this time"
    )


def _save(plan: ScanPlan, many: Ensemble, path: Path) -> None:
    columns = _columns(many)
    names = [*(v.key for v in plan.variations), "draw", "status", "warnings", *columns]
    warned = many.warned.tolist()
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(["member", *names])
        for k, status in enumerate(many.status):
            numbers = (column[k].item() for column in columns.values())
            row = [k, *plan.values[k].tolist(), int(plan.draws[k]), status, warned[k], *numbers]
            writer.writerow(row)


def write_scan_report(
    plan: ScanPlan, many: Ensemble, folder: Path, command: str | None = None, paper: bool = False
) -> Path:
    """Write the files of the report, all or none; return the path of the page.

    `paper`: those for a paper too.

    Raises
    ------
    OutputError
    """
    record = scan_record(plan, many, command)
    columns = _columns(many)
    bars = _bars(columns)
    beside = (ExponentErrors.kind, ExponentVerdict.kind)
    drawn = {k: v for k, v in columns.items() if not k.startswith(beside)} or columns
    chart = Chart(
        [v.key for v in plan.variations],
        [v.values for v in plan.variations],
        drawn,
        plan.route.problem.time,
        bars,
    )
    more = _paper(plan.scene.title, record) if paper else None
    return write_planned(
        "scan",
        plan,
        record,
        Picture(scan_figure(chart)),
        partial(_save, plan, many),
        folder,
        more,
        drawn=chart.drawn,
        verdicts=_told_verdicts(record) if record["verdicts"] else "",
    )


def _paper(title: str, record: Record) -> Printed:
    """Return caption, table and method; the members are in ``scan.csv``."""
    varied = " and ".join(
        f"{len(values)} values of {key} from {number(values[0], 6)} to {number(values[-1], 6)}"
        for key, values in record["vary"].items()
    )
    drawn = f"{record['draws']} random states" if record["draws"] else ""
    told = ", ".join(filter(None, (varied, drawn)))
    columns = ["reading", "least", "median", "largest", "runs with a value"]
    rows = [
        [name, *(number(row[key], 4) for key in ("least", "median", "largest")), str(row["known"])]
        for name, row in record["readings"].items()
    ]
    method = f"{record['method']}, order {record['order']}, {record['steps']} steps in all"
    caption = f"{title}: {record['members']} runs ({told})."
    return caption, Table(columns, rows), method
