"""``drift.json``: the numbers of a drift report, and its folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..plan.several import MethodRun, SeveralRuns
from ..plots.style import save_figure
from ..run.files.outputs import whole_folder
from ..run.provenance import finite_json, json_text, run_record
from ..watch.drift import Drift
from ..watch.quantities import kind_of
from . import DRIFT_FILES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["drift_record", "several_record", "write_drift_files"]


def drift_record(drifts: Mapping[str, Drift], provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of ``drift.json``.

    Every quantity has `initial`, `max_abs_error`, `max_rel_error` (null where the initial value is
    0; `scale` is then what to compare with), `final_error`, `slope` per unit of the scene's time,
    `slope_stderr`, `trend_bound` (the largest rise or fall over the run that is not excluded at 95 %),
    `jump_size`, `jump_time`, `not_finite_from` and `class`. All numbers are finite or null.
    """
    return {
        "status": provenance.get("status"),
        "quantities": {name: finite_json(drift.as_json()) for name, drift in drifts.items()},
        "provenance": finite_json(provenance),
    }


def several_record(result: SeveralRuns, provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Return the content of ``drift.json`` for several methods.

    Under `methods`, every one has its `quantities` as in the record of a single method, `missing`
    (quantities that its representation does not have, and why), `representation`, `status` and
    `message`, and all about its `run`: null if nothing was computed. All slopes are per unit of
    `time`, the time in which the scene's end is given.
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


def _method_entry(run: MethodRun) -> dict[str, Any]:
    return {
        "status": run.status,
        "message": run.message,
        "representation": None if run.plan is None else run.plan.route.name,
        "quantities": {name: finite_json(drift.as_json()) for name, drift in run.drift.items()},
        "missing": run.missing,
        "run": None if run.solution is None else finite_json(run_record(run.solution)),
    }


def write_drift_files(folder: Path, record: Mapping[str, Any], figure: Figure, page: str) -> Path:
    """Write ``drift.json``, ``drift.png``, ``drift.svg``, ``report.html``; return the page's path."""
    with whole_folder(folder, DRIFT_FILES) as unfinished:
        (unfinished / "drift.json").write_text(json_text(record), encoding="utf-8")
        save_figure(figure, unfinished, "drift")
        (unfinished / "report.html").write_text(page, encoding="utf-8")
    return folder / "report.html"
