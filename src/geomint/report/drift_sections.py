"""The sections of the drift report, in their order.

A section is a function and a template of its name in ``templates/drift``. The function is given all
runs, one or several, and returns what the template shows; None leaves the section out.
"""

from functools import partial

from ..plan import MethodRun, SeveralRuns
from ..plots.drift_plots import panel_figure
from ..plots.style import data_uri
from ..run.solution import told_errors
from ..watch.drift import ROUNDOFF
from ..watch.growth import RULE
from ..watch.kinds import KINDS
from .kind_plots import draw_kind, draw_means_of, draw_own_kind, draw_quantity, swatch, worst
from .kinds import ByKind, by_roundoff, conserved_by_kind, kinds_in_words, names_by_kind, outcomes
from .motion_panels import motion_draws, motion_words
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
    with_error,
)

__all__ = ["SECTIONS"]

Content = Record | None
ERRORS = ("local error", "error at the end", "warnings")
COSTS = ("representation", "step", "steps", "time per step", "run time", "compile time", "status")


def head(result: SeveralRuns) -> Content:
    """Return title, failures, and what was found: by one method, or of each kind."""
    return {
        "title": result.scene.title,
        "description": " ".join(result.scene.content.description.split()),
        "methods": len(result),
        "failed": [run for run in result if run.status != "success"],
        "warned": [run for run in result if run.solution and run.solution.warnings],
        "words": outcomes(result),
        "end": _end(result),
    }


def motion(result: SeveralRuns) -> Content:
    """Return pictures of the first turns, the equations, and the parameters."""
    model = result.scene.problem if result.motion is None else result.motion.problem
    panels = [
        {"image": data_uri(panel_figure(each.draw, square=each.square)), "alt": each.words}
        for each in motion_draws(result)
    ]
    parameters = parameters_told(result.scene, model)
    if not (panels or model.equations or parameters):
        return None
    said = motion_words(result)
    return {"panels": panels, "equations": model.equations, "parameters": parameters, "said": said}


def facts(result: SeveralRuns) -> Content:
    """Return what was run: of one method, on the first screen."""
    return {"facts": _facts(result, result[0])} if len(result) == 1 else None


def kinds(result: SeveralRuns) -> Content:
    """Return a picture for each kind of quantity, a line a method."""
    found, words = conserved_by_kind(result), dict(kinds_in_words(result))
    if len(result) == 1 or not found:
        return None
    panels = [
        {
            "image": data_uri(panel_figure(partial(draw_kind, result, kind, names), roomy=True)),
            "alt": f"{KINDS[kind].title} ({', '.join(names)}) over time; {words[KINDS[kind].title]}",
        }
        for kind, names in found.items()
    ]
    return {"runs": _lines(result), "panels": panels}


def methods(result: SeveralRuns) -> Content:
    """Return the table of methods and quantities."""
    columns = [
        {
            "name": name,
            "kind": _kind_of(kind, name),
            "scale": number(max(r.drift[name].scale for r in result if name in r.drift)),
        }
        for kind, names in names_by_kind(result).items()
        for name in names
    ]
    if len(result) == 1 or not columns:
        return None
    rows = [
        {**line, "cells": [_numbers(result, run, column["name"]) for column in columns]}
        for run, line in zip(result, _lines(result), strict=True)
    ]
    return {"columns": columns, "rows": rows, "unit": symbol(result.time)}


def costs(result: SeveralRuns) -> Content:
    """Return the table of what each method took."""
    if len(result) == 1:
        return None
    rows = [(run.label, _facts(result, run)) for run in result]
    return {"tables": (COSTS, ERRORS), "rows": rows}


def quantities(result: SeveralRuns) -> Content:
    """Return for each method the table of all numbers."""
    runs = [
        {
            "label": run.label,
            "facts": _facts(result, run),
            "rows": [
                {**_numbers(result, run, name), "sort": _kind_of(kind, name)}
                for kind, names in names_by_kind(result).items()
                for name in names
                if name in run.drift
            ],
        }
        for run in result
        if run.drift
    ]
    notes = {n: drift.note for run in result for n, drift in run.drift.items() if drift.note}
    several = len(result) > 1
    if not runs:
        return None
    unit = symbol(result.time)
    units = "have the units of the problem" if result.scene.problem.units else "are dimensionless"
    return {"runs": runs, "notes": notes, "several": several, "unit": unit, "units": units}


