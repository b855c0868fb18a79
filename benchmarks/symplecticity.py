"""What methods do to the symplectic form: the largest defect of a step, of systems that have a form.

From random states, at a fifth of a characteristic time over the order and at half of that; the table of
the page "Choose a method". Also how often the instrument takes the map of a symplectic method for one
that is not.
"""

from __future__ import annotations

import argparse
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import geomint as gi
from geomint.plots.canvas import new_figure
from geomint.plots.style import COLOURS, WIDTH
from geomint.problems.testproblems import henon_heiles
from geomint.problems.time_scale import characteristic_time
from machine import describe

SCENES = (
    "hamiltonized-n3",
    "hamiltonized-n5",
    "neumann-n3",
    "ellipsoid-n4",
    "clebsch-n4",
    "veselova-n4",
)
METHODS = {"gauss-1": 0.05, "gauss-2": 0.1, "gauss-4": 0.2, "gauss-8": 0.4, "verlet-4": 0.1,
           "rattle-2": 0.05, "rattle-4": 0.1, "rk-4": 0.05, "dop853": 0.2}  # fmt: skip
STEPS = 200


def problems() -> dict[str, tuple[gi.Problem, list[np.ndarray]]]:
    """Return problems with forms, and no states yet."""
    found = {}
    for name in SCENES:
        model = gi.load_scene(name).model.problems
        kept = [p for p in model.values() if p.symplectic_form is not None]
        found[name] = (kept[0], [])
    return {"henon-heiles (flat)": (henon_heiles.problem(), []), **found}


def defects(p: gi.Problem, y0: np.ndarray, name: str, fraction: float) -> dict[str, Any]:
    """Return the largest defects at two steps, and whether they are those of rounding."""
    method, found = gi.find_method(name), {"structure": gi.find_method(name).structure(p)}
    for key, part in (("whole", fraction), ("half", 0.5 * fraction)):
        h = part * characteristic_time(p, y0)
        end = {"tau_end": STEPS * h, "clock": False} if p.time == "tau" else {"t_end": STEPS * h}
        run = gi.solve(p, y0, **end, method=method, step=h, observe=["symplectic"], progress=False)
        drift = run.drift["symplectic"]
        found[key] = drift.max_abs_error
        found["rounding"] = found.get("rounding", True) and bool(drift.within_roundoff)
    return found


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    images = Path(__file__).parents[1] / "docs" / "images"
    parser.add_argument("--images", type=Path, default=images)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    rng = np.random.default_rng(4)
    result: dict[str, Any] = {"table": {}}
    wrong = runs = 0
    for problem, (p, states) in problems().items():
        for seed in range(arguments.seeds):
            y = 0.25 * rng.normal(size=4) if p.make_random is None else p.random_state(seed)
            states.append(y)
        for name, fraction in METHODS.items():
            if gi.find_method(name).needs not in p.forms:
                continue
            found = []
            for y0 in states:
                try:
                    found.append(defects(p, y0, name, fraction))
                except gi.StepError:
                    continue
            if not found:
                continue
            whole, half = (np.array([one[key] for one in found]) for key in ("whole", "half"))
            symplectic = "symplectic" in found[0]["structure"]
            runs += len(found) * symplectic
            wrong += sum(not one["rounding"] for one in found) * symplectic
            row = {
                "mean": float(np.exp(np.log(np.maximum(whole, 1e-17)).mean())),
                "worst": float(whole.max()),
                "order": float(np.median(np.log2(whole / half))) if whole.min() > 1e-13 else None,
                "symplectic": symplectic,
                "rounding": sum(one["rounding"] for one in found),
                "runs": len(found),
            }
            result["table"].setdefault(problem, {})[name] = row
            print(f"{problem:20} {name:9} mean {row['mean']:.1e} worst {row['worst']:.1e} order "
                  f"{row['order']} rounding {row['rounding']}/{row['runs']}"
                  f"{' symplectic' if symplectic else ''}", flush=True)  # fmt: skip
    result |= {"symplectic runs": runs, "not within rounding": wrong, "fractions": METHODS}
    result["machine"] = describe(["geomint", "numba", "numpy"])
    print(f"of {runs} runs of symplectic methods {wrong} beyond the noise of the instrument")
    path = arguments.out / "symplecticity.json"
    path.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    picture(arguments.images / "symplectic-defect.png")


def picture(path: Path) -> None:
    """Draw the defects of the steps of a run by several methods."""
    scene = gi.load_scene("hamiltonized-n3")
    with new_figure(WIDTH, 0.6 * WIDTH, layout="constrained") as figure:
        panel = figure.subplots()
        steps = {"rk-4": 0.05, "gauss-2": 0.05, "gauss-8": 0.25, "rattle-4": 0.05, "verlet-4": 0.05}
        for (name, h), color in zip(steps.items(), COLOURS, strict=False):
            run = gi.solve(scene.problem, scene.state, tau_end=50.0, method=name, step=h,
                           observe=["symplectic"], progress=False)  # fmt: skip
            windows = run.drift["symplectic"].windows
            panel.semilogy(
                windows.times, windows.maxima, ".", ms=3, color=color, label=f"{name}, h = {h}"
            )
        panel.set(xlabel="τ", ylabel="symplectic defect of a step", ylim=(1e-17, 1e-3))
        panel.legend(frameon=False, ncols=2, loc="upper right")
        figure.savefig(path, dpi=130)


if __name__ == "__main__":
    main()
