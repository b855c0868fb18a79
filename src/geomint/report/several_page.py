"""The drift report of several methods on one scene: one page, one picture, one table."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..plan.several import MethodRun, SeveralRuns
from ..plots.style import data_uri
from ..run.provenance import environment
from ..scene.provenance import scene_record
from ..watch.growth import RULE
from ..watch.quantities import KINDS
from .drift_json import several_record, write_drift_files
from .kind_plots import kind_figure, kinds_figure, quantity_figure, swatch
from .kinds import conserved_by_kind, kinds_in_words, names_by_kind
from .pages import render
from .text import (
    duration,
    number,
    rule_details,
    short_slope,
    step_of,
    watched_to,
    what_happened,
)

__all__ = ["write_several_report"]


def write_several_report(result: SeveralRuns, folder: Path, command: str | None = None) -> Path:
    """Write ``report.html``, ``drift.json``, ``drift.png``, ``drift.svg``; return the page's path.

    Raises
    ------
    OutputError
        If the folder cannot be written; what was there is as it was.
    """
    provenance = {**environment(), **scene_record(result.scene, command)}
    record = several_record(result, provenance)
    page = several_page(result, record["provenance"])
    return write_drift_files(folder, record, kinds_figure(result), page)


def several_page(result: SeveralRuns, provenance: Mapping[str, Any]) -> str:
    """Return the page as one self-contained HTML text."""
    scene, kinds = result.scene, names_by_kind(result)
    found = {drift.drift_class for run in result for drift in run.drift.values()}
    names = [name for group in kinds.values() for name in group]
    return render(
        "drift_methods.html.j2",
        title=scene.title,
        description=" ".join(scene.content.description.split()),
        result=result,
        words=kinds_in_words(result),
        failed=[run for run in result if run.status != "success"],
        end=_end(result),
        columns=_columns(result, kinds),
        rows=[_row(run, names, i) for i, run in enumerate(result)],
        panels=_kind_panels(result),
        quantities=_quantity_panels(result, names),
        kinds=[kind for kind in RULE if kind in found],
        rule=RULE,
        rule_details=rule_details(),
        unit="τ" if result.time == "tau" else "t",
        provenance=provenance,
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


def _columns(result: SeveralRuns, kinds: Mapping[str, list[str]]) -> list[dict[str, str]]:
    """Return the heads of the table: the quantities with their kinds, initial values and scales."""
    columns = []
    for kind, names in kinds.items():
        for name in names:
            scale = max(run.drift[name].scale for run in result if name in run.drift)
            columns.append({"name": name, "kind": KINDS[kind].one, "scale": number(scale)})
    return columns


def _row(run: MethodRun, names: list[str], i: int) -> dict[str, Any]:
    """Return a method as the tables show it."""
    row: dict[str, Any] = {"run": run, "swatch": data_uri(swatch(i)), "cells": []}
    row["cells"] = [_cell(run, name) for name in names]
    plan, solution = run.plan, run.solution
    row["representation"] = "none" if plan is None else plan.route.name
    row["choices"] = () if plan is None else plan.choices
    row["step"] = row["each"] = row["total"] = row["steps"] = row["compiled"] = "–"
    if solution is not None:
        own = "τ" if solution.problem.time == "tau" else "t"
        row["step"] = f"{step_of(solution, 4)} in {own}"
        row["steps"] = f"{solution.steps:,}".replace(",", "\u202f")
        row["each"] = duration(solution.run_seconds / solution.steps) if solution.steps else "–"
        row["total"] = duration(solution.run_seconds)
        row["compiled"] = duration(solution.compile_seconds)
    return row


def _cell(run: MethodRun, name: str) -> dict[str, str]:
    drift = run.drift.get(name)
    if drift is not None:
        until = "" if run.solution is None else watched_to(drift, run.solution)
        slope = short_slope(drift.slope, drift.slope_stderr)
        return {
            "name": name,
            "kind": drift.drift_class,
            "event": "" if run.solution is None else what_happened(drift, run.solution.drift_time),
            "bound": number(drift.trend_bound, 2),
            "error": number(drift.max_abs_error),
            "slope": f"{slope} ({until})" if until else slope,
        }
    why = run.missing.get(name, "")
    if run.drift and run.plan is not None and not why:
        why = f"{run.plan.route.name} has no such quantity"
    return {"name": name, "kind": "", "error": "–", "slope": why or run.status}


def _kind_panels(result: SeveralRuns) -> list[dict[str, str]]:
    words = dict(kinds_in_words(result))
    return [
        {
            "image": data_uri(kind_figure(result, kind, names)),
            "alt": f"{KINDS[kind].title} ({', '.join(names)}) over time; {words[KINDS[kind].title]}",
        }
        for kind, names in conserved_by_kind(result).items()
    ]


def _quantity_panels(result: SeveralRuns, names: list[str]) -> list[dict[str, str]]:
    return [
        {
            "image": data_uri(quantity_figure(result, name)),
            "alt": f"{name}: largest deviation of each window over time, a line a method",
        }
        for name in names
    ]