def classes(result: SeveralRuns) -> Content:
    """Return what the classes of drift mean."""
    found = {drift.drift_class for run in result for drift in run.drift.values()}
    shown = {kind: words for kind, words in RULE.items() if kind in found}
    return {"rule": shown, "details": rule_details()} if shown else None


def over_time(result: SeveralRuns) -> Content:
    """Return pictures of what is beyond round-off, and folded those of the rest.

    Of one method each kind, with the means of the quantity that is lost most; of several each quantity.
    """
    shown, folded = by_roundoff(result)
    if not (shown or folded):
        return None
    within = ", ".join(name for names in folded.values() for name in names)
    return {
        "panels": _panels(result, shown, True),
        "folded": _panels(result, folded, False),
        "within": within,
        "several": len(result) > 1,
    }


def choices(result: SeveralRuns) -> Content:
    """Return how it was computed, and why so."""
    return {"runs": result.runs, "notes": result.scene.notes}


SECTIONS = (
    head,
    motion,
    facts,
    kinds,
    methods,
    costs,
    quantities,
    classes,
    over_time,
    choices,
)


def _panels(result: SeveralRuns, kinds: ByKind, lost: bool) -> list[dict[str, str]]:
    """Return pictures: of several methods one of each quantity, of one method one of each kind.

    Of one method those of kinds that are `lost` are followed by means, with their sign.
    """
    panels = []
    for kind, names in kinds.items():
        if len(result) > 1:
            for name in names:
                sizes = partial(draw_quantity, result, name)
                alt = f"{name}: largest deviation of each window over time, a line a method"
                panels.append({"image": data_uri(panel_figure(sizes, roomy=True)), "alt": alt})
            continue
        sizes = partial(draw_own_kind, result, kind, names)
        alt = "; ".join(_in_words(result, name) for name in names)
        panels.append({"image": data_uri(panel_figure(sizes)), "alt": alt})
        if lost:
            most = worst(result, names)
            means = partial(draw_means_of, result, most)
            alt = f"{most}: mean deviation of each window"
            panels.append({"image": data_uri(panel_figure(means)), "alt": alt})
    return panels


def _in_words(result: SeveralRuns, name: str) -> str:
    """Return what a picture of a quantity of one run shows."""
    drift = result[0].drift[name]
    return (
        f"{name}: largest deviation {number(drift.max_abs_error)}, "
        f"final {number(drift.final_error)}, {drift.drift_class} "
        f"{what_happened(drift, result.time)}".rstrip()
    )


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


def _lines(result: SeveralRuns) -> list[Record]:
    """Return the runs with their lines in all pictures."""
    return [{"run": run, "swatch": data_uri(swatch(i))} for i, run in enumerate(result)]


def _kind_of(kind: str, name: str) -> str:
    """Return what a quantity is, where its name does not say so."""
    return "" if KINDS[kind].one == name else KINDS[kind].one


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


def _numbers(result: SeveralRuns, run: MethodRun, name: str) -> dict[str, str]:
    """Return the drift of a quantity as text, or why there is none."""
    drift, solution = run.drift.get(name), run.solution
    if drift is None or solution is None:
        why = run.missing.get(name, "")
        if run.drift and not why:
            why = f"{run.representation} has no such quantity"
        return {"name": name, "kind": "", "why": why or run.status}
    vanishing = abs(drift.initial) <= ROUNDOFF * drift.scale  # 0, or what rounding left of it
    scale = f"— (scale {number(drift.scale)})"
    return {
        "name": name,
        "kind": drift.drift_class,
        "event": what_happened(drift, result.time),
        "until": watched_to(drift, run),
        "initial": number(drift.initial, 3 if vanishing else 8),
        "max_abs": number(drift.max_abs_error),
        "max_rel": scale if vanishing else number(drift.max_rel_error),
        "final": number(drift.final_error),
        "slope": with_error(drift.slope, drift.slope_stderr),
        "short_slope": short_slope(drift.slope, drift.slope_stderr),
        "bound": number(drift.trend_bound, 2),
    }
