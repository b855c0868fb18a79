"""How good `estimate_error=True` is: the estimate over the true error, of every built-in scene.

The truth is a Gauss method of 12 stages in double-double arithmetic. Errors are the largest of all
numbers of the state at the end, each in the unit of its piece. From the scene's own state and from
random states; with the scene's method, gauss-4, rk-4 and an adaptive one, each at its default step.
"""

from __future__ import annotations

import argparse
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import geomint as gi
from geomint.compare.reference import integrate_extended
from geomint.plots.canvas import new_figure
from geomint.plots.style import COLOURS, WIDTH
from geomint.problems.deviation import sizes_of
from geomint.scene.load import builtin_scenes
from machine import describe

METHODS = ("gauss-4", "rk-4", "dormand-prince-5-adaptive")
# Motions of these scenes are not integrable; the others' are, or every motion that was seen is regular.
CONTROLS = ("control-momentum-n4", "control-physical-n4")


def compared(scene: gi.Scene, y0: Any, end: float) -> list[dict[str, Any]]:
    """Return estimates and errors of all methods from a state."""
    p = scene.problem
    ends = {"tau_end": end, "clock": False} if p.time == "tau" else {"t_end": end}
    step = gi.find_method("gauss-8").default_step(p, y0, end)
    truth = integrate_extended(p, y0, end, 0.25 * step)[: p.rows].astype(np.float64)
    found = []
    for name in dict.fromkeys((scene.method.name, *METHODS)):
        method = scene.method if name == scene.method.name else name
        sol = gi.solve(p, y0, **ends, method=method, estimate_error=True, progress=False)
        estimate, error = sol.error_estimate, sol.y[-1] - truth
        assert estimate is not None
        sizes = sizes_of(p, y0)
        numbers = (float(np.max(np.abs(x / sizes))) for x in (estimate[-1], error))
        found.append(
            dict(
                zip(
                    ("method", "estimate", "error"),
                    (name, *(float(f"{x:.3g}") for x in numbers)),
                    strict=True,
                )
            )
        )
    return found


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the distribution of ratios."""
    ratios = np.array([row["estimate"] / row["error"] for row in rows])
    return {
        "runs": len(rows),
        "geometric mean": float(np.exp(np.mean(np.log(ratios)))),
        "least": float(ratios.min()),
        "largest": float(ratios.max()),
        "beyond a factor of 10": int(np.sum((ratios < 0.1) | (ratios > 10.0))),
    }


def picture(result: dict[str, Any], path: Path) -> None:
    """Draw the estimate beside the error along two runs, and against it for all."""
    scene, times = gi.load_scene("sphere-n3"), np.geomspace(0.3, 300.0, 60)
    p, y0 = scene.problem, scene.state
    truth = p.exact(y0)(times)
    with new_figure(1.6 * WIDTH, 0.68 * WIDTH, layout="constrained") as figure:
        left, right = figure.subplots(1, 2)
        for name, color in zip(("rk-4", "gauss-4"), COLOURS, strict=False):
            sol = gi.solve(p, y0, t_end=300.0, method=name, t_eval=times, estimate_error=True)
            error, estimate = (np.abs(x).max(axis=1) for x in (sol.y - truth, sol.error_estimate))
            left.loglog(times, estimate, color=color, label=f"{name}, estimate")
            left.loglog(
                times, error, "o", color=color, ms=4, mfc="none", label=f"{name}, true error"
            )
        left.set(xlabel="t", ylabel="largest error of the state", title="sphere-n3")
        left.legend(frameon=False)
        ends = [key for key in result if key != "machine"]
        for marker, end, color in zip("ox", ends, COLOURS, strict=False):
            pairs = np.array([[row["error"], row["estimate"]] for row in result[end]["rows"]])
            style = {"ms": 4, "mfc": "none", "color": color, "label": f"after {end}"}
            right.loglog(*pairs.T, marker, **style)
        limits = np.array([1e-17, 1e-2])
        right.loglog(limits, limits, color="0.4", lw=0.8)
        right.fill_between(limits, limits / 10, limits * 10, color="0.9", label="a factor of 10")
        right.set(xlabel="true error, relative", ylabel="estimate", xlim=limits, ylim=limits)
        right.set_title("every built-in scene, random states")
        right.legend(frameon=False)
        figure.savefig(path, dpi=130)


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ends", type=float, nargs="+", default=[30.0, 300.0])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    images = Path(__file__).parents[1] / "docs" / "images"
    parser.add_argument("--images", type=Path, default=images)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", gi.GeomintWarning)
    result: dict[str, Any] = {}
    for end in arguments.ends:
        rows: list[dict[str, Any]] = []
        for name in sorted(builtin_scenes()):
            scene = gi.load_scene(name)
            seeds = range(1, arguments.seeds + 1)
            states = [scene.problem.canonical(scene.state), *map(scene.problem.random_state, seeds)]
            for seed, y0 in enumerate(states):
                for row in compared(scene, y0, end):
                    rows.append({"scene": name, "seed": seed, **row})
                    ratio = row["estimate"] / row["error"]
                    print(f"{end:5g} {name:20} {seed} {row['method']:26} error {row['error']:8.1e}"
                          f"  ratio {ratio:6.2f}", flush=True)  # fmt: skip
        regular = [row for row in rows if row["scene"] not in CONTROLS]
        result[f"{end:g}"] = {"summary": summary(regular), "all": summary(rows), "rows": rows}
        print(end, result[f"{end:g}"]["summary"], "controls too", result[f"{end:g}"]["all"])
    result["machine"] = describe(["geomint", "numba", "numpy"])
    path = arguments.out / "error_estimate.json"
    path.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    picture(result, arguments.images / "error-estimate.png")


if __name__ == "__main__":
    main()
