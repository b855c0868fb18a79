"""Integrate a scene for many parameter values or initial states and plot the results.

By default all runs end at the end time of the scene.
"""

import csv
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from ...arguments import Array, Integers
from ...errors import SceneError, nearest, quoted
from ...plan.choice import Asked, Route
from ...plan.planned import Planned
from ...plan.representation import has, route_with
from ...plan.tolerance import wanted_step
from ...plots.scan_plot import Chart, scan_figure
from ...plots.style import Picture
from ...problems.problem import Problem
from ...reports import files_of
from ...reports.cite import cite
from ...reports.report import Block, Images, Listing, Num, Part, Printed, Prose, Report, Table
from ...reports.text import Record, number, scene_facts
from ...run.draws import draw_states
from ...run.ensemble.readings.of_runs import VERDICTS, ExponentErrors, Exponents, ExponentVerdict
from ...run.ensemble.readings.of_series import OfQuantity
from ...run.ensemble.readings.reading import Reading
from ...run.ensemble.readings.spelled import chosen_readings
from ...run.ensemble.result import Ensemble
from ...run.ensemble.solve_ensemble import solve_ensemble
from ...run.provenance import finite_json, method_record
from ...scene.model import EnsembleSection
from ...scene.provenance import scene_record
from ...scene.scene import Scene
from ...scene.variation import Variation, chosen_variations, told_values, varied_models
from ..command import ENDS, STEPPED, Command, Listener, in_python

MOST_KEYS = 2  # what a picture shows
OF_DRAWS = ("keep", "temperature", "seed")  # without draws they would do nothing
FEW = 20  # members that failed, or warned, as page and JSON name them


@dataclass(frozen=True, eq=False, kw_only=True)
class ScanPlan(Planned):
    """How a scan is made.

    Attributes
    ----------
    route : Route
        What is integrated, of the scene as it is.
    variations : tuple of Variation
        At most two.
    readings : dict of str to Reading
    problems : tuple of Problem
        One for each member, or one for all.
    states : array, shape (members, rows)
        Where the members begin.
    values : array, shape (members, len(variations))
        Of the numbers that vary.
    draws : array of int, shape (members,)
        Which of the random states with these values it is; 0 without draws.
    notes : tuple of str
        What was changed to make states admissible, beyond what the scene itself tells.
    """

    variations: tuple[Variation, ...]
    readings: dict[str, Reading]
    problems: tuple[Problem, ...]
    states: Array
    values: Array
    draws: Integers

    def __len__(self) -> int:
        return len(self.states)


def plan_scan(scene: Scene) -> ScanPlan:
    """Return how a scan of a scene is made.

    Raises
    ------
    SceneError, FormError, DomainError
    """
    section = scene.content.ensemble
    if scene.content.integrate.exact:
        raise SceneError(f"scene {quoted(scene.name)}: a scan takes steps: leave out exact")
    variations = tuple(chosen_variations(scene, section.vary))
    if not variations and section.draws is None:
        raise SceneError(f"scene {quoted(scene.name)}: nothing varies: give vary (--vary) or draws")
    if section.draws is None:
        for key in sorted(section.model_fields_set & {*OF_DRAWS}):
            what = f"[ensemble] {key} = {quoted(getattr(section, key))}"
            raise SceneError(
                f"scene {quoted(scene.name)}: {what}: expected draws with it (--draws)"
            )
    if len(variations) > MOST_KEYS:
        names = [v.key for v in variations]
        raise SceneError(f"vary: {quoted(names)}: expected at most {MOST_KEYS} of them")
    readings = _with_errors(chosen_readings(section.show or _usual(scene.problem)))
    asked = Asked(scene, "drift")
    route = _route(asked, readings)
    problems, states, values, draws, notes = _members(scene, route, variations)
    return ScanPlan(
        scene=scene,
        route=route,
        notes=notes,
        variations=variations,
        readings=readings,
        problems=problems,
        states=states,
        values=values,
        draws=draws,
    )


