"""What it costs to watch the invariant measure: microseconds a step, beside those of the step itself.

Each method runs with and without ``observe=["measure"]``, the runs taking turns; medians. Also the
level below which the instrument cannot tell the drift of such a run from zero.
"""

from __future__ import annotations

import argparse
import json
import statistics
from pathlib import Path
from typing import Any

import geomint as gi
from geomint.problems.time_scale import characteristic_time
from machine import describe

RUNS = {
    "ball-3d": ("cf-4", "rkmk-4", "rk-4", "gauss-8"),
    "hamiltonized-n3": ("gauss-8", "gauss-2", "verlet-4", "rk-4"),
    "hamiltonized-n5": ("gauss-8", "rk-4"),
    "ellipsoid-n4": ("rattle-2", "rattle-4", "rk-4"),
}


def run(scene: gi.Scene, name: str, watched: list[str], steps: int) -> gi.Solution:
    """Return a run of so many default steps that saves nothing."""
    problem, y0 = scene.problem, scene.state
    step = gi.find_method(name).step_fraction * characteristic_time(problem, y0)
    end = "tau_end" if problem.time == "tau" else "t_end"
    ends = {end: steps * step}
    return gi.solve(problem, y0, method=name, step=step, observe=watched, progress=False, **ends)


def cost(scene: gi.Scene, name: str, steps: int, repeats: int) -> dict[str, float]:
    """Return microseconds a step, and of watching it, and the noise of a step."""
    plain, watching, scales = [], [], []
    for i in range(repeats + 1):
        without = run(scene, name, [], steps)
        watched = run(scene, name, ["measure"], steps)
        if i:  # the first compiles, or reads the cache
            plain.append(1e6 * without.run_seconds / without.steps)
            watching.append(1e6 * watched.watching_seconds / watched.steps)
            scales.append(watched.drift["measure"].scale)
    return {
        "step_us": statistics.median(plain),
        "measure_us": statistics.median(watching),
        "level": 32.0 * 2.0**-52 * scales[0],
    }


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=20_000)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    found: dict[str, dict[str, Any]] = {}
    for scene_name, methods in RUNS.items():
        scene = gi.load_scene(scene_name)
        found[scene_name] = {}
        for name in methods:
            numbers = cost(scene, name, arguments.steps, arguments.repeats)
            found[scene_name][name] = numbers
            print(
                f"{scene_name} {name}: step {numbers['step_us']:.2f} µs, measure "
                f"{numbers['measure_us']:.2f} µs; level {numbers['level']:.1e}",
                flush=True,
            )
    record = {
        "benchmark": "measure-cost",
        "steps": arguments.steps,
        "repeats": arguments.repeats,
        "scenes": found,
        "machine": describe(["geomint", "numba", "numpy"]),
    }
    path = arguments.out / "measure_cost.json"
    path.write_text(json.dumps(record, indent=1), encoding="utf-8")
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
