"""Uneven steps: evaluations against error, and what drifts over ten million of them.

Geodesics of the ellipsoids with semi-axes 1, 5, 30 and 1, 30, 30, of speed 1, from random states, by
Gauss methods at a fixed step, in the times of the clocks "normal_squared" and "speed", and by explicit
steps that the error controls. An evaluation is one of the field; a step is the one with the least
evaluations of all that keep the error of the final state below the bound. Drifts: of one state.
"""

from __future__ import annotations

import argparse
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import chaplygin as ch
import geomint as gi
from geomint.plots.canvas import new_figure
from geomint.plots.style import COLOURS, WIDTH
from geomint.problems.deviation import pieces_of, relative_error
from machine import describe

AXES = {"1, 5, 30": (1.0, 5.0, 30.0), "1, 30, 30": (1.0, 30.0, 30.0)}
CLOCKS = {"fixed step": None, "dt = N dτ": "normal_squared", "dt = σ dτ by speed": "speed"}
ADAPTIVE = "dop853-adaptive"
FIXED = gi.Gauss(8, iteration="fixed-point")  # Newton's method takes longer steps, and more work
BOUNDS = (1e-6, 1e-9, 1e-12)
END = 1000.0
DRAWN = ("energy", "measure")
POINTS = 200  # of a curve of the picture
WATCHED = ("energy", "joachimsthal", "ellipsoid", "tangency", "measure")


def states(problem: gi.Problem, count: int) -> list[np.ndarray]:
    """Return random states of speed 1."""
    found = [problem.random_state(seed) for seed in range(count)]
    for y in found:
        y[3:] /= np.linalg.norm(y[3:])
    return found


def runs(problem: gi.Problem, y: np.ndarray, name: str) -> list[gi.Solution]:
    """Return runs with shorter and shorter steps, until rounding is met."""
    done: list[gi.Solution] = []
    if name == ADAPTIVE:
        for rtol in np.geomspace(1e-4, 1e-15, 34):
            method = gi.find_method(ADAPTIVE).with_options(rtol=float(rtol), atol=0.0)
            try:
                done.append(gi.solve(problem, y, t_end=END, method=method, progress=False))
            except gi.StepError:
                break
        return done
    clock = CLOCKS[name]
    uneven = problem if clock is None else gi.time_transformed(problem, clock, y)
    asked = {"method": FIXED, "t_end": END, "progress": False}
    span = gi.solve(uneven, y, tolerance=1e-4, **asked).tau[-1]
    for steps in np.geomspace(60, 60_000, 91).astype(int):
        try:
            sol = gi.solve(uneven, y, step=span / steps, **asked)
        except gi.StepError:
            continue
        done.append(sol)
        if sol.evaluations > 4 * min(s.evaluations for s in done) and len(done) > 20:
            break
    return done


def curves(problem: gi.Problem, count: int) -> dict[str, Any]:
    """Return evaluations and errors of all runs, and the evaluations that bounds need."""
    found: dict[str, Any] = {}
    names = (*CLOCKS, ADAPTIVE)
    for y in states(problem, count):
        uneven = gi.time_transformed(problem, "normal_squared", y)
        finest = {"method": gi.Gauss(12), "t_end": END, "progress": False}
        first = gi.solve(uneven, y, tolerance=1e-13, **finest).y[-1]
        second = gi.solve(gi.time_transformed(problem, "speed", y), y, step=0.2, **finest).y[-1]
        known = pieces_of(problem, first)
        print("reference", f"{relative_error(pieces_of(problem, second), known):.1e}", flush=True)
        for name in names:
            done = runs(problem, y, name)
            errors = [relative_error(pieces_of(problem, s.y[-1]), known) for s in done]
            counts = [s.evaluations for s in done]
            best = [
                min((n for n, e in zip(counts, errors, strict=True) if e < b), default=np.nan)
                for b in BOUNDS
            ]
            entry = found.setdefault(name, {"errors": [], "evaluations": [], "needed": []})
            entry["errors"].append(errors)
            entry["evaluations"].append(counts)
            entry["needed"].append(best)
    for name, entry in found.items():
        entry["mean"] = [
            float(np.exp(np.mean(np.log([n[k] for n in entry["needed"]]))))
            for k in range(len(BOUNDS))
        ]
        print(name, [f"{n:.0f}" for n in entry["mean"]], flush=True)
    return found


