"""The report of a Poincaré section: page, picture, the points as CSV, and JSON."""

from pathlib import Path

import numpy as np

from ..plan import SectionPlan
from ..plots.style import COLOURS, Picture
from ..problems.at_states import values_at
from ..run.provenance import finite_json, method_record
from ..run.section import Section
from ..scene.provenance import scene_record
from .pages import write_planned
from .paper import Printed, Table
from .text import Record, number, symbol

__all__ = ["section_record", "write_section_report"]


def section_record(plan: SectionPlan, section: Section, command: str | None) -> Record:
    """Return the content of ``section.json``; the points are in ``section.csv``.

    `kept` has, for every invariant and constraint of the problem, the largest deviation at the points
    from its value where the motion began, and the largest size there.
    """
    content = plan.scene.content
    counts = np.bincount(section.motions, minlength=len(plan.states))
    record = {
        "event": {
            "name": section.name,
            "what": plan.event.what,
            "direction": plan.event.direction,
            "level": plan.event.level,
        },
        "axes": list(content.section.axes or section.axes),
        "points": len(section),
        "asked": content.section.points,
        "complete": section.complete,
        "status": section.status,
        "representation": plan.route.name,
        "time": section.problem.time,
        "step": section.step,
        "steps": section.steps,
        **method_record(section.method),
        "components": section.components,
        "motions": [
            {"initial": y.tolist(), "points": int(n), "end": _last(section, i)}
            for i, (y, n) in enumerate(zip(plan.states, counts, strict=True))
        ],
        "kept": _kept(plan, section),
        "warnings": [warning.as_json() for warning in section.warnings],
        "provenance": {**scene_record(plan.scene, command), "seed": content.section.seed},
    }
    return finite_json(record)


def _last(section: Section, motion: int) -> float | None:
    own = section.tau[section.motions == motion]
    return float(own[-1]) if len(own) else None


def _kept(plan: SectionPlan, section: Section) -> dict[str, dict[str, float]]:
    problem, kept = section.problem, {}
    for name, function in {**problem.invariants, **problem.constraints}.items():
        begin = values_at(problem, function, plan.states)[section.motions]
        here = values_at(problem, function, section.y, section.tau)
        deviation = float(np.abs(here - begin).max(initial=0.0))
        kept[name] = {"deviation": deviation, "size": float(np.abs(begin).max(initial=0.0))}
    return kept


def write_section_report(
    plan: SectionPlan,
    section: Section,
    folder: Path,
    command: str | None = None,
    paper: bool = False,
) -> Path:
    """Write the files of a section's report, all or none; return the path of the page.

    `paper`: those for a paper too.

    Raises
    ------
    OutputError
    """
    record, axes = section_record(plan, section, command), plan.scene.content.section.axes or ()
    picture, more = Picture(section.plot(*axes)), _paper(plan, record) if paper else None
    return write_planned(
        "section",
        plan,
        record,
        picture,
        section.save,
        folder,
        more,
        verdict=_verdict(record),
        colours=COLOURS,
        bounded=section.boundary is not None and not axes,
    )


def _verdict(record: Record) -> str:
    """Return what was found, in a sentence."""
    event, many = record["event"], len(record["motions"])
    way = {"up": "rises through", "down": "falls through", "both": "passes"}[event["direction"]]
    motions = "one motion" if many == 1 else f"{many} motions"
    steps = f"{record['steps']} steps of {record['step']:.6g} by {record['method']}"
    return (
        f"{record['points']} points of {motions}, where {event['what']} {way} "
        f"{event['level']:g}: {steps if record['steps'] else 'by the exact flow, without steps'}."
    )


def _paper(plan: SectionPlan, record: Record) -> Printed:
    """Return caption, table and method; the points are in ``section.csv``."""
    axes = " and ".join(record["axes"])
    caption = (
        f"{plan.scene.title}. Poincaré section in {axes}, a colour a motion: {_verdict(record)}"
    )
    columns = ["kept", "unit", "largest deviation at the points", "size"]
    rows = [
        [name, plan.route.problem.unit(name), number(kept["deviation"]), number(kept["size"])]
        for name, kept in record["kept"].items()
    ]
    method = "exact flow"
    if record["steps"]:
        step = f"step {number(record['step'], 6)} in {symbol(record['time'])}"
        method = f"{record['method']}, order {record['order']}, {step}"
    return caption, Table(columns, rows, 2), method
