"""What a stress test found: a page, the picture, and the numbers as JSON.

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
from ..reports import STRESS_FILES
from ..reports.report import (
    Block,
    Code,
    Folded,
    Images,
    Part,
    Prose,
    Report,
    Table,
    Verdict,
)
from ..reports.text import Record, number, with_provenance
from .case import StressAxis
from .judge import FORBIDDEN, VERDICTS, Cell
from .picture import Cells, stress_figure
from .references import references_in_words, references_of
from .sweep import family_of
from .terminal import why

RULES = Path(__file__).with_name("rules.txt").read_text(encoding="utf-8")
MOST = 20  # forbidden cells that a terminal lists
SHOWN = (
    "A panel for each axis, methods by values, coloured by verdict; tables below have the numbers."
)
HOW = (
    "A square of one colour is the verdict on all systems, with the largest error; else its upper left "
    "half is the best of them, the lower right half the worst. Blue is ok, darker where the error is "
    "larger; grey with ~ is unresolved; orange with ∘ is a typed error of a step; white with – is a "
    "typed error before the first step; black is forbidden. A square that is left out: the method does "
    "not fit any system of that axis."
)


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
    record = {
        "cells": [asdict(cell) for cell in cells],
        "axes": [asdict(axis) for axis in axes],
        "counts": {verdict: counts[verdict] for verdict in VERDICTS},
        "references": references_of(cells),
    }
    found = with_provenance(record, None, command)
    found["provenance"] |= {
        "seconds": round(seconds, 3),
        "processor_seconds": round(sum(os.times()[:4]), 1),
        "interrupted": interrupted,
    }
    return found


def stress_report(record: Record, methods: Sequence[str]) -> Report:
    """Return how often each verdict occurs, what is forbidden, and the picture of all cells.

    Parameters
    ----------
    record : mapping
        Of `stress_record`.
    methods : sequence of str
        The rows of the picture, put together by family; those without a cell are left out.
    """
    cells, told = record["cells"], record["provenance"]
    used = {cell["method"] for cell in cells}
    families = {name: _family(name) for name in methods if name in used}
    order = list(dict.fromkeys(families.values()))
    rows = sorted(families, key=lambda name: order.index(families[name]))
    axes = [a for a in record["axes"] if any(cell["axis"] == a["name"] for cell in cells)]
    picture = Picture(stress_figure(cells, rows, families, axes))
    bad = [cell for cell in cells if cell["verdict"] in FORBIDDEN]
    cost = f"{len(rows)} methods, {len(axes)} axes; computed in {number(told['seconds'])} s."
    shown = Images([(picture.uri, SHOWN)], "wide scrolls")
    references = references_in_words(record["references"])
    systems = [
        Part(
            axis["title"],
            (
                Prose(f"Values: {axis['quantity']}. On the command line: `--axis {axis['name']}`."),
                _counts([c for c in cells if c["axis"] == axis["name"]], "system", told=False),
            ),
        )
        for axis in axes
    ]
    blocks: list[Block] = [
        Part("The picture", (shown, Prose(HOW), Prose(cost))),
        Part("Axis by axis", (_counts(cells, "axis"),)),
        *([Part("What is forbidden, and happened", _forbidden(bad))] if bad else []),
        Part("System by system", tuple(systems)),
        Part("The rules", (Code(RULES), Prose(references, small=False))),
    ]
    cut = [("The run was interrupted.", "What follows is about the cells that were computed.")]
    interrupted = told["interrupted"]
    return Report(
        STRESS_FILES,
        "Stress report",
        "Where each method stops working",
        _sentence(record),
        blocks,
        record,
        "interrupted" if interrupted else "success",
        references,
        alerts=cut if interrupted else [],
        pictures={"stress": picture},
        outcome="forbidden" if bad and not interrupted else "",
        json=_text,
    )


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


def _counts(cells: Cells, what: str, told: bool = True) -> Table:
    """Return the number of each verdict, for each system or axis."""
    found: dict[str, Counter[str]] = {}
    for cell in cells:
        found.setdefault(cell[what], Counter())[cell["verdict"]] += 1
    rows = [(name, *(str(n[v] or "") for v in VERDICTS)) for name, n in found.items()]
    empty = [verdict for verdict in VERDICTS if not any(n[verdict] for n in found.values())]
    return Table((what, *VERDICTS), rows, 1, "quantities counts", told, empty)


def _forbidden(cells: Cells) -> tuple[Block, ...]:
    """Return what is forbidden; what is more than a terminal lists is folded."""
    columns = ("verdict", "method", "system", "axis", "value", "why")
    keys = ("method", "system", "axis", "label")
    rows = [(Verdict(c["verdict"]), *(c[key] for key in keys), why(c)) for c in cells]
    first, rest = Table(columns, rows[:MOST], 6), Table(columns, rows[MOST:], 6, told=False)
    return (first, Folded(f"… and {len(rest.rows)} more", (rest,))) if rest.rows else (first,)