def _usual(problem: Problem) -> list[str]:
    """Return what is read off if nothing else is asked for: the drift of the first invariant."""
    names = list(problem.invariants)
    return [f"drift:{names[0]}"] if names else [f"final:{problem.pieces[0][0]}[0]"]


def _with_errors(readings: dict[str, Reading]) -> dict[str, Reading]:
    """Return readings with what says how sure exponents are, which costs nothing beside them."""
    found = {}
    for name, reading in readings.items():
        found[name] = reading
        if type(reading) is Exponents:
            for beside in (ExponentErrors(reading.count), ExponentVerdict(reading.count)):
                found.setdefault(beside.name, beside)
    return found


def _route(asked: Asked, readings: dict[str, Reading]) -> Route:
    """Return what is integrated: for exponents the scene's own, of which a part has other ones."""
    names = [reading.of for reading in readings.values() if isinstance(reading, OfQuantity)]
    problems = asked.model.problems.values()
    for name in names:
        if not any(has(problem, name) for problem in problems):
            pieces = [(p, rows) for problem in problems for p, rows in problem.pieces]
            known = dict.fromkeys(f"{p}[{i}]" for p, rows in pieces for i in range(rows))
            known |= dict.fromkeys(q for problem in problems for q in problem.diagnostics)
            raise SceneError(f"show: {quoted(name)}: no such quantity.{nearest(name, [*known])}")
    own = asked.scene.content.integrate.representation is None and any(
        isinstance(reading, Exponents) for reading in readings.values()
    )
    if own:
        asked = Asked(asked.scene.changed_integration(representation="own"), asked.purpose)
    return route_with(asked, names, "this scan", asked.end)


def _members(
    scene: Scene, route: Route, variations: Sequence[Variation]
) -> tuple[tuple[Problem, ...], Array, Array, Integers, tuple[str, ...]]:
    """Return problems and states of all members, the numbers that vary, the draws, and notes."""
    section, states = scene.content.ensemble, []
    problems: list[Problem] = []
    values: list[tuple[float, ...]] = []
    changed = []
    for numbers, model, note in varied_models(scene, variations):
        if route.name not in model.problems:
            where = told_values(variations, numbers)
            raise SceneError(f"with {where}: the system has no representation {route.name!r}")
        problem, state = model.problems[route.name], model.states[route.name]
        if problem.pieces != (problems or [problem])[0].pieces:
            where, before = told_values(variations, numbers), told_values(variations, values[0])
            raise SceneError(f"with {where}: the state has other pieces than with {before}")
        drawn = state[None, :]
        if section.draws is not None:
            drawn = draw_states(
                problem,
                section.draws,
                at=state,
                keep=section.keep,
                temperature=section.temperature,
                seed=section.seed,
            )
        if note and note not in scene.notes:
            changed.append(f"with {told_values(variations, numbers)}: {note}")
        problems.append(problem)
        states.append(drawn)
        values.append(numbers)
    each = len(states[0])
    found = np.repeat(np.array(values).reshape(len(values), -1), each, axis=0)
    repeated = [problem for problem in problems for _ in range(each)]
    many = tuple(repeated if variations else problems)
    draws = np.tile(np.arange(each), len(states))
    notes = (
        (f"{len(changed)} of {len(values)} states were changed; {changed[0]}",) if changed else ()
    )
    return many, np.concatenate(states), found, draws, notes


def run(planned: ScanPlan, listener: Listener) -> Ensemble:
    """Integrate all members; after Ctrl-C with those that are done."""
    scene = planned.scene
    method, step = wanted_step(scene, planned.route.problem, planned.route.state)
    return solve_ensemble(
        planned.problems,
        planned.states,
        **scene.content.time.end,
        method=method,
        step=step,
        save_every=scene.content.save.every,
        readings=planned.readings,
        progress=listener.progress,
        workers=scene.content.ensemble.workers,
    )


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


