"""The drift report: what one or several methods kept of a motion, and how well."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from ..plan import MethodRun, SeveralRuns
from ..plots.drift_plots import panel_figure
from ..plots.style import Picture, data_uri
from ..run.provenance import finite_json, run_record
from ..run.solution import Solution, told_errors
from ..watch.drift import ROUNDOFF
from ..watch.growth import RULE
from ..watch.kinds import KINDS
from ..watch.quantities import kind_of
from . import DRIFT_FILES
from .drift_paper import citation_of, drift_paper
from .kind_plots import (
    draw_kind,
    draw_means_of,
    draw_own_kind,
    draw_quantity,
    report_figure,
    swatch,
    worst,
)
from .kinds import ByKind, by_roundoff, conserved_by_kind, kinds_in_words, names_by_kind, outcomes
from .motion_panels import motion_draws, motion_words
from .report import (
    SHOWN,
    Block,
    Cell,
    Code,
    Facts,
    Folded,
    Images,
    Legend,
    Marked,
    Num,
    Part,
    Prose,
    Report,
    Small,
    Stack,
    Table,
    Verdict,
    Words,
)
from .text import (
    Record,
    duration,
    number,
    parameters_told,
    rule_details,
    short_slope,
    step_of,
    symbol,
    watched_to,
    what_happened,
)

__all__ = ["drift_record", "drift_report_of", "told_report"]

ERRORS = ("local error", "error at the end", "warnings")
COSTS = ("representation", "step", "steps", "time per step", "run time", "compile time", "status")
LEVEL = (
    "Round-off means 32 ε × scale. ε = 2⁻⁵², about 2.2e-16, is the spacing of numbers near 1. The "
    "scale of a quantity is the most by which it changes when each number of the state is rounded "
    "once, divided by ε."
)


def drift_record(result: SeveralRuns, provenance: Record) -> Record:
    """Return the content of ``drift.json``.

    Under `methods`, every one has its `quantities`, `missing` (quantities that its representation
    does not have, and why), `representation`, `status` and `message`, and all about its `run`: null
    if nothing was computed.

    Every quantity has `initial`, `max_abs_error`, `max_rel_error` (null where the initial value is
    0; `scale` is then what to compare with), `final_error`, `slope` per unit of `time`, in which the
    scene's end is given, `slope_stderr`, `trend_bound` (the largest rise or fall over the run that
    is not excluded at 95 %), `jump_size`, `jump_time`, `not_finite_from` and `class`. All numbers
    are finite or null.
    """
    problems = [run.plan.problem for run in result if run.plan is not None]
    names = dict.fromkeys(name for run in result for name in (*run.drift, *run.missing))
    return {
        "methods": {run.label: _method_entry(run) for run in result},
        "kinds": {name: kind_of(name, result.scene.problem, *problems) for name in names},
        "time": result.time,
        "physical_end": result.physical_end,
        "status": result.status,
        "provenance": finite_json(provenance),
    }


def _method_entry(run: MethodRun) -> Record:
    return {
        "status": run.status,
        "message": run.message,
        "representation": run.representation,
        "quantities": {name: finite_json(drift.as_json()) for name, drift in run.drift.items()},
        "missing": run.missing,
        "run": None if run.solution is None else finite_json(run_record(run.solution)),
    }


def drift_report_of(result: SeveralRuns, provenance: Record) -> Report:
    """Return the report on one or several methods."""
    several = len(result) > 1
    record = drift_record(result, provenance)
    parts = _of_several(result) if several else [Facts(_facts(result, result[0]))]
    blocks = [*_motion(result), *parts, *_quantities(result), *_classes(result)]
    blocks += [*_over_time(result), _choices(result)]
    description = " ".join(result.scene.content.description.split())
    end = f"All runs end at {_end(result)}."
    return Report(
        DRIFT_FILES,
        f"Drift report, {len(result)} methods" if several else "Drift report",
        result.scene.title,
        found_words(result),
        blocks,
        record,
        result.status,
        told_runs(result),
        lead=[description] * bool(description) + [end] * several,
        alerts=list(_alerts(result)),
        pictures={"drift": Picture(report_figure(result))},
        citation=citation_of(result),
        printed=drift_paper(result, record["provenance"]),
    )


def told_report(result: SeveralRuns) -> Report:
    """Return what a terminal shows of runs that have no report of their own."""
    tables = [quantities_of(result, run) for run in result if run.drift]
    alerts = [(run.title, run.message) for run in result if run.status != "success"]
    words = found_words(result)
    summary = told_runs(result)
    return Report((), "run", result.scene.title, words, tables, {}, summary=summary, alerts=alerts)


def found_words(result: SeveralRuns) -> str | list[tuple[str, str]]:
    """Return what was found: of one method in sentences, of several by kinds."""
    found = outcomes(result)
    if len(result) > 1 and found:
        return found
    return found[0][1] if found else "No quantity was watched."


def _alerts(result: SeveralRuns) -> Iterator[tuple[str, str]]:
    """Yield which runs did not reach their ends, and what was warned of."""
    for run in result:
        if run.status != "success":
            said = f"{run.message}." if run.message else ""
            if run.solution is not None and run.status != "not finite":
                steps = f"the {run.solution.steps} steps that were computed"
                said += f" What follows is about {steps}."
            lost = ", not a success" if run.status == "not finite" else ""
            yield f"{run.label}: {run.status}{lost}.", said.strip()
    for run in result:
        for warning in run.solution.warnings if run.solution else ():
            yield f"{run.label}: {warning.kind}.", f"{warning}."


# --- what was run ------------------------------------------------------------------------------------


def told_runs(result: SeveralRuns) -> str:
    """Return what was run, for terminals: a line or more for each method."""
    lines = []
    for run in result:
        if run.solution is not None:
            lines.append(_cost(run.solution))
            lines += [f"{name}: {what}" for name, what in told_errors(run.solution).items()]
            lines += [_events(run.solution)] * bool(run.solution.events)
    return "\n".join(lines)


def _cost(solution: Solution) -> str:
    """Return a line on what a run took; of an exact motion what was followed."""
    if solution.route and not solution.steps:
        return solution.route
    seconds, steps = solution.run_seconds, solution.steps
    rate = steps / seconds if seconds > 0.0 else 0.0
    return (
        f"{solution.method.name}, step {step_of(solution)}, {steps} steps in {seconds:.3g} s "
        f"({rate:.3g} a second), {solution.evaluations:.4g} field evaluations"
    )


def _events(solution: Solution) -> str:
    """Return how often each event happened, and whether one of them ended the run."""
    counts = ", ".join(f"{name} {len(met)}" for name, met in solution.events.items())
    return f"events: {counts}" + (f"; {solution.message}" if solution.success else "").rstrip("; ")


def _facts(result: SeveralRuns, run: MethodRun) -> dict[str, str]:
    """Return what was run, and what it took."""
    found = {"system": result.scene.content.system.name}
    found["representation"] = run.representation or "none"
    solution = run.solution
    if solution is None:
        return {**dict.fromkeys((*COSTS, *ERRORS), "–"), **found, "status": run.status}
    method, problem, seconds = solution.method, solution.problem, solution.run_seconds
    structure = method.structure(problem)
    pieces = ", ".join(f"{name} ({rows})" for name, rows in problem.pieces)
    options = ", ".join(f"{key} = {value}" for key, value in method.options.items())
    steps, compiling = max(solution.steps, 1), duration(solution.compile_seconds)
    return {
        **found,
        "state": f"{problem.name}: {pieces}",
        "method": f"{method.name}, order {method.order}{', ' + structure if structure else ''}",
        "options": options or "none",
        "step": f"{step_of(solution, 10)} in {symbol(problem.time)}",
        "steps": f"{solution.steps:,}".replace(",", "\u202f"),
        "end": _end(result).partition(",")[0],
        "field evaluations": f"{solution.evaluations:,}".replace(",", "\u202f"),
        "iterations": f"{solution.iterations:,}".replace(",", "\u202f"),
        "time per step": duration(seconds / steps),
        "steps a second": f"{steps / seconds:.2g}" if seconds > 0.0 else "–",
        "run time": duration(seconds),
        "watching": duration(solution.watching_seconds),
        "compile time": compiling if solution.compile_seconds > 0.0 else "from the cache",
        **dict.fromkeys(ERRORS, "–"),
        **told_errors(solution),
        "status": run.status,
    }


def _end(result: SeveralRuns) -> str:
    """Return where all runs end, in words."""
    time = result.scene.content.time
    if time.tau_end is None:
        return f"t = {time.t_end:g}"
    if result.physical_end is None:
        return f"τ = {time.tau_end:g}"
    return (
        f"τ = {time.tau_end:g}, which is t = {result.physical_end:.10g}; methods that work in t run "
        f"to there, and their curves and slopes are over τ at the mean rate"
    )


def _motion(result: SeveralRuns) -> list[Block]:
    """Return pictures of the first turns, the equations, and the parameters."""
    model = result.scene.problem if result.motion is None else result.motion.problem
    blocks: list[Block] = []
    panels = [
        (data_uri(panel_figure(each.draw, square=each.square)), each.words)
        for each in motion_draws(result)
    ]
    if panels:
        blocks += [Images(panels, "panels motion"), Prose(motion_words(result))]
    if model.equations:
        blocks.append(Code("\n".join(model.equations), "equations"))
    parameters = parameters_told(result.scene, model)
    if parameters:
        blocks.append(Facts(parameters))
    return [Part("The motion", tuple(blocks))] if blocks else []


def _choices(result: SeveralRuns) -> Part:
    """Return how it was computed, and why so."""
    blocks: list[Block] = []
    for run in result:
        if run.plan is None:
            blocks.append(Prose(f"{run.label}: {run.message}", small=False))
            continue
        rows = [(choice.what, choice.value, choice.reason) for choice in run.plan.choices]
        table = Table((), rows, kind="plan", told=False)
        blocks.append(Folded(run.label, (table,)) if len(result) > 1 else table)
    notes = [Prose(f"Note: {note}.") for note in result.scene.notes]
    return Part("How it was computed, and why so", (*blocks, *notes))


# --- several methods ---------------------------------------------------------------------------------


def _of_several(result: SeveralRuns) -> list[Block]:
    """Return pictures of kinds, the table of methods and quantities, and what each method took."""
    rows = [(run.label, _facts(result, run)) for run in result]
    costs = [
        Table(("method", *names), [(label, *(facts[n] for n in names)) for label, facts in rows],
              len(names) + 1, told=False)
        for names in (COSTS, ERRORS)
    ]  # fmt: skip
    said = (
        "Run time is the time in the stepper, without watching and compiling. The local error is that "
        "of the worst step, of a number relative to the largest of its piece; the error at the end "
        "likewise, where a second run tells it."
    )
    return [
        *_kinds(result),
        *_matrix(result),
        Part("What it cost, and errors", (*costs, Prose(said))),
    ]


def _kinds(result: SeveralRuns) -> list[Block]:
    found, words = conserved_by_kind(result), dict(kinds_in_words(result))
    panels = [
        (
            data_uri(panel_figure(partial(draw_kind, result, kind, names), roomy=True)),
            f"{KINDS[kind].title} ({', '.join(names)}) over time; {words[KINDS[kind].title]}",
        )
        for kind, names in found.items()
    ]
    said = (
        "Each line shows the largest deviation from the initial value, relative to its scale, of the "
        "quantities of its kind, in intervals of equal length on this axis; where it is exactly 0 "
        f"there is a gap. The dashed line is round-off. {LEVEL}"
    )
    lines = [Marked(run.title, data_uri(swatch(i))) for i, run in enumerate(result)]
    return [Part("Kinds of drift", (Legend(lines), Images(panels), Prose(said)))] if found else []


def _matrix(result: SeveralRuns) -> list[Block]:
    columns = [(n, kind) for kind, names in names_by_kind(result).items() for n in names]
    if not columns:
        return []
    headings: list[Cell] = [Stack((name, Small(_kind_of(kind, name)))) for name, kind in columns]
    rows: list[list[Cell]] = [
        [Marked(run.label, data_uri(swatch(i))), *(_cell(result, run, name) for name, _ in columns)]
        for i, run in enumerate(result)
    ]
    scales = [max(r.drift[n].scale for r in result if n in r.drift) for n, _ in columns]
    rows.append([Small("scale"), *(Small(number(scale)) for scale in scales)])
    said = (
        "In each cell: the largest deviation from the initial value; the class of its growth; the "
        f"slope per unit of {symbol(result.time)} with its standard error; the largest rise or fall "
        "of the means over the run that the data do not exclude at 95 %."
    )
    table = Table(["method", *headings], rows, kind="quantities matrix", told=False)
    return [Part("Method by method", (table, Prose(said)))]


def _cell(result: SeveralRuns, run: MethodRun, name: str) -> Stack:
    drift = run.drift.get(name)
    if drift is None or run.solution is None:
        why = run.missing.get(name, "")
        if run.drift and not why:
            why = f"{run.representation} has no such quantity"
        return Stack(("–", Small(why or run.status)))
    until = watched_to(drift, run)
    slope = short_slope(drift.slope, drift.slope_stderr) + (f" ({until})" if until else "")
    return Stack(
        (
            Num(drift.max_abs_error),
            Verdict(drift.drift_class),
            Small(what_happened(drift, result.time)),
            Small(slope),
            Small(str(Num(drift.trend_bound, 2, bound=True))),
        )
    )


def _kind_of(kind: str, name: str) -> str:
    """Return what a quantity is, where its name does not say so."""
    return "" if KINDS[kind].one == name else KINDS[kind].one


# --- quantities --------------------------------------------------------------------------------------


def quantities_of(result: SeveralRuns, run: MethodRun) -> Table:
    """Return the table of all numbers of a run: a row a quantity."""
    columns = ["quantity", "initial", "max |error|", "max rel. error", "final error"]
    columns += (f"slope per unit of {symbol(result.time)}", "trend ≤", "class")
    rows = [
        _numbers(result, run, kind, name)
        for kind, names in names_by_kind(result).items()
        for name in names
        if name in run.drift
    ]
    return Table(
        columns, rows, spare=("max rel. error", "initial", "final error", *columns[-2:-4:-1])
    )


def _numbers(result: SeveralRuns, run: MethodRun, kind: str, name: str) -> list[Cell]:
    drift, until = run.drift[name], watched_to(run.drift[name], run)
    vanishing = abs(drift.initial) <= ROUNDOFF * drift.scale  # 0, or what rounding left of it
    rounded = f"— (scale {number(drift.scale)})"
    return [
        Stack((f"{name} ({until})" if until else name, Small(_kind_of(kind, name)))),
        Num(drift.initial, 3 if vanishing else 8),
        Num(drift.max_abs_error),
        rounded if vanishing else Num(drift.max_rel_error),
        Num(drift.final_error),
        short_slope(drift.slope, drift.slope_stderr),
        Num(drift.trend_bound, 2),
        Stack((Verdict(drift.drift_class), Small(what_happened(drift, result.time)))),
    ]


def _quantities(result: SeveralRuns) -> list[Block]:
    """Return for each method the table of all numbers."""
    blocks: list[Block] = []
    for run in result:
        if run.drift:
            table = quantities_of(result, run)
            folded = Folded(run.label, (Facts(_facts(result, run)), table))
            blocks.append(folded if len(result) > 1 else table)
    if not blocks:
        return []
    units = "have the units of the problem" if result.scene.problem.units else "are dimensionless"
    said = (
        f"Errors are deviations from the initial value; all quantities {units}. Where the initial "
        "value is 0 up to rounding there is no relative error; the scale says what rounding is "
        f"measured against. {LEVEL} The trend is the largest rise or fall of the means, "
        "from start to end, that the data do not exclude at 95 %, beside oscillations and jumps."
    )
    notes = {n: drift.note for run in result for n, drift in run.drift.items() if drift.note}
    blocks += [Prose(said), *(Prose(f"{name}: {note}") for name, note in notes.items())]
    return [Part("What was kept, and how well", tuple(blocks))]


def _classes(result: SeveralRuns) -> list[Block]:
    """Return what the classes of drift mean."""
    found = {drift.drift_class for run in result for drift in run.drift.values()}
    shown = [
        (Verdict(kind), f"{words} In JSON and Python: {kind}." if kind in SHOWN else words)
        for kind, words in RULE.items()
        if kind in found
    ]
    rule = Folded("The rule by which the class is decided", (Code(rule_details()),))
    return [Words(shown), rule] if shown else []


def _over_time(result: SeveralRuns) -> list[Block]:
    """Return pictures of what is beyond round-off, and folded those of the rest.

    Of one method each kind, with the means of the quantity that is lost most; of several each quantity.
    """
    shown, small = by_roundoff(result)
    if not (shown or small):
        return []
    said = (
        "Left: the largest deviation from the initial value in each window of steps, a line a "
        "quantity; where a kind has several they are relative to their scales. The dashed line is the "
        "round-off level. Right: the mean deviation of each window, with its sign, of the quantity "
        "that is lost most."
    )
    if len(result) > 1:
        said = (
            "The largest deviation, not scaled; lines and intervals as above. The dashed line is the "
            "round-off level."
        )
    blocks: list[Block] = [Prose(said)]
    panels = _panels(result, shown, True)
    blocks.append(Images(panels) if panels else Prose("Nothing is beyond round-off.", small=False))
    if small:
        within = ", ".join(name for names in small.values() for name in names)
        images = Images(_panels(result, small, False))
        blocks.append(Folded(f"No larger than round-off: {within}", (images,)))
    return [Part("Each quantity" if len(result) > 1 else "Over time", tuple(blocks))]


def _panels(result: SeveralRuns, kinds: ByKind, lost: bool) -> list[tuple[str, str]]:
    """Return pictures: of several methods one of each quantity, of one method one of each kind.

    Of one method those of kinds that are `lost` are followed by means, with their sign.
    """
    panels = []

    def draw(function: Any, alt: str, roomy: bool = False) -> None:
        panels.append((data_uri(panel_figure(function, roomy=roomy)), alt))

    for kind, names in kinds.items():
        if len(result) > 1:
            for name in names:
                said = f"{name}: largest deviation of each window over time, a line a method"
                draw(partial(draw_quantity, result, name), said, roomy=True)
            continue
        draw(
            partial(draw_own_kind, result, kind, names),
            "; ".join(_in_words(result, name) for name in names),
        )
        if lost:
            most = worst(result, names)
            draw(partial(draw_means_of, result, most), f"{most}: mean deviation of each window")
    return panels


def _in_words(result: SeveralRuns, name: str) -> str:
    """Return what a picture of a quantity of one run shows."""
    drift = result[0].drift[name]
    return (
        f"{name}: largest deviation {number(drift.max_abs_error)}, "
        f"final {number(drift.final_error)}, {drift.drift_class} "
        f"{what_happened(drift, result.time)}".rstrip()
    )
