"""What of a report goes into a paper: vector figures, a table and a caption in LaTeX, BibTeX, data.

Figures are as wide as a column, or as a page of two where panels stand side by side. All fonts have
8 points and are embedded as TrueType (Type 42), as journals ask for. LaTeX and BibTeX are in ASCII.
"""

from __future__ import annotations

import csv
import functools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..plots.style import figure_style
from ..references.latex import latex_cell
from .cite import Citation
from .text import Record, number

if TYPE_CHECKING:
    from jinja2 import Environment
    from matplotlib.figure import Figure

__all__ = ["Paper", "Table", "scene_facts"]

COLUMN, PAGE = 8.6 / 2.54, 17.8 / 2.54  # inches
POINTS = 8.0  # of all letters
LETTERS = 62  # in a row of a table in a column
TALLER = 1.25  # than in proportion: letters do not shrink with the width
LOWEST = 5.4 / 2.54  # inches
COVERED = 0.25  # of its panel: a legend that is larger goes above the figure


@dataclass(frozen=True)
class Table:
    """A table of text: numbers as ``1.2e-11``; columns name their units.

    Attributes
    ----------
    columns : sequence of str
    rows : sequence of sequence of str
        A cell for every column.
    words : int
        How many columns, the first ones, hold words: the others are aligned at the right.
    """

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    words: int = 1

    @property
    def wide(self) -> bool:
        """Whether it needs the width of a page."""
        lines = [self.columns, *self.rows]
        return (
            sum(max(len(line[k]) for line in lines) + 2 for k in range(len(self.columns))) > LETTERS
        )

    @property
    def alignment(self) -> str:
        """Return the columns as LaTeX's ``tabular`` takes them."""
        return "l" * self.words + "r" * (len(self.columns) - self.words)


Printed = tuple[str, Table, str]  # caption, table, and the method in words


@dataclass(frozen=True)
class Paper:
    """What a report gives for a paper.

    Attributes
    ----------
    stem : str
        What the names of its files begin with, such as ``"drift"``.
    caption : str
        What the figure shows, a sentence or more.
    table : Table
    facts : mapping of str to str
        What was computed and how: system, method, versions. Those under ``"System"``, ``"Method"`` and
        ``"Software"`` are followed by what is to be cited for them.
    citation : Citation
    data : iterable of rows, optional
        For ``STEM.csv``, the names of columns first; None where the report has such a file.
    command : str or None
        What computes it again.
    """

    stem: str
    caption: str
    table: Table
    facts: Mapping[str, str]
    citation: Citation
    data: Iterable[Sequence[Any]] | None = None
    command: str | None = None

    def write(self, folder: Path, figures: Mapping[str, Figure]) -> None:
        """Write all files; the figures get another size, and serve nothing else afterwards."""
        wide = {
            name: save_for_print(figure, folder / f"{name}.pdf") for name, figure in figures.items()
        }
        keys = {what: self.citation.keys(what.lower()) for what in self.facts}
        given = {
            "stem": self.stem,
            "caption": self.caption,
            "table": self.table,
            "provenance": self.facts,
            "keys": keys,
            "names": ", ".join(f"{name}.pdf" for name in figures),
            "figures": wide,
            "command": self.command,
        }
        files = {"table": "table", "caption": "caption", "document": "paper"}
        for kind, file in files.items():
            text = _environment().get_template(f"paper/{kind}.tex.j2").render(given)
            (folder / f"{self.stem}-{file}.tex").write_text(text, encoding="ascii")
        (folder / f"{self.stem}.bib").write_text(self.citation.bibtex, encoding="ascii")
        if self.data is not None:
            with (folder / f"{self.stem}.csv").open("w", newline="", encoding="utf-8") as stream:
                csv.writer(stream).writerows(self.data)


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


def _row(cells: Iterable[str]) -> _Raw:
    return _Raw(" & ".join(latex_cell(cell) for cell in cells))


@functools.cache
def _environment() -> Environment:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("geomint.report"),
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


def scene_facts(provenance: Record, system: str, method: str) -> dict[str, str]:
    """Return what was computed and how: system, parameters, initial state, method, versions.

    Parameters
    ----------
    provenance : mapping
        As `geomint.scene.provenance.scene_record` gives it.
    system, method : str
        In words.
    """
    scene, versions = provenance["scene"], provenance["versions"]
    named = {key: value for key, value in scene["system"].items() if key != "name"}
    facts = {
        "System": system,
        "Parameters": ", ".join(_values(named)),
        "Initial state": ", ".join(_values(scene["initial"])),
        "Method": method,
        "Software": ", ".join(f"{name} {version}" for name, version in versions.items() if version),
    }
    return {heading: words for heading, words in facts.items() if words}


def _values(named: Mapping[str, Any]) -> Iterator[str]:
    for name, value in named.items():
        yield f"{name} = {_value(value)}"


def _value(value: Any) -> str:
    if isinstance(value, list | tuple):
        return f"({', '.join(_value(one) for one in value)})"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    return number(float(value), 10)