def scan_record(planned: ScanPlan, many: Ensemble, command: str | None) -> Record:
    """Return the content of ``scan.json``; the members are in ``scan.csv``.

    `readings` has least, median and largest values over the members, and how many have one;
    `verdicts`, of exponents, the members that are ``"regular"``: compatible with 0, and so on.
    """
    section = planned.scene.content.ensemble
    record = {
        "members": len(many),
        "status": scan_status(many),
        "statuses": dict(Counter(many.status.tolist())),
        "vary": {v.key: v.values.tolist() for v in planned.variations},
        "draws": section.draws,
        "readings": {name: _summary(values) for name, values in _columns(many).items()},
        "verdicts": _verdicts(many),
        "failed": [
            {"member": k, **_place(planned, k), "error": str(error)}
            for k, error in sorted(many.errors.items())[:FEW]
        ],
        "failures": len(many.errors),
        "warnings": [
            {"member": k, **_place(planned, k), **warning.as_json()}
            for k, told in sorted(many.warnings.items())[:FEW]
            for warning in told
        ],
        "warned": len(many.warnings),
        "representation": planned.route.name,
        "time": planned.route.problem.time,
        "steps": int(many.steps.sum()),
        "run_seconds": many.run_seconds,
        **method_record(planned.scene.method),
        "notes": list(planned.notes),
        "provenance": {**scene_record(planned.scene, command), "seed": section.seed},
    }
    return finite_json(record)


def _place(planned: ScanPlan, k: int) -> dict[str, float]:
    pairs = zip(planned.variations, planned.values[k], strict=True)
    return {variation.key: float(value) for variation, value in pairs}


def _summary(values: Array) -> Record:
    known = values[np.isfinite(values)]
    if not len(known):
        return {"known": 0, "least": None, "median": None, "largest": None}
    least, median, largest = np.quantile(known, [0.0, 0.5, 1.0])
    return {"known": len(known), "least": least, "median": median, "largest": largest}


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


def _save(planned: ScanPlan, many: Ensemble, path: Path) -> None:
    columns = _columns(many)
    names = [*(v.key for v in planned.variations), "draw", "status", "warnings", *columns]
    warned = many.warned.tolist()
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(["member", *names])
        for k, status in enumerate(many.status):
            numbers = (column[k].item() for column in columns.values())
            row = [
                k,
                *planned.values[k].tolist(),
                int(planned.draws[k]),
                status,
                warned[k],
                *numbers,
            ]
            writer.writerow(row)


def report(planned: ScanPlan, many: Ensemble, command: str | None) -> Report:
    """Return a picture of the readings, and their least, median and largest values."""
    record, scene = scan_record(planned, many, command), planned.scene
    columns = _columns(many)
    beside = (ExponentErrors.kind, ExponentVerdict.kind)
    drawn = {k: v for k, v in columns.items() if not k.startswith(beside)} or columns
    chart = Chart(
        [v.key for v in planned.variations],
        [v.values for v in planned.variations],
        drawn,
        planned.route.problem.time,
        _bars(columns),
    )
    picture, runs, status = Picture(scan_figure(chart)), _runs(record), record["status"]
    rows = [
        (name, *(Num(row[key], 4) for key in ("least", "median", "largest")), str(row["known"]))
        for name, row in record["readings"].items()
    ]
    readings = Table(("reading", "least", "median", "largest", "runs with a value"), rows)
    statuses = ", ".join(f"{n} {word}" for word, n in record["statuses"].items())
    cost = f"{record['steps']} steps by {record['method']} in {record['run_seconds']:.3g} s"
    blocks = [
        *(Prose(note) for note in record["notes"]),
        Part(_heading(record), (_image(record, picture, chart), Prose(_shown(record)))),
        Part("Readings", (readings, *_said(record), Prose(f"{cost}; {_form(record)}."))),
        *_members_told(record, "failures", "failed", "error"),
        *_members_told(record, "warned", "warnings", "text"),
    ]
    method = f"{record['method']}, order {record['order']}, {record['steps']} steps in all"
    facts = scene_facts(record["provenance"], method, planned.route.name)
    failures = []
    if many.errors:
        k, error = next(iter(sorted(many.errors.items())))
        failures.append(f"{len(many.errors)} of {len(many)} members failed; {k}: {error}")
    return Report(
        SCAN.files,
        "Scan",
        scene.title,
        f"{record['members']} runs: {runs}{' each' if record['draws'] and record['vary'] else ''}.",
        blocks,
        record,
        status,
        f"{_counted(record)}: {statuses}\n{cost}",
        alerts=[] if status == "success" else [(f"Not all of the scan: {status}:", f"{statuses}.")],
        pictures={"scan": picture},
        citation=cite(planned.route.problem, scene.method),
        csv=partial(_save, planned, many),
        printed=Printed(f"{scene.title}: {record['members']} runs ({runs}).", readings, facts),
        failures=failures,
    )


