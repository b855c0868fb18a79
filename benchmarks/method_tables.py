"""The tables of the page "Choose a method": run time against error of many methods on two scenes.

Each table is one comparison (`geomint.compare.runs`): every method at 4, 2, 1, ½ and ¼ of its
default step, or of the step that the table states; the page shows some of these points. Writes
``results/method_tables.json``.
"""

from __future__ import annotations

import argparse
import json
import warnings
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import geomint as gi
from geomint.compare.runs import compare
from machine import describe

FACTORS = (4.0, 2.0, 1.0, 0.5, 0.25)


class Entry(NamedTuple):
    """A method, which of its five points are shown, and its middle step if it is not the default."""

    method: str
    shown: tuple[int, ...]
    step: float | None = None


class Table(NamedTuple):
    """A scene, its end, and the methods in the order of the table."""

    scene: str
    end: dict[str, float]
    entries: tuple[Entry, ...]


TABLES = {
    "ball": Table(
        "ball-3d",
        {"t_end": 20000.0},
        (
            Entry("rk-4", (3, 4)),
            Entry("cf-4", (3, 4)),
            Entry("rkmk-4", (3, 4)),
            Entry("dop853", (1, 3)),
            Entry("gauss-4", (0, 2)),
            Entry("gauss-8", (1, 2)),
        ),
    ),
    "sphere": Table(
        "hamiltonized-n3",
        {"tau_end": 2500.0},
        (
            Entry("rk-4", (4,)),
            Entry("dop853", (2, 3)),
            Entry("gauss-4", (1, 2)),
            Entry("gauss-8", (0, 1, 2)),
            Entry("rattle-4", (4,)),
            Entry("rattle-6", (3,)),
            Entry("rattle-8", (2, 3)),
            Entry("lobatto-5", (1, 2)),
            Entry("lobatto-8", (0, 1)),
            Entry("cf-4", (4,)),
        ),
    ),
    "splittings": Table(
        "hamiltonized-n3",
        {"tau_end": 200.0},
        (
            Entry("gauss-8", (2,), 0.25),
            Entry("verlet-2", (2,), 0.02),
            Entry("verlet-4", (2,), 0.1),
            Entry("verlet-6", (2, 3), 0.25),
            Entry("verlet-8", (2, 3), 0.4),
            Entry("rattle-2", (2,), 0.005),
            Entry("rattle-4", (2,), 0.025),
            Entry("rattle-6", (2, 3), 0.1),
            Entry("lobatto-8", (2,), 0.4),
        ),
    ),
    "rkmk": Table(
        "ball-3d",
        {"t_end": 2000.0},
        (
            Entry("cf-4", (3,)),
            Entry("rkmk-4", (3,)),
            Entry("rkmk-dormand-prince-5", (3,)),
            Entry("rkmk-dop853", (1, 2)),
            Entry("rkmk-cayley-dop853", (1, 2)),
            Entry("dop853", (2,)),
            Entry("gauss-8", (1,)),
        ),
    ),
}


def measured(table: Table, repeats: int) -> dict[str, Any]:
    """Return all points of a table, and the ones that are shown."""
    result = compare(
        gi.load_scene(table.scene).model,
        table.end,
        [entry.method for entry in table.entries],
        first_steps={e.method: e.step for e in table.entries if e.step is not None},
        repeats=repeats,
        observe=False,
    )
    points = [asdict(point) for point in result.points]
    shown = []
    for entry in table.entries:
        own = [point for point in points if point["method"] == entry.method]
        if len(own) != len(FACTORS):
            raise SystemExit(f"{entry.method}: {len(own)} points instead of {len(FACTORS)}")
        shown += [own[i] for i in entry.shown]
    return {"scene": table.scene, "end": table.end, "points": points, "shown": shown}


def main() -> None:
    """Run the comparisons and write their results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tables", nargs="*", default=list(TABLES), choices=list(TABLES))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", gi.GeomintWarning)
    path = arguments.out / "method_tables.json"
    tables: dict[str, Any] = {}
    if path.exists():  # tables that are not measured keep their former results
        tables = json.loads(path.read_text(encoding="utf-8"))["tables"]
    for name in arguments.tables:
        tables[name] = measured(TABLES[name], arguments.repeats)
        for point in tables[name]["shown"]:
            print(name, point["method"], point["step"], point["error"], point["seconds"])
    result = {
        "benchmark": "method-tables",
        "tables": tables,
        "repeats": arguments.repeats,
        "machine": describe(["geomint", "numba", "numpy"]),
    }
    path.write_text(json.dumps(result, indent=1), encoding="utf-8")
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
