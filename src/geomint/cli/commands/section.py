"""Compute a Poincaré section of a scene.

Each motion ends when it has all its points, or when it has not crossed the surface for a million
steps. A tolerance holds at the end time of the scene, which has no other effect.
"""

from dataclasses import dataclass

import numpy as np

from ...arguments import Array
from ...errors import SceneError, quoted
from ...methods import Exact
from ...plan.choice import Asked
from ...plan.planned import Planned
from ...plan.representation import route_with
from ...plan.tolerance import wanted_step
from ...plots.style import COLOURS, Picture
from ...problems.at_states import values_at
from ...reports import files_of
from ...reports.cite import cite
from ...reports.report import Images, Marked, Num, Part, Printed, Prose, Report, Table, of_warnings
from ...reports.text import Record, number, scene_facts, symbol
from ...run.events import Event
from ...run.level import states_on_level
from ...run.poincare import poincare_section
from ...run.provenance import finite_json, method_record
from ...run.section import Section
from ...scene.model import SectionSection
from ...scene.provenance import scene_record
from ...scene.scene import Scene
from ..command import STEPPED, Command, Listener, in_python


@dataclass(frozen=True, eq=False, kw_only=True)
class SectionPlan(Planned):
    """How the section of a scene is made.

    Attributes
    ----------
    route : Route
        What is integrated: the scene's own representation or one that it contains, in the same time.
    event : (str, Event)
        The surface, by its name.
    states : array, shape (motions, rows)
        Where the motions begin; the first is the scene's own.
    """

    event: tuple[str, Event]
    states: Array


def plan_section(scene: Scene) -> SectionPlan:
    """Return how the section of a scene is made.

    Raises
    ------
    SceneError, FormError, DomainError
    """
    section = scene.content.section
    name, event = _event(scene)
    asked = Asked(scene, "drift")
    route = route_with(asked, [event.what, *(section.axes or [])], "this section")
    problem, state = route.problem, route.state
    states = state[None, :]
    if section.motions > 1:
        others = states_on_level(problem, state, section.motions - 1, section.keep, section.seed)
        states = np.concatenate((states, others))
    return SectionPlan(scene=scene, route=route, event=(name, event), states=states)


def _event(scene: Scene) -> tuple[str, Event]:
    """Return the event of a section: that of ``[section]``, or the only one of ``[events]``."""
    events, section = scene.events, scene.content.section
    name = section.event or (next(iter(events)) if len(events) == 1 else None)
    if name is None:
        some = f"a component such as {scene.problem.pieces[0][0]}[0]"
        expected = f"one of {', '.join(events)}" if events else some
        raise SceneError(f"scene {quoted(scene.name)} does not say at which event: give {expected}")
    known = events.get(name, Event(name))
    level = known.level if section.level is None else section.level
    event = Event(known.what, section.direction or known.direction, level=level)
    return name if name in events else event.name, event


def run(planned: SectionPlan, listener: Listener) -> Section:
    """Return the section; after Ctrl-C what was found by then."""
    scene, route = planned.scene, planned.route
    exact = scene.content.section.exact or scene.content.integrate.exact
    own = Exact(), None
    method, step = own if exact else wanted_step(scene, route.problem, route.state)
    name, event = planned.event
    return poincare_section(
        route.problem,
        planned.states,
        {name: event},
        scene.content.section.points,
        method=method,
        step=step,
        progress=listener.progress,
    )


def section_record(planned: SectionPlan, section: Section, command: str | None) -> Record:
    """Return the content of ``section.json``; the points are in ``section.csv``.

    `kept` has, for every invariant and constraint of the problem, the largest deviation at the points
    from its value where the motion began, and the largest size there.
    """
    content, event = planned.scene.content, planned.event[1]
    counts = np.bincount(section.motions, minlength=len(planned.states))
    record = {
        "event": {
            "name": section.name,
            "what": event.what,
            "direction": event.direction,
            "level": event.level,
        },
        "axes": list(content.section.axes or section.axes),
        "points": len(section),
        "asked": content.section.points,
        "complete": section.complete,
        "status": section.status,
        "representation": planned.route.name,
        "time": section.problem.time,
        "step": section.step,
        "steps": section.steps,
        **method_record(section.method),
        "components": section.components,
        "motions": [
            {"initial": y.tolist(), "points": int(n), "end": _last(section, i)}
            for i, (y, n) in enumerate(zip(planned.states, counts, strict=True))
        ],
        "kept": _kept(planned, section),
        "warnings": [warning.as_json() for warning in section.warnings],
        "provenance": {**scene_record(planned.scene, command), "seed": content.section.seed},
    }
    return finite_json(record)


