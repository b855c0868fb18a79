"""How good `sol.local_error` is: the largest error of a step, and where, against every step again.

    python benchmarks/local_errors.py [--motions 28] [--seed 1]

Motions of built-in scenes from random states, a method of each family, in steps of 0.5 … 2 times the
default one, of order 7 and more of 1.2 … 2.5 times. The truth is every step once more, by SciPy's
DOP853 at 2.3e-14. Errors are relative to the largest number of each piece there.

What it costs to rank steps while they go on: the time of steps with it over that without, in turns.
"""

from __future__ import annotations

import argparse
import json
import time
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import geomint as gi
from geomint.plots.canvas import new_figure
from geomint.plots.style import COLOURS, WIDTH
from geomint.problems.evaluate import rates_of
from geomint.run.local_error import Ranked
from geomint.scene.load import builtin_scenes
from machine import describe

METHODS = ("gauss-8", "gauss-4", "gauss-2", "rk-4", "dop853", "heun-2", "cf-4", "rkmk-4", "cg-3",
           "verlet-2", "verlet-4", "rattle-2", "rattle-4", "lobatto-3", "gauss-2-suzuki-6")  # fmt: skip
COSTS = ("gauss-8", "gauss-4", "rk-4", "dop853", "cf-4", "rkmk-4", "verlet-4", "rattle-2")
IMPLICIT = ("gauss-8", "gauss-4", "rattle-2")
MANY, TURNS, PAIRS, PROCESSES = 5000, 21, 5, 9
STEPS, ORDER = 100, 7
ROUNDING = 3e-14  # errors that are nothing but that are not compared


def errors_of(problem: gi.Problem, sol: gi.Solution) -> np.ndarray:
    """Return what each step errs by."""
    rate, found = rates_of(problem, sol.y[0]), []
    for k in range(len(sol.y) - 1):
        before, after = sol.y[k : k + 2]
        end = solve_ivp(
            lambda t, y: rate(problem, y, t).copy(),
            sol.tau[k : k + 2],
            before,
            method="DOP853",
            rtol=2.3e-14,
            atol=1e-16 * np.abs(before).max(),
        ).y[:, -1]
        pieces = problem.slices.values()
        found.append(max(np.abs(after - end)[p].max() / np.abs(end[p]).max() for p in pieces))
    return np.array(found)


def compared(name: str, method: str, rng: np.random.Generator) -> dict[str, Any] | None:
    """Return the measured error over the true one for a motion; None where it is rounding alone."""
    problem = gi.load_scene(name).problem
    y0 = problem.canonical(problem.random_state(int(rng.integers(1 << 30))))
    own = gi.find_method(method)
    low, high = (0.3, 1.3) if own.order >= ORDER else (-1.0, 1.0)
    step = own.default_step(problem, y0, 1e9) * 2.0 ** rng.uniform(low, high)
    end = {"tau_end" if problem.time == "tau" else "t_end": STEPS * step}
    given = {"clock": False} if problem.time == "tau" else {}
    sol = gi.solve(problem, y0, **end, **given, method=method, step=step, save_every=1)
    true, told = errors_of(problem, sol), sol.local_error
    if true.max() < ROUNDING:
        return None
    ratio = float(f"{told.largest / true.max():.3g}")
    return {"scene": name, "method": method, "error": float(f"{true.max():.3g}"), "ratio": ratio}


def cost(method: str) -> dict[str, float]:
    """Return the nanoseconds of a step, and what its rank adds: medians over places of states."""
    problem = gi.load_scene(
        "ball-3d" if method in ("cf-4", "rkmk-4") else "hamiltonized-n3"
    ).problem
    y0, found = problem.random_state(1), []
    for _ in range(PAIRS):
        pair = [gi.Integrator(problem, y0, method, step=0.05) for _ in range(2)]
        known, times = Ranked(pair[1]), []
        for made in TURNS * pair:
            begun = time.perf_counter()
            made.step(MANY)
            times.append((time.perf_counter() - begun) / MANY * 1e9)
        assert known.number("largest") > 0.0
        one, other = np.array(times[2:]).reshape(-1, 2).T
        found.append((np.median(one), np.median(other - one)))
    step, rank = np.median(found, axis=0)
    return {"step": float(f"{step:.3g}"), "rank": float(f"{rank:.3g}")}


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--motions", type=int, default=28)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    images = Path(__file__).parents[1] / "docs" / "images"
    parser.add_argument("--images", type=Path, default=images)
    given = parser.parse_args()
    rows: list[dict[str, Any]] = []
    for k, method in enumerate(METHODS):
        needs = gi.find_method(method).needs
        names = [n for n in sorted(builtin_scenes()) if needs in gi.load_scene(n).problem.forms]
        for i in range(given.motions):
            rng = np.random.default_rng([given.seed, k, i])
            row = compared(names[i % len(names)], method, rng)
            rows += [row] if row else []
        ratios = [row["ratio"] for row in rows if row["method"] == method]
        if ratios:
            print(f"{method:18}{len(ratios):3}  median {np.median(ratios):6.3g}  least "
                  f"{min(ratios):6.3g}  largest {max(ratios):6.3g}", flush=True)  # fmt: skip
    ratios = np.array([row["ratio"] for row in rows])
    medians = {m: [r["ratio"] for r in rows if r["method"] == m] for m in METHODS}
    with get_context("spawn").Pool(1, maxtasksperchild=1) as pool:
        # Where code lies in memory, another place in each process, makes a step half as long again.
        runs = pool.map(cost, PROCESSES * COSTS, chunksize=1)
    found = np.median(np.reshape([list(run.values()) for run in runs], (PROCESSES, -1, 2)), axis=0)
    costs = {
        m: {"step": float(s), "rank": float(r)} for m, (s, r) in zip(COSTS, found, strict=True)
    }
    parts = [c["rank"] / max(0.1 * c["step"], 5.0) for m, c in costs.items() if m not in IMPLICIT]
    parts += [costs[m]["rank"] / (0.03 * costs[m]["step"]) for m in IMPLICIT]
    summary = {
        "nanoseconds": costs,
        "largest cost over what is allowed": float(f"{max(parts):.3g}"),
        "motions": len(rows),
        "medians": {m: float(np.median(r)) for m, r in medians.items() if r},
        "too small by 30": float(np.mean(ratios < 1.0 / 30.0)),
    }
    print(summary)
    data = {"machine": describe(["geomint", "numba", "numpy"]), "summary": summary, "rows": rows}
    (given.out / "local_errors.json").write_text(json.dumps(data, indent=1) + "\n")
    with new_figure(WIDTH, 0.8 * WIDTH, layout="constrained") as figure:
        axes = figure.subplots()
        axes.axvspan(0.1, 10.0, color="0.93")
        for k, (_, found) in enumerate(medians.items()):
            axes.semilogx(found, k + np.linspace(-0.25, 0.25, len(found)), ".", color=COLOURS[0])
        axes.set_yticks(range(len(medians)), list(medians))
        axes.set(xlabel="measured / true largest error of a step", xlim=(1e-3, 1e3))
        axes.invert_yaxis()
        figure.savefig(given.images / "local-errors.png", dpi=130)


if __name__ == "__main__":
    main()
