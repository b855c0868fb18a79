"""The drift report: ``report.html``, ``drift.json``, the picture, and what is for a paper."""

from pathlib import Path

from ..plan import MethodRun, SeveralRuns
from ..plots.style import Picture
from ..run.provenance import finite_json, json_text, run_record
from ..scene.provenance import scene_record
from ..watch.quantities import kind_of
from . import DRIFT_FILES
from .drift_paper import citation_of, drift_paper
from .drift_sections import SECTIONS
from .kind_plots import report_figure
from .pages import render, section, write_files
from .text import Record

__all__ = ["drift_record", "write_drift_report"]


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


def write_drift_report(
    result: SeveralRuns, folder: Path, command: str | None = None, paper: bool = False
) -> Path:
    """Write the files of a report on one or several methods; return the path of the page.

    `paper`: those for a paper too.

    Raises
    ------
    OutputError
        If the folder cannot be written; what was there is as it was.
    """
    record = drift_record(result, scene_record(result.scene, command))
    page = render(
        "drift.html.j2",
        title=result.scene.title,
        sections=[section(f"drift/{f.__name__}.html.j2", f(result)) for f in SECTIONS],
        provenance=record["provenance"],
        citation=citation_of(result),
    )
    pictures = {"drift": Picture(report_figure(result))}
    more = drift_paper(result, record["provenance"]) if paper else None
    return write_files(folder, DRIFT_FILES, page, json_text(record), pictures, paper=more)
