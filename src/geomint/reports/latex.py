"""What of a report goes into a paper: vector figures, a table and a caption in LaTeX, BibTeX, data.

Figures are as wide as a column, or as a page of two where panels stand side by side. All fonts have
8 points and are embedded as TrueType (Type 42), as journals ask for. LaTeX and BibTeX are in ASCII.
"""

from __future__ import annotations

import csv
import functools
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..plots.style import figure_style
from ..references.latex import latex_cell
from .report import Cell, Printed, Report, Table

if TYPE_CHECKING:
    from jinja2 import Environment
    from matplotlib.figure import Figure

COLUMN, PAGE = 8.6 / 2.54, 17.8 / 2.54  # inches
POINTS = 8.0  # of all letters
LETTERS = 62  # in a row of a table in a column
TALLER = 1.25  # than in proportion: letters do not shrink with the width
LOWEST = 5.4 / 2.54  # inches
COVERED = 0.25  # of its panel: a legend that is larger goes above the figure


def write_paper(report: Report, printed: Printed, folder: Path) -> None:
    """Write what of a report is for a paper; its figures get another size, and serve nothing else."""
    stem, citation = report.stem, report.citation
    assert citation is not None
    wide = {
        name: save_for_print(picture.figure, folder / f"{name}.pdf")
        for name, picture in report.pictures.items()
    }
    given = {
        "stem": stem,
        "caption": printed.caption,
        "table": printed.table,
        "wide": _is_wide(printed.table),
        "alignment": "l" * printed.table.words
        + "r" * (len(printed.table.columns) - printed.table.words),
        "provenance": printed.facts,
        "keys": {what: citation.keys(what.lower()) for what in printed.facts},
        "names": ", ".join(f"{name}.pdf" for name in wide),
        "figures": wide,
        "command": report.provenance["command"],
    }
    files = {"table": "table", "caption": "caption", "document": "paper"}
    for kind, file in files.items():
        text = _environment().get_template(f"paper/{kind}.tex.j2").render(given)
        (folder / f"{stem}-{file}.tex").write_text(text, encoding="ascii")
    (folder / f"{stem}.bib").write_text(citation.bibtex, encoding="ascii")
    if printed.data is not None:
        with (folder / f"{stem}.csv").open("w", newline="", encoding="utf-8") as stream:
            csv.writer(stream).writerows(printed.data)


def _is_wide(table: Table) -> bool:
    """Tell whether a table needs the width of a page."""
    lines = [table.columns, *table.rows]
    widths = (max(len(str(line[k])) for line in lines) + 2 for k in range(len(table.columns)))
    return sum(widths) > LETTERS


def save_for_print(figure: Figure, path: Path) -> bool:
    """Write a figure as PDF, as wide as a column, or as a page; tell whether it is the page."""
    import matplotlib as mpl
    from matplotlib.text import Text

    specs = [axes.get_subplotspec() for axes in figure.axes]
    wide = any(spec is not None and spec.get_gridspec().ncols > 1 for spec in specs)
    width, height = figure.get_size_inches()
    scale = (PAGE if wide else COLUMN) / width
    with figure_style(), mpl.rc_context({"pdf.fonttype": 42}):
        figure.set_layout_engine("constrained")
        figure.set_size_inches(
            width * scale, max(height * scale * (1.0 if wide else TALLER), LOWEST)
        )
        for text in figure.findobj(Text):
            text.set_fontsize(POINTS)
        _fit_legends(figure)
        figure.savefig(path, metadata={"CreationDate": None})
    return wide


def _fit_legends(figure: Figure) -> None:
    """Put legends that are too large for their place above the figure, in as many columns as fit."""
    figure.draw_without_rendering()
    places: list[tuple[Any, Any]] = [(figure, figure.legends[0])] if figure.legends else []
    places += [(axes, axes.get_legend()) for axes in figure.axes if axes.get_legend() is not None]
    for place, legend in places:
        own, room = legend.get_window_extent(), place.bbox
        covers = place is not figure and own.width * own.height > COVERED * room.width * room.height
        if own.width <= room.width and not covers:
            continue
        labels = [text.get_text() for text in legend.get_texts()]
        handles = legend.legend_handles
        legend.remove()
        for columns in range(len(labels), 0, -1):
            above = figure.legend(handles, labels, loc="outside upper center", ncols=columns)
            if columns == 1 or above.get_window_extent().width <= figure.bbox.width:
                break
            above.remove()


class _Raw(str):
    """LaTeX, which is not escaped."""


def _row(cells: Iterable[Cell]) -> _Raw:
    return _Raw(" & ".join(latex_cell(str(cell)) for cell in cells))


@functools.cache
def _environment() -> Environment:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("geomint.reports"),
        block_start_string="<%",
        block_end_string="%>",
        variable_start_string="<<",
        variable_end_string=">>",
        comment_start_string="<#",
        comment_end_string="#>",
        autoescape=False,
        finalize=lambda value: value if isinstance(value, _Raw) else latex_cell(str(value)),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.globals.update(raw=_Raw, row=_row)
    return environment