def drifts(problem: gi.Problem, steps: int) -> dict[str, Any]:
    """Return what drifts over so many steps of gauss-8, at steps for an error of 1e-9."""
    y = states(problem, 2)[1]
    found = {}
    for name, clock in CLOCKS.items():
        uneven = problem if clock is None else gi.time_transformed(problem, clock, y)
        short = gi.solve(uneven, y, t_end=END, tolerance=1e-9, progress=False)
        step = short.step_sizes.mean
        end = (
            {"t_end": step * steps} if clock is None else {"tau_end": step * steps, "clock": False}
        )
        sol = gi.solve(
            *(uneven, y),
            step=step,
            observe=WATCHED,
            observe_every=max(1, steps // 100_000),
            progress=False,
            **end,
        )
        found[name] = {
            "step": step,
            "evaluations": sol.evaluations,
            "drift": {k: told(d, step, k in DRAWN) for k, d in sol.drift.items()},
        }
        short = {k: (d.drift_class, f"{d.max_abs_error:.1e}") for k, d in sol.drift.items()}
        print(name, f"step {step:.3g}", short, flush=True)
    return found


def told(drift: gi.Drift, step: float, drawn: bool) -> dict[str, Any]:
    """Return the class of a drift, and the largest deviations of some of its windows."""
    found = {"class": drift.drift_class, "largest": drift.max_abs_error}
    if not drawn:
        return found
    windows = drift.windows
    few = np.unique(np.geomspace(1, len(windows.times), POINTS).astype(int)) - 1
    return found | {
        "times": [float(f"{t:.6g}") for t in windows.times[few] / step],
        "errors": [float(f"{e:.3g}") for e in windows.maxima[few]],
    }


def headroom(count: int) -> dict[str, Any]:
    """Return what uneven steps could gain on the Hamiltonised sphere, n = 3, from random states.

    Evaluations at a fixed step over those in the time of "speed"; and how much longer steps could be
    on average if each were as long as the spectral radius of the Jacobian allows there.
    """
    scene = gi.load_scene("hamiltonized-n3")
    problem, gains, longer = scene.problem, [], []
    for seed in range(count):
        y = problem.random_state(seed)
        span = {"t_end": 100.0, "progress": False}
        known = pieces_of(problem, gi.solve(problem, y, step=0.05, **span).y[-1])
        best = []
        for uneven in (problem, gi.time_transformed(problem, "speed", y)):
            tau = gi.solve(uneven, y, step=0.1, **span).tau[-1]
            least = [np.inf] * len(BOUNDS)
            for steps in np.geomspace(12, 1200, 90).astype(int):
                try:
                    sol = gi.solve(uneven, y, step=tau / steps, **span)
                except gi.StepError:
                    continue
                off = relative_error(pieces_of(problem, sol.y[-1]), known)
                least = [
                    min(n, sol.evaluations) if off < b else n
                    for n, b in zip(least, BOUNDS, strict=True)
                ]
            best.append(least)
        gains.append(np.divide(*best).tolist())
        sol = gi.solve(problem, y, tau_end=200.0, step=0.1, save_every=2, progress=False)
        radii = [np.abs(np.linalg.eigvals(gi.jacobian(problem, z))).max() for z in sol.y]
        longer.append(float(np.max(radii) / np.mean(radii)))
    return {"gains": gains, "longer": longer}


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--states", type=int, default=4)
    parser.add_argument("--steps", type=int, default=10_000_000)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    images = Path(__file__).parents[1] / "docs" / "images"
    parser.add_argument("--images", type=Path, default=images)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", gi.GeomintWarning)  # tolerances that a fixed step may not meet
    found = {}
    for axes, numbers in AXES.items():
        problem = ch.ellipsoid_problem(np.square(numbers))
        print(f"semi-axes {axes}", flush=True)
        found[axes] = {
            "curves": curves(problem, arguments.states),
            "drift": drifts(problem, arguments.steps),
        }
    record = {
        "benchmark": "uneven",
        "end": END,
        "bounds": BOUNDS,
        "steps": arguments.steps,
        "ellipsoids": found,
        "sphere": headroom(arguments.states),
        "machine": describe(["geomint", "numba", "numpy"]),
    }
    path = arguments.out / "uneven.json"
    path.write_text(json.dumps(record), encoding="utf-8")
    picture(record, arguments.images / "uneven-steps.png")


def picture(record: dict[str, Any], path: Path) -> None:
    """Draw evaluations against errors, and the drift of the energy and of the measure."""
    with new_figure(WIDTH, 1.05 * WIDTH, layout="constrained") as figure:
        panels = figure.subplots(3, 2, sharey="row")
        for column, (axes, found) in zip(panels.T, record["ellipsoids"].items(), strict=True):
            for (name, entry), color in zip(found["curves"].items(), COLOURS, strict=False):
                column[0].loglog(
                    entry["evaluations"][0], entry["errors"][0], ".-", ms=3, lw=0.8, color=color,
                    label="dop853, error-controlled" if name == ADAPTIVE else name,
                )  # fmt: skip
            column[0].set(xlabel="evaluations of the field", title=f"semi-axes {axes}")
            for panel, what in zip(column[1:], DRAWN, strict=True):
                for (_, entry), color in zip(found["drift"].items(), COLOURS, strict=False):
                    drift = entry["drift"][what]
                    size = np.maximum(np.abs(drift["errors"]), 1e-17)
                    panel.loglog(drift["times"], size, ".", ms=2, color=color)
                panel.set(xlabel="steps")
        panels[0, 0].set(ylabel="error at t = 1000", ylim=(1e-15, 1.0))
        panels[1, 0].set(ylabel="energy: |deviation|")
        panels[2, 0].set(ylabel="log of the measure: |deviation|")
        panels[0, 0].legend(frameon=False, fontsize="small")
        figure.savefig(path, dpi=130)


if __name__ == "__main__":
    main()
