"""Four kinds of drift on six built-in scenes by good sets of methods: the page "Which method for what".

Writes ``results/drift_by_method.json``, which the documentation turns into tables, and a picture a
scene, ``docs/images/drift-by-method-SCENE.png``. ``--part`` shortens the runs for a trial.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any, NamedTuple

import geomint as gi
from geomint.plan import SeveralRuns, run_methods
from geomint.plots.style import figure_style
from geomint.reports.drift_report import drift_record
from geomint.reports.kind_plots import kinds_figure
from machine import describe

HERE = Path(__file__).parent
ROOT = HERE.parent


class Run(NamedTuple):
    """Where a scene ends in its own time, and by which methods it is integrated."""

    end: float
    methods: tuple[str, ...]


IN_TAU = ("gauss-8", "gauss-2", "rattle-4", "cf-4", "dop853", "rk-4")
RUNS = {
    "ball-3d": Run(2000.0, ("gauss-8", "gauss-2", "cf-4:0.05", "rkmk-4", "dop853", "rk-4")),
    "hamiltonized-n3": Run(500.0, IN_TAU),
    "hamiltonized-n5": Run(500.0, IN_TAU),
    "veselova-n3": Run(500.0, IN_TAU),
    "veselova-n4": Run(500.0, ("gauss-8", "gauss-2", "rattle-4", "dop853", "rk-4")),
    "ellipsoid-n4": Run(
        500.0, ("gauss-8:0.2", "gauss-2", "rattle-2", "rattle-4", "dop853", "rk-4")
    ),
}


def scene_of(name: str, part: float) -> gi.Scene:
    """Return a built-in scene with its end, and the measure watched as well."""
    scene = gi.load_scene(name)
    end = "tau_end" if scene.content.time.tau_end is not None else "t_end"
    quantities = [*scene.content.observe.quantities, "measure"]
    return scene.changed(
        time={end: part * RUNS[name].end},
        observe={"quantities": list(dict.fromkeys(quantities))},
    )


def record_of(result: SeveralRuns) -> dict[str, Any]:
    """Return the numbers of all methods, and where they end."""
    record = drift_record(result, {})
    del record["provenance"]
    time = result.scene.content.time
    record["end"] = time.t_end if time.tau_end is None else time.tau_end
    return record


def main() -> None:
    """Run the scenes and write what the page shows."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", nargs="*", default=list(RUNS), choices=list(RUNS))
    parser.add_argument("--part", type=float, default=1.0, help="part of each run")
    parser.add_argument("--results", type=Path, default=HERE / "results")
    parser.add_argument("--images", type=Path, default=ROOT / "docs" / "images")
    arguments = parser.parse_args()
    path = arguments.results / "drift_by_method.json"
    scenes: dict[str, Any] = {}
    if path.exists():  # scenes that are not run keep their former results
        scenes = json.loads(path.read_text(encoding="utf-8"))["scenes"]
    for name in arguments.scenes:
        result = run_methods(
            scene_of(name, arguments.part),
            RUNS[name].methods,
            report=lambda run, name=name: print(f"{name}: {run.title} {run.message}", flush=True),
        )
        scenes[name] = record_of(result)
        with figure_style():
            kinds_figure(result).savefig(arguments.images / f"drift-by-method-{name}.png")
        content = {"machine": describe(["geomint", "numpy", "numba"]), "scenes": scenes}
        text = json.dumps(content, indent=1, ensure_ascii=False)
        path.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
