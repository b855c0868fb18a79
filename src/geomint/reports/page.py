"""Reports as HTML: self-contained pages that open from disk, everything escaped."""

from __future__ import annotations

import functools
import re
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from ..errors import printable
from .report import (
    Block,
    Cell,
    Code,
    Folded,
    Listing,
    Marked,
    Num,
    Part,
    Prose,
    Report,
    Small,
    Stack,
    Table,
    Verdict,
)

_CODE = re.compile(r"`([^`]+)`")


def page(report: Report) -> str:
    """Return the page of a report."""
    template = _environment().get_template("report.html.j2")
    return template.render(report=report, provenance=_provenance(report))


def framed(report: Report) -> str:
    """Return what a notebook shows of a report: its page, whose style is not that of the notebook."""
    frame = '<iframe srcdoc="{}" style="width: 100%; height: 40rem; border: 0"></iframe>'
    return str(Markup(frame).format(page(report)))


def _provenance(report: Report) -> list[Block]:
    """Return where a report comes from: versions, machine, command, what to cite, and the scene."""
    told, citation = report.provenance, report.citation
    computer = {"processor": f"{told['cpu']}, {told['cores']} cores", "platform": told["platform"]}
    rows = {**told["versions"], **computer, "date": told["date"]}
    if "scene_hash" in told:
        seed = told["seed"]
        rows["seed"] = "none: nothing is random" if seed is None else str(seed)
        rows["scene hash"] = f"`{told['scene_hash']}`"
    blocks: list[Block] = []
    if told["command"]:
        blocks += [Prose(f"Computed on {told['date']} by", small=False), Code(told["command"])]
    named = [(name, text or "not installed") for name, text in rows.items()]
    blocks.append(Table((), named, kind="plan", told=False))
    if citation is not None:
        cited: list[Block] = []
        for what, references in citation.parts:
            sources = [source.text for source in references]
            cited.append(Part(what, (Listing(sources or ["no source is stated"]),)))
        blocks.append(Folded("What to cite", (*cited, Code(citation.bibtex))))
    if told.get("python"):
        blocks.append(Folded("The file in Python", (Code(told["python"]),)))
    if told.get("scene_toml"):
        blocks.append(Part("Scene", (Code(told["scene_toml"]),)))
    same = f"The same numbers, for programs, are in `{report.stem}.json` beside this page."
    return [Part("Provenance", (*blocks, Prose(same)))]


def _harmless(value: Any) -> Any:
    """Return a value without control characters, which no HTML may have and which may mislead."""
    plain = isinstance(value, str) and not isinstance(value, Markup)
    return printable(value) if plain and not value.isprintable() else value


@functools.cache
def _environment() -> Environment:
    made = Environment(
        loader=PackageLoader("geomint.reports"),
        autoescape=True,
        finalize=_harmless,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters.update(cell=_cell, code=_code, rows=_rows, kind=lambda block: type(block).__name__)
    return made


def _code(text: str) -> Markup:
    """Return a text with what is between backticks as code."""
    return Markup(_CODE.sub(r"<code>\1</code>", str(escape(printable(text)))))


def _cell(cell: Cell) -> Markup:
    """Return a cell of a table."""
    match cell:
        case Verdict(word):
            kind = word.replace(" ", "-")
            found = Markup('<span class="kind {}">{}</span>').format(kind, str(cell))
            return found if word else Markup("")
        case Small(text):
            return Markup('<span class="small">{}</span>').format(printable(text))
        case Marked(text, mark) if mark.startswith("data:"):
            return Markup('<img class="swatch" src="{}" alt="line of {}"> {}').format(
                mark, text, text
            )
        case Marked(text, mark):
            return Markup('<span class="dot" style="background: {}"></span> {}').format(mark, text)
        case Stack():
            inner = Markup("").join(_cell(part) for part in cell if str(part))
            return Markup('<span class="cell">{}</span>').format(inner)
        case Num() | str():
            return _code(str(cell))


def _rows(table: Table) -> list[list[tuple[str, Cell, int]]]:
    """Return for each row its cells, with their headings and how many columns they take."""
    labels = [str(column) for column in table.columns] or [""] * max(
        map(len, table.rows), default=0
    )
    rows = []
    for row in table.rows:
        spans = [1] * len(row)
        spans[-1] += len(labels) - len(row) if table.columns else 0
        rows.append(list(zip(labels, row, spans, strict=False)))
    return rows
