"""Ten million steps of several methods: what drifts, and how.

Each scene is integrated by each method at one step; reports' own statistics tell the class of every
drift. One picture and one entry of the JSON a scene. The measure is watched over the first 20 000
steps. ``--steps`` shortens the runs for a trial.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import matplotlib as mpl

import geomint as gi
from geomint.plan.several import MethodRun, SeveralRuns, run_methods
from geomint.reports.kind_plots import kinds_figure
from machine import describe

MEASURE_STEPS = 20_000  # the measure costs as much as tens of steps
# Scene, step, methods. RATTLE and compositions take longer steps' worth of work in one.
RUNS: dict[str, tuple[float, tuple[str, ...]]] = {
    "ball-3d": (0.02, ("cf-4", "cg-4", "rkmk-4", "gauss-4", "dop853", "rk-4")),
    "hamiltonized-n3": (0.05, ("gauss-8", "gauss-2", "rattle-4", "verlet-4", "dop853", "rk-4")),
    "veselova-n3": (0.05, ("gauss-8", "gauss-2", "cf-4", "dop853")),
    "ellipsoid-n4": (0.02, ("rattle-2", "rattle-4", "dop853", "rk-4")),
}


def long_scene(name: str, steps: int) -> gi.Scene:
    """Return a built-in scene that ends after so many of the steps above."""
    scene = gi.load_scene(name)
    sections = json.loads(json.dumps(scene.sections))
    end = "tau_end" if "tau_end" in sections["time"] else "t_end"
    sections["time"] = {end: steps * RUNS[name][0]}
    sections["integrate"] = {"method": RUNS[name][1][0], "step": RUNS[name][0]}
    sections.pop("drift", None)
    watched = sections["observe"]["quantities"]
    quantities = list(dict.fromkeys([*watched, "measure"]))
    sections["observe"] = {"quantities": quantities, "measure": {"steps": MEASURE_STEPS}}
    return gi.load_scene(sections)


def as_json(run: MethodRun) -> dict[str, Any]:
    """Return what a run found, without its windows."""
    if run.solution is None:
        return {"status": run.status, "message": run.message}
    solution = run.solution
    return {
        "status": run.status,
        "message": run.message,
        "representation": solution.problem.name,
        "steps": solution.steps,
        "microseconds_per_step": 1e6 * solution.run_seconds / max(solution.steps, 1),
        "watching_seconds": solution.watching_seconds,
        "drift": {name: drift.as_json() for name, drift in run.drift.items()},
    }


def show(name: str, result: SeveralRuns) -> None:
    """Print a line a method: time a step, and each quantity's largest deviation and class."""
    print(name)
    for run in result:
        record = as_json(run)
        if "drift" not in record:
            print(f"  {run.label}: {run.message}")
            continue
        told = ", ".join(
            f"{q} {d['max_abs_error']:.1e} {d['class']}" for q, d in record["drift"].items()
        )
        print(f"  {run.title}: {record['microseconds_per_step']:.2f} µs a step; {told}")


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=float, default=1e7)
    parser.add_argument("--scenes", nargs="*", default=list(RUNS))
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    mpl.use("Agg")
    arguments.out.mkdir(parents=True, exist_ok=True)
    results = {}
    for name in arguments.scenes:
        step, methods = RUNS[name]
        scene = long_scene(name, round(arguments.steps))
        result = run_methods(scene.for_drift(), [f"{method}:{step}" for method in methods])
        show(name, result)
        results[name] = {"step": step, "methods": {run.label: as_json(run) for run in result}}
        figure = kinds_figure(result)
        for suffix in ("png", "svg"):
            figure.savefig(arguments.out / f"long_runs_{name}.{suffix}", dpi=200)
    record = {
        "benchmark": "long-runs",
        "steps": round(arguments.steps),
        "scenes": results,
        "machine": describe(["geomint", "numba", "numpy"]),
    }
    path = arguments.out / "long_runs.json"
    path.write_text(json.dumps(record, indent=1), encoding="utf-8")
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
