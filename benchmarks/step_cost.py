"""What a step of each method costs, without observers, in the cache: nanoseconds and evaluations.

Medians over the repeats of 20 000 steps, the settings in turn. Writes ``results/step_cost.json``.
"""

from __future__ import annotations

import argparse
import json
import statistics
import warnings
from pathlib import Path
from typing import Any

import geomint as gi
from machine import describe

STEPS = 20000
# scene, representation, what the page calls it, and methods with their steps
RUNS: tuple[tuple[str, str, str, tuple[tuple[str, float], ...]], ...] = (
    (
        "ball-3d",
        "classical-attitude",
        "`ball-3d`, with attitude",
        (("rk-4", 0.02), ("cf-4", 0.02), ("rkmk-4", 0.02), ("dop853", 0.1), ("gauss-8", 0.5)),
    ),
    ("sphere-n3", "reduced", "`sphere-n3`", (("gauss-8", 0.5),)),
    ("sphere-n5", "reduced", "`sphere-n5`", (("gauss-8", 0.5),)),
    (
        "hamiltonized-n3",
        "hamiltonized",
        "`hamiltonized-n3`",
        (
            ("dop853", 0.05),
            ("gauss-8", 0.25),
            ("verlet-4", 0.05),
            ("rattle-2", 0.01),
            ("rattle-4", 0.05),
        ),
    ),
    (
        "hamiltonized-n5",
        "hamiltonized",
        "`hamiltonized-n5`",
        (("gauss-8", 0.25), ("rattle-4", 0.05)),
    ),
    (
        "homogeneous-n4",
        "ball",
        "`homogeneous-n4`, as a ball",
        (("cf-4", 0.05), ("gauss-8", 0.5)),
    ),
)


def cost(model: gi.Model, representation: str, method: str, step: float) -> tuple[float, float]:
    """Return seconds and evaluations a step, of one run."""
    problem = model.problems[representation]
    end: dict[str, Any] = {"tau_end" if problem.time == "tau" else "t_end": STEPS * step}
    y0 = model.states[representation]
    run = gi.solve(problem, y0, **end, method=method, step=step, clock=False, progress=False)
    return run.run_seconds / run.steps, run.evaluations / run.steps


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", gi.GeomintWarning)
    rows = []
    for scene, representation, title, methods in RUNS:
        model = gi.load_scene(scene).model
        found: dict[str, list[tuple[float, float]]] = {method: [] for method, _ in methods}
        for repeat in range(arguments.repeats + 1):
            for method, step in methods:
                costs = cost(model, representation, method, step)
                if repeat:  # the first compiles, or reads the cache
                    found[method].append(costs)
        for method, step in methods:
            row = {
                "scene": scene,
                "title": title,
                "numbers": model.problems[representation].rows,
                "method": method,
                "step": step,
                "ns": 1e9 * statistics.median(seconds for seconds, _ in found[method]),
                "evaluations": found[method][0][1],
            }
            rows.append(row)
            print(
                f"{scene} {method}: {row['ns']:.0f} ns, {row['evaluations']:.1f} evaluations a step"
            )
    result = {
        "benchmark": "step-cost",
        "rows": rows,
        "repeats": arguments.repeats,
        "machine": describe(["geomint", "numba", "numpy"]),
    }
    path = arguments.out / "step_cost.json"
    path.write_text(json.dumps(result, indent=1), encoding="utf-8")
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
