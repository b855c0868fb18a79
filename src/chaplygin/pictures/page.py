"""The report of an exact motion: a page, the picture, sampled states as CSV, and JSON."""

from __future__ import annotations

import csv
import functools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import geomint as gi
from geomint.report.pages import (
    Picture,
    data_uri,
    json_of,
    provenance_of,
    render,
    report_files,
    write_files,
)
from geomint.report.paper import Paper, Table, scene_facts
from geomint.report.text import number, parameters_told

from .motion import TURNS, motion_panels, sampled

if TYPE_CHECKING:
    from ..exact.flow import ExactFlow
    from ..exact.reconstruction import ContactPath


Record = dict[str, Any]
EXACT_FILES = report_files("exact")
WORDS = {
    "vertical": "The vertical γ on its sphere stays between curves λ = const.",
    "separation": "The separated coordinates run to and fro in their ovals.",
    "torus": "On the torus the linear angles are a straight line.",
    "contact": "The contact point is shown without its mean drift.",
}


def exact_record(
    scene: gi.Scene, name: str, exact: ExactFlow, times: Sequence[float], command: str | None
) -> Record:
    """Return the content of ``exact.json``: frequencies, ovals, errors, states at the times asked for.

    `mean_frequencies` and `clock` are null where physical time is not available, and `no_time` says
    why; `ovals` are the intervals of the separated coordinates, `longest` is the time τ beyond which
    phases mean nothing.
    """
    record = {
        "representation": name,
        "n": len(exact.a),
        "ovals": exact.ovals,
        "frequencies": exact.frequencies,
        "mean_frequencies": None,
        "clock": None,
        "no_time": None,
        "condition": exact.condition,
        "longest": exact.longest,
        "states": [{"t": t, "state": exact(t)} for t in times],
        "pieces": [[piece, rows] for piece, rows in scene.model.problems[name].pieces],
    }
    try:
        record |= {"mean_frequencies": exact.mean_frequencies, "clock": exact.clock.mean}
    except gi.DomainError as error:
        record["no_time"] = str(error)
    return {**record, "provenance": provenance_of(scene, command)}


def write_exact_report(
    scene: gi.Scene,
    name: str,
    exact: ExactFlow,
    path: ContactPath | None,
    times: Sequence[float],
    folder: Path,
    command: str | None = None,
    paper: bool = False,
) -> Path:
    """Write the files of the report, all or none; return the path of the page.

    Raises
    ------
    geomint.OutputError
    """
    problem, record = scene.model.problems[name], exact_record(scene, name, exact, times, command)
    panels = motion_panels(exact, path)
    citation = gi.cite(problem)
    page = render(
        "exact.html.j2",
        "chaplygin.pictures",
        title=f"{scene.title}, {_given(record)['Parameters']}",
        heading=scene.title,
        given={"scene": scene.name, **_given(record)},
        description=" ".join(scene.content.description.split()),
        verdict=_verdict(record),
        facts=_facts(record, exact),
        panels=[
            {"image": data_uri(_panel(draw)), "alt": WORDS[which]} for which, draw in panels.items()
        ],
        turns=f"About {TURNS:g} turns",
        words=[WORDS[which] for which in panels],
        rows=_rows(record),
        states=[
            {"t": f"{row['t']:.17g}", "state": ", ".join(f"{x:.16g}" for x in row["state"])}
            for row in record["states"]
        ],
        equations=problem.equations,
        parameters=parameters_told(scene, problem),
        provenance=record["provenance"],
        citation=citation,
    )
    from .motion import motion_figure

    pictures = {"exact": Picture(motion_figure(exact, path))}
    others = {"exact.csv": functools.partial(_save, problem, exact)}
    more = _paper(scene, record, panels, citation) if paper else None
    return write_files(folder, EXACT_FILES, page, json_of(record), pictures, others, more)


def _verdict(record: Record) -> str:
    """Return what was found, in a sentence or two."""
    count = len(record["frequencies"])
    kind = "periodic" if count == 1 else f"quasi-periodic, on a torus of {count} dimensions"
    clock = record["clock"]
    per = "" if clock is None else f" A unit of τ takes {number(clock, 6)} of t on average."
    return f"The motion is {kind}.{per}"


def _given(record: Record) -> dict[str, str]:
    """Return system, parameters and initial state as the scene has them."""
    provenance = record["provenance"]
    name = provenance["scene"]["system"]["name"]
    system = f"{name}, in the representation {record['representation']}"
    return scene_facts(provenance, system, "exact flow, without steps")


def _facts(record: Record, exact: ExactFlow) -> dict[str, str]:
    fastest = float(np.max(np.abs(exact.frequencies)))
    relative = float(exact.phase_error(1e3 / fastest)) / 1e3
    facts = {
        "representation": f"{record['representation']}, n = {record['n']}",
        "a turn of the fastest angle takes τ": number(2.0 * np.pi / fastest, 6),
        "condition number": number(exact.condition, 3),
        "error of phases, over their size": number(relative, 3),
        "phases mean something up to |τ|": number(exact.longest, 3),
    }
    return facts | ({"physical time": record["no_time"]} if record["no_time"] else {})


def _rows(record: Record) -> list[dict[str, str]]:
    """Return a row for each angle: separated ones have an oval."""
    means = record["mean_frequencies"]
    rows = []
    for k, frequency in enumerate(record["frequencies"]):
        oval = record["ovals"][k] if k < len(record["ovals"]) else None
        rows.append(
            {
                "frequency": number(float(frequency), 15),
                "mean": "—" if means is None else number(float(means[k]), 15),
                "oval": "—" if oval is None else " … ".join(number(float(x), 10) for x in oval),
            }
        )
    return rows


def _panel(draw: Any) -> Any:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.0, 3.7), layout="constrained")
    draw(figure.subplots())
    return figure


def _save(problem: gi.Problem, exact: ExactFlow, path: Path) -> None:
    """Write the separated coordinates and the states that the picture shows, a row for each time."""
    tau, lam = sampled(exact)
    states = exact.at_tau(tau)
    names = [f"lambda[{k}]" for k in range(lam.shape[1])]
    pieces = [f"{piece}[{k}]" for piece, rows in problem.pieces for k in range(rows)]
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(["tau", *names, *pieces])
        writer.writerows(np.column_stack([tau, lam, states]).tolist())


def _paper(scene: gi.Scene, record: Record, panels: Record, citation: gi.Citation) -> Paper:
    words = " ".join(WORDS[which] for which in panels)
    rows = [
        [f"φ{k}", row["frequency"], row["mean"], row["oval"]]
        for k, row in enumerate(_rows(record), start=1)
    ]
    columns = ["angle", "frequency in τ", "mean frequency in t", "λ between"]
    caption = f"{scene.title}. {words} All numbers are dimensionless."
    command = record["provenance"]["command"]
    table = Table(columns, rows)
    return Paper("exact", caption, table, _given(record), citation, command=command)