def _last(section: Section, motion: int) -> float | None:
    own = section.tau[section.motions == motion]
    return float(own[-1]) if len(own) else None


def _kept(planned: SectionPlan, section: Section) -> dict[str, dict[str, float]]:
    problem, kept = section.problem, {}
    for name, function in {**problem.invariants, **problem.constraints}.items():
        begin = values_at(problem, function, planned.states)[section.motions]
        here = values_at(problem, function, section.y, section.tau)
        deviation = float(np.abs(here - begin).max(initial=0.0))
        kept[name] = {"deviation": deviation, "size": float(np.abs(begin).max(initial=0.0))}
    return kept


def report(planned: SectionPlan, section: Section, command: str | None) -> Report:
    """Return the points, the motions, and what is kept at the points."""
    record, scene = section_record(planned, section, command), planned.scene
    axes = scene.content.section.axes or ()
    picture, verdict = Picture(section.plot(*axes)), _verdict(record)
    kept = _table(planned, record)
    blocks = [_points(record, picture, section.boundary is not None and not axes), _motions(record)]
    if record["points"] and record["kept"]:
        begins = "From the value where each motion begins; size: the largest of those values."
        form = f"{begins} Representation: {record['representation']}."
        blocks.append(Part("What is kept at the points", (kept, Prose(form))))
    caption = (
        f"{scene.title}. Poincaré section in {' and '.join(record['axes'])}, a colour a motion: "
        f"{verdict}"
    )
    method = "exact flow"
    if record["steps"]:
        step = f"step {number(record['step'], 6)} in {symbol(record['time'])}"
        method = f"{record['method']}, order {record['order']}, {step}"
    complete = section.complete
    facts = scene_facts(record["provenance"], method, planned.route.name)
    return Report(
        SECTION.files,
        "Poincaré section",
        scene.title,
        verdict,
        blocks,
        record,
        section.status if complete else "incomplete",
        alerts=[*_incomplete(record), *of_warnings(record["warnings"])],
        pictures={"section": picture},
        citation=cite(planned.route.problem, scene.method),
        csv=section.save,
        printed=Printed(caption, kept, facts),
        outcome=section.status,
        failures=() if complete else [f"not all points were found: {len(section)}"],
    )


def _incomplete(record: Record) -> list[tuple[str, str]]:
    if record["complete"]:
        return []
    interrupted = record["status"] == "interrupted"
    said = f"{record['points']} of {record['asked'] * len(record['motions'])}."
    said += (
        ""
        if interrupted
        else (" A motion that does not cross for a million steps is not followed further.")
    )
    return [(f"Not all points were found{': interrupted' * interrupted}.", said)]


def _points(record: Record, picture: Picture, bounded: bool) -> Part:
    where = "a step of the method, on its orbit" if record["steps"] else "on the exact motion"
    grey = " Grey: no motion of this energy comes there." if bounded else ""
    said = (
        f"A colour for each motion; every point is {where}.{grey} The points are in `section.csv`."
    )
    shown = Images([(picture.uri, "points of the section, a colour for each motion")], "wide")
    return Part("Points", (shown, Prose(said)))


def _motions(record: Record) -> Part:
    rows = []
    for i, motion in enumerate(record["motions"]):
        mark = Marked(str(i), COLOURS[i % len(COLOURS)])
        pairs = zip(record["components"], motion["initial"], strict=True)
        begins = ", ".join(f"{name} = {x:.6g}" for name, x in pairs)
        rows.append((mark, str(motion["points"]), Num(motion["end"]), begins))
    columns = ("motion", "points", f"last at {symbol(record['time'])}", "begins at")
    return Part("Motions", (Table(columns, rows, told=len(rows) > 1, spare=("begins at",)),))


def _table(planned: SectionPlan, record: Record) -> Table:
    columns = ("kept", "unit", "largest deviation at the points", "size")
    rows = [
        (name, planned.route.problem.unit(name), Num(kept["deviation"]), Num(kept["size"]))
        for name, kept in record["kept"].items()
    ]
    return Table(columns, rows, 2)


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


SECTION = Command(
    "section", SectionSection, plan_section, run, report, files_of("section"), STEPPED, "section"
)
section_report = in_python(SECTION)
