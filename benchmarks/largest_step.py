"""The longest steps whose stages `gauss-8` finds: by fixed point alone, and by Newton's method.

For each scene, in its own representation or else the first one with a field, and for two stiff
problems: on a ladder of steps, 1.1 to 1, the last one up to which all do a hundred steps without a
`ConvergenceError`; of Newton's method only steps that the fixed point does not take, up to twelve
times its longest. Writes ``results/largest_step.json`` and the picture of the page "Choose a method".
"""

from __future__ import annotations

import argparse
import json
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import geomint as gi
from geomint.plots.canvas import new_figure
from geomint.plots.style import COLOURS, WIDTH
from machine import describe
from tests.problems import fast_rotor, spring_pendulum

STEPS, RATIO, MOST = 100, 1.1, 12.0


def cases() -> dict[str, tuple[gi.Problem, np.ndarray]]:
    """Return problems and states by name."""
    found = {}
    for name in gi.scene_names():
        scene = gi.load_scene(name)
        problem, y0 = scene.problem, scene.state
        if "field" not in problem.forms:
            model = scene.model
            key = next(k for k, p in model.problems.items() if "field" in p.forms)
            problem, y0 = model.problems[key], model.states[key]
        found[name] = (problem, y0)
    found["stiff pendulum"] = spring_pendulum.problem(), np.array([1.0005, 0.0, 0.0, 0.0])
    found["fast rotor"] = fast_rotor.problem(1000.0), fast_rotor.INITIAL
    return found


def seconds(problem: gi.Problem, y0: np.ndarray, h: float, iteration: str) -> float | None:
    """Return the time of a step, or None where one is not found."""
    motion = gi.Integrator(problem, y0, gi.Gauss(8, iteration=iteration), step=h)
    begin = time.process_time()
    try:
        motion.step(STEPS)
    except gi.StepError:
        return None
    return (time.process_time() - begin) / STEPS


def longest(problem: gi.Problem, y0: np.ndarray) -> dict[str, Any]:
    """Return the longest steps, and what a step costs."""
    h = gi.Gauss(8).default_step(problem, y0, np.inf)
    while seconds(problem, y0, h, "fixed-point") is None:
        h /= RATIO
    while seconds(problem, y0, h * RATIO, "fixed-point") is not None:
        h *= RATIO
    k = 0
    while RATIO**k <= MOST and seconds(problem, y0, h * RATIO ** (k + 1), "auto") is not None:
        k += 1
    costs = {str(f): seconds(problem, y0, f * h, "auto") for f in (0.5, 1.5, 3.0, 5.0)}
    return {"rows": problem.rows, "before": h, "factor": RATIO**k, "seconds": costs}


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    images = Path(__file__).parents[1] / "docs" / "images"
    parser.add_argument("--images", type=Path, default=images)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    found = {}
    for name, (problem, y0) in cases().items():
        found[name] = row = longest(problem, y0)
        took = {f: s and f"{1e6 * s:.3g}" for f, s in row["seconds"].items()}
        print(
            f"{name:22} {row['before']:8.4g} × {row['factor']:5.3g}  µs a step {took}", flush=True
        )
    record = {
        "steps": STEPS,
        "most": MOST,
        "cases": found,
        "machine": describe(["geomint", "numba", "numpy"]),
    }
    path = arguments.out / "largest_step.json"
    path.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    picture(found, arguments.images / "largest-step.png")


def picture(found: dict[str, Any], path: Path) -> None:
    """Draw how much longer steps may be."""
    names = sorted(found, key=lambda name: found[name]["factor"])
    with new_figure(WIDTH, 0.75 * WIDTH, layout="constrained") as figure:
        panel = figure.subplots()
        factors = [found[name]["factor"] for name in names]
        panel.barh(names, factors, color=COLOURS[0], height=0.6)
        panel.axvline(1.0, color="black", lw=1)
        panel.axvline(5.0, color="black", lw=1, ls=":")
        panel.tick_params(axis="y", labelsize=7)
        panel.set(
            xlabel="longest step over that of the fixed point (bars end at 12)", xlim=(0, 12.5)
        )
        figure.savefig(path, dpi=130)


if __name__ == "__main__":
    main()
