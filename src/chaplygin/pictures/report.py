"""What is known of an exact motion: frequencies, ovals, errors, its picture, and sampled states."""

from __future__ import annotations

import csv
import functools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import geomint as gi
from geomint.reports import files_of
from geomint.reports.report import (
    Block,
    Code,
    Images,
    Num,
    Part,
    Picture,
    Printed,
    Prose,
    Report,
    Table,
)
from geomint.reports.text import Record, number, parameters_told, scene_facts, with_provenance

from .motion import TURNS, motion_figure, motion_panels, sampled

if TYPE_CHECKING:
    from ..exact.flow import ExactFlow
    from ..exact.reconstruction import ContactPath


EXACT_FILES = files_of("exact")
WORDS = {
    "vertical": "The vertical γ on its sphere stays between curves λ = const.",
    "separation": "The separated coordinates run to and fro in their ovals.",
    "torus": "On the torus the linear angles are a straight line.",
    "contact": "The contact point is shown without its mean drift.",
}
ANGLES = (
    "All numbers are dimensionless. Angles φ are linear in τ; those of separated coordinates λ, which "
    "run to and fro in their ovals, come first."
)


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
    return with_provenance(record, scene, command)


def exact_report(
    scene: gi.Scene,
    name: str,
    exact: ExactFlow,
    path: ContactPath | None,
    times: Sequence[float],
    command: str | None = None,
    drawn: bool = True,
) -> Report:
    """Return what is known of a motion; without the picture unless it is to be `drawn`."""
    problem, record = scene.model.problems[name], exact_record(scene, name, exact, times, command)
    given = scene_facts(record["provenance"], "exact flow, without steps", name)
    panels = motion_panels(exact, path) if drawn else {}
    words = " ".join(WORDS[which] for which in panels)
    about = "; ".join(given[k] for k in ("System", "Parameters", "Initial state") if k in given)
    lead = [f"`{scene.name}`: {about}", " ".join(scene.content.description.split())]
    torus = _torus(record)
    states = [
        (f"t = {row['t']:.17g}", f"`{', '.join(f'{x:.16g}' for x in row['state'])}`")
        for row in record["states"]
    ]
    blocks: list[Block] = []
    if panels:
        shown = [(Picture(_panel(draw)).uri, WORDS[which]) for which, draw in panels.items()]
        where = "The separated coordinates are in `exact.csv`, with the states."
        said = f"About {TURNS:g} turns of the fastest angle. {words} {where}"
        blocks.append(Part("The motion", (Images(shown, "motion"), Prose(said))))
    facts = Table((), _facts(record, exact), 2, "plan")
    blocks.append(Part("The torus", (torus, Prose(ANGLES), facts)))
    if states:
        blocks.append(Part("States", (Table((), states, 2, "plan", told=False),)))
    named = list(parameters_told(scene, problem).items())
    equations = Code("\n".join(problem.equations), "equations")
    parameters = Table((), named, 2, "plan", told=False)
    blocks.append(Part("Equations and parameters", (equations, parameters)))
    caption = f"{scene.title}. {words} All numbers are dimensionless."
    return Report(
        EXACT_FILES,
        "Exact motion",
        scene.title,
        _verdict(record),
        blocks,
        record,
        summary=f"{scene.name}: {given.get('Parameters', '')}",
        lead=list(filter(None, lead)),
        pictures={"exact": Picture(motion_figure(exact, path))} if panels else {},
        citation=gi.cite(problem),
        csv=functools.partial(_save, problem, exact),
        printed=Printed(caption, torus, given),
    )


def _verdict(record: Record) -> str:
    """Return what was found, in a sentence or two."""
    count = len(record["frequencies"])
    kind = "periodic" if count == 1 else f"quasi-periodic, on a torus of {count} dimensions"
    clock = record["clock"]
    per = "" if clock is None else f" A unit of τ takes {number(clock, 6)} of t on average."
    return f"The motion is {kind}.{per}"


def _facts(record: Record, exact: ExactFlow) -> list[tuple[str, str]]:
    fastest = float(np.max(np.abs(exact.frequencies)))
    relative = float(exact.phase_error(1e3 / fastest)) / 1e3
    clock = record["clock"]
    time = ("physical time", record["no_time"])
    return [
        ("representation", f"{record['representation']}, n = {record['n']}"),
        time if clock is None else ("t per τ, mean", number(clock, 15)),
        ("a turn of the fastest angle takes τ", number(2.0 * np.pi / fastest, 6)),
        ("condition number", number(exact.condition, 3)),
        ("error of phases, over their size", number(relative, 3)),
        ("phases mean something up to |τ|", number(exact.longest, 3)),
    ]


def _torus(record: Record) -> Table:
    """Return a row for each angle: separated ones have an oval."""
    frequencies, ovals = record["frequencies"], record["ovals"]
    means = record["mean_frequencies"] or [None] * len(frequencies)
    between = [" … ".join(number(x, 15) for x in oval) for oval in ovals]
    between += ["—"] * (len(frequencies) - len(ovals))
    rows = [
        (f"φ{k}", Num(frequency, 15), Num(mean, 15), oval)
        for k, (frequency, mean, oval) in enumerate(
            zip(frequencies, means, between, strict=True), 1
        )
    ]
    columns = ("angle", "frequency in τ (rad)", "mean frequency in t (rad)", "λ between")
    return Table(columns, rows, kind="quantities counts")


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
