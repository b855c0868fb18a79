"""The stress report: a page that opens from disk, the picture, and the numbers as JSON.

Its `RULES` say in words how cells are judged: what `geomint.stress.judge` does.
"""

import json
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..methods import find_method
from ..plots.style import Picture
from ..report import STRESS_FILES
from ..report.pages import render, write_files
from ..report.text import Record
from ..run.provenance import environment, finite_json
from .case import StressAxis
from .judge import FORBIDDEN, VERDICTS, Cell
from .picture import SYMBOLS, Cells, stress_figure
from .references import references_in_words, references_of
from .sweep import family_of

RULES = Path(__file__).with_name("rules.txt").read_text(encoding="utf-8")


def stress_record(
    cells: Sequence[Cell],
    axes: Sequence[StressAxis],
    seconds: float,
    command: str | None = None,
    interrupted: bool = False,
) -> Record:
    """Return the content of ``stress.json``: its cells, axes, counts, references, provenance.

    Its `processor_seconds` are those of this process and of all that it has ended.
    """
    counts = Counter(cell.verdict for cell in cells)
    return finite_json(
        {
            "cells": [asdict(cell) for cell in cells],
            "axes": [asdict(axis) for axis in axes],
            "counts": {verdict: counts[verdict] for verdict in VERDICTS},
            "references": references_of(cells),
            "provenance": {
                **environment(),
                "command": command,
                "seconds": round(seconds, 3),
                "processor_seconds": round(sum(os.times()[:4]), 1),
                "interrupted": interrupted,
            },
        }
    )


def write_stress_report(record: Record, methods: Sequence[str], out: Path) -> Path:
    """Write ``stress.html``, ``stress.json``, ``stress.png`` and ``stress.svg``; return the page.

    All of them, or none with an OutputError.

    Parameters
    ----------
    record : mapping
        Of `stress_record`.
    methods : sequence of str
        The rows of the picture, put together by family; those without a cell are left out.
    """
    cells = record["cells"]
    used = {cell["method"] for cell in cells}
    families = {name: _family(name) for name in methods if name in used}
    order = list(dict.fromkeys(families.values()))
    rows = sorted(families, key=lambda name: order.index(families[name]))
    axes = [a for a in record["axes"] if any(cell["axis"] == a["name"] for cell in cells)]
    picture = Picture(stress_figure(cells, rows, families, axes))
    page = render(
        "stress.html.j2",
        title="Where each method stops working",
        provenance=record["provenance"],
        verdict=_sentence(record),
        record=record,
        methods=rows,
        axes=axes,
        verdicts=VERDICTS,
        symbols=SYMBOLS,
        tables={axis["name"]: _table(cells, axis["name"]) for axis in axes},
        forbidden=[cell for cell in cells if cell["verdict"] in FORBIDDEN],
        picture=picture.uri,
        rules=RULES,
        references=references_in_words(record["references"]),
    )
    return write_files(out, STRESS_FILES, page, _text(record), {"stress": picture})


def _text(record: Record) -> str:
    """Return strict JSON with a cell a line."""

    def plain(value: Any) -> str:
        return json.dumps(value, ensure_ascii=False, allow_nan=False)

    cells = ",\n".join(plain(cell) for cell in record["cells"])
    rest = ",\n".join(f"{plain(k)}: {plain(v)}" for k, v in record.items() if k != "cells")
    return f'{{"cells": [\n{cells}\n],\n{rest}}}\n'


def _family(name: str) -> str:
    method = find_method(name)
    return f"{family_of(method)} {'adaptive' if method.adaptive else ''}"


def _sentence(record: Record) -> str:
    counts, total = record["counts"], len(record["cells"])
    bad = sum(counts[verdict] for verdict in FORBIDDEN)
    words = ", ".join(f"{counts[v]} {v}" for v in VERDICTS if counts[v])
    start = "Nothing forbidden" if not bad else f"{bad} forbidden verdicts"
    return f"{start} in {total} cells: {words}." if total else "No cells."


def _table(cells: Cells, axis: str) -> list[Record]:
    """Return for each system the number of each verdict, and the largest error that is ok."""
    rows: dict[str, Record] = {}
    for cell in cells:
        if cell["axis"] != axis:
            continue
        row = rows.setdefault(cell["system"], {"system": cell["system"], "counts": Counter()})
        row["counts"][cell["verdict"]] += 1
    return list(rows.values())
