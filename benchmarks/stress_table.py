"""What a stress run found, in short: the tables of the page on stress, from its ``stress.json``.

Writes ``results/stress.json`` (counts by axis, by family of methods and by reason, references, times,
versions and machine) and ``docs/stress-table.md``. With ``--quick`` the time of a quick run is added.

    geomint stress --out stress/
    geomint stress --quick --out quick/        # with NUMBA_CACHE_DIR at an empty folder
    python benchmarks/stress_table.py stress/stress.json --quick quick/stress.json
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from geomint.methods import find_method
from geomint.stress.judge import FORBIDDEN, VERDICTS
from geomint.stress.references import references_in_words
from geomint.stress.sweep import family_of

HERE = Path(__file__).parent
Record = Mapping[str, Any]
FAMILIES = {
    "explicit": "explicit Runge–Kutta",
    "adaptive": "explicit, adaptive",
    "rkmk": "RKMK",
    "commutator_free": "commutator-free",
    "gauss": "Gauss",
    "rattle": "RATTLE",
    "splitting": "splitting",
}


def family(name: str) -> str:
    """Return what readers call the family of a method."""
    method = find_method(name)
    module = family_of(method).rsplit(".", 1)[-1]
    told = FAMILIES.get(module, module)
    return f"{told}, adaptive" if method.adaptive and "adaptive" not in told else told


def reason(cell: Record) -> str:
    """Return the type of the error that a cell ended with, or why it is unresolved."""
    if cell["verdict"] in ("failed", "refused"):
        return str(cell["message"]).split(":", 1)[0]
    allowed = cell["allowed"]
    if allowed is None:
        return "a finer run fails"
    return "round-off may grow to 0.1" if allowed > 0.1 else "the step is too long"


def counted(cells: Iterable[Record], key: Any) -> dict[str, dict[str, int]]:
    """Return the number of each verdict for each value of a key, in the order of their coming."""
    found: dict[str, Counter[str]] = {}
    for cell in cells:
        found.setdefault(key(cell), Counter())[cell["verdict"]] += 1
    return {name: {v: counts[v] for v in VERDICTS if counts[v]} for name, counts in found.items()}


def short(record: Record, quick: Record | None) -> dict[str, Any]:
    """Return the content of ``results/stress.json``."""
    cells, provenance = record["cells"], record["provenance"]
    odd = [cell for cell in cells if cell["verdict"] not in ("ok", *FORBIDDEN)]
    reasons = Counter((cell["verdict"], reason(cell)) for cell in odd)
    found = {
        "cells": len(cells),
        "counts": record["counts"],
        "axes": counted(cells, lambda cell: cell["axis"]),
        "families": counted(cells, lambda cell: family(cell["method"])),
        "reasons": [[*key, count] for key, count in reasons.most_common()],
        "references": record["references"],
        "forbidden": [cell for cell in cells if cell["verdict"] in FORBIDDEN],
        "provenance": provenance,
    }
    if quick is not None:
        found["quick"] = {
            "cells": len(quick["cells"]),
            "counts": quick["counts"],
            "seconds": quick["provenance"]["seconds"],
            "processor_seconds": quick["provenance"]["processor_seconds"],
            "command": quick["provenance"]["command"],
        }
    return found


def table(title: str, rows: Mapping[str, Mapping[str, int]]) -> list[str]:
    """Return a table of counts, one column for each verdict that occurs."""
    columns = [v for v in VERDICTS if any(v in counts for counts in rows.values())]
    lines = [
        f"| {title} | cells | {' | '.join(columns)} |",
        "|---" + "|---:" * (len(columns) + 1) + "|",
    ]
    for name, counts in rows.items():
        numbers = [sum(counts.values()), *(counts.get(v, 0) for v in columns)]
        lines.append(f"| {name} | {' | '.join(str(n or '') for n in numbers)} |")
    return [*lines, ""]


def page(found: Record) -> str:
    """Return the text of ``docs/stress-table.md``."""
    counts, made = found["counts"], found["provenance"]
    told = ", ".join(f"{counts[v]} {v}" for v in VERDICTS if counts.get(v))
    bad, used = len(found["forbidden"]), made.get("processor_seconds")
    processor = f", {used / 60:.1f} minutes of processor time," if used else ""
    lines = [
        "<!-- made by python benchmarks/stress_table.py -->",
        "",
        f"The run of the picture, `{made['command']}`, had {found['cells']} cells: {told};"
        f" {bad or 'nothing'} forbidden. It took {made['seconds'] / 60:.1f} minutes{processor} on"
        f" {made['cores']} cores ({made['cpu']}).",
        references_in_words(found["references"]),
        "",
        *table("axis", {f"`{name}`": counts for name, counts in found["axes"].items()}),
        *table("methods", found["families"]),
        "| verdict | why | cells |",
        "|---|---|---:|",
        *(f"| {verdict} | {why} | {count} |" for verdict, why, count in found["reasons"]),
        "",
    ]
    if "quick" in found:
        quick = found["quick"]
        lines += [
            f"The quick run had {quick['cells']} cells; it began with an empty code cache and took"
            f" {quick['processor_seconds']:.0f} s of processor time, on two processes.",
            "",
        ]
    return "\n".join(lines)


def main() -> None:
    """Read the JSON of a run, write the short one and the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run", type=Path, help="stress.json of a whole run")
    parser.add_argument("--quick", type=Path, help="stress.json of a quick run")
    options = parser.parse_args()
    quick = json.loads(options.quick.read_text(encoding="utf-8")) if options.quick else None
    found = short(json.loads(options.run.read_text(encoding="utf-8")), quick)
    out = HERE / "results" / "stress.json"
    out.write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    docs = HERE.parent / "docs" / "stress-table.md"
    docs.write_text(page(found), encoding="utf-8")


if __name__ == "__main__":
    main()