def _runs(record: Record) -> str:
    """Return in words what varies."""
    varied = " × ".join(
        f"{len(values)} values of {key} from {number(values[0], 6)} to {number(values[-1], 6)}"
        for key, values in record["vary"].items()
    )
    drawn = f"{record['draws']} random states" if record["draws"] else ""
    return ", ".join(filter(None, (varied, drawn)))


def _counted(record: Record) -> str:
    varied = [f"{key}: {len(values)} values" for key, values in record["vary"].items()]
    drawn = [f"{record['draws']} draws"] if record["draws"] else []
    return f"{record['members']} members ({'; '.join(varied + drawn)})"


def _form(record: Record) -> str:
    return f"representation: {record['representation']}"


def _heading(record: Record) -> str:
    if len(record["vary"]) == MOST_KEYS:
        return "Map"
    return f"Over {next(iter(record['vary']))}" if record["vary"] else "Distribution"


def _image(record: Record, picture: Picture, chart: Chart) -> Images:
    over = "".join(f", over {key}" for key in record["vary"])
    said = f"what was read off the runs{over}: {', '.join(chart.drawn)}"
    return Images([(picture.uri, said)], "wide")


def _shown(record: Record) -> str:
    said, vary = "", record["vary"]
    if record["draws"] and len(vary) == 1:
        said = "Line: the median of the draws; bands: half of them, and 90 of 100. "
    elif record["draws"] and vary:
        said = "Of each cell the median of its draws. "
    grey = "Grey: no value. " if len(vary) == MOST_KEYS else ""
    return f"{said}{grey}The numbers are in `scan.csv`, a row for each run."


def _said(record: Record) -> list[Block]:
    if not record["verdicts"]:
        return []
    words = _told_verdicts(record)
    how = "`chaotic` is 1, 0, and ½ in `scan.csv`. An error is one standard error, by parts of the run."
    return [Prose(f"{words[0].upper()}{words[1:]}: {how}", small=False)]


def _members_told(record: Record, count: str, rows: str, why: str) -> list[Block]:
    """Return a list of members that failed, or that have warnings."""
    if not record[count]:
        return []
    lines = [
        "".join(
            [str(row["member"]), *(f", {key} = {number(row[key], 6)}" for key in record["vary"])]
        )
        + f": {row[why]}"
        for row in record[rows]
    ]
    first = f"{record[count]} of {record['members']}"
    if rows == "warnings":
        first += "; kinds in `scan.csv`. The first:"
    else:
        first += f"; the first {len(lines)}:" if record[count] > len(lines) else ":"
    heading = "Runs that failed" if rows == "failed" else "Runs with warnings"
    return [Part(heading, (Prose(first, small=False), Listing(lines)))]


SCAN = Command(
    "scan",
    EnsembleSection,
    plan_scan,
    run,
    report,
    files_of("scan"),
    (*STEPPED, *ENDS),
    key="ensemble",
)
scan_report = in_python(SCAN)
