"""The drift report: ``report.html``, ``drift.json``, the picture, and what is for a paper."""

from pathlib import Path

from ..plan import SeveralRuns
from ..plots.style import Picture
from ..run.provenance import json_text
from ..scene.provenance import scene_record
from . import DRIFT_FILES
from .drift_json import drift_record
from .drift_paper import citation_of, drift_paper
from .drift_sections import SECTIONS
from .kind_plots import report_figure
from .pages import render, section, write_files

__all__ = ["write_drift_report"]


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
