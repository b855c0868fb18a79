"""Lyapunov exponents: against pynamicalsys, of integrable motions to 10⁷ steps, and what they cost.

Chaotic: the system of Hénon and Heiles at energies 1/6 and 1/8 from random states of the section x = 0,
the whole spectrum by both codes to the same time, at steps whose energy errors are alike: rk-4 is the
cheapest of our methods there, svy4 the best of pynamicalsys. They take turns; compilation apart.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from pynamicalsys import HamiltonianSystem

import geomint as gi
from geomint.problems.testproblems import henon_heiles
from geomint.problems.time_scale import characteristic_time
from henon_heiles_states import states
from machine import describe

ENERGIES, END = (1.0 / 6.0, 1.0 / 8.0), 5e4
STEPS = {"rk-4": 0.02, "gauss-8": 0.4}
THEIRS = ("svy4", 0.02)
INTEGRABLE = {"hamiltonized-n3": "gauss-8", "sphere-n3": "gauss-8", "ball-3d": "cf-4"}
COSTS = ("rk-4", "verlet-4", "rattle-2", "gauss-4", "gauss-8")


def timed(call: Callable[[], Any]) -> tuple[Any, float]:
    """Return what a call returns, and its wall time."""
    begun = time.perf_counter()
    found = call()
    return found, time.perf_counter() - begun


def chaotic(count: int) -> dict[str, Any]:
    """Return largest exponents, sums and times of both codes."""
    theirs, problem = HamiltonianSystem(model="henon heiles"), henon_heiles.problem()
    theirs.integrator(THEIRS[0], time_step=THEIRS[1])
    result = {}
    for energy in ENERGIES:
        rows = []
        for seed, y in enumerate([None, *states(energy, count, 1)]):
            end = 100.0 if y is None else END  # the first one compiles
            y = states(energy, 1, 0)[0] if y is None else y
            row: dict[str, Any] = {"seed": seed}
            for method, step in STEPS.items():
                found, seconds = timed(
                    lambda y=y, end=end, m=method, h=step: gi.lyapunov(
                        problem, y, t_end=end, method=m, step=h
                    )
                )
                row[method] = {
                    "lambda": found.exponents[0], "error": found.errors[0],
                    "sum": float(found.exponents.sum()), "verdict": found.verdict,
                    "seconds": seconds,
                }  # fmt: skip
            other, seconds = timed(lambda y=y, end=end: theirs.lyapunov(y[:2], y[2:], end))
            row["pynamicalsys"] = {
                "lambda": float(other[0]), "sum": float(np.sum(other)), "seconds": seconds
            }  # fmt: skip
            if seed:
                rows.append(row)
                print(f"E = {energy:.4f}  " + "  ".join(
                    f"{k}: {v['lambda']:.4f} ({v['seconds']:.2f} s)"
                    for k, v in row.items() if isinstance(v, dict)
                ), flush=True)  # fmt: skip
        result[f"{energy:.6g}"] = {"rows": rows, "means": means(rows)}
        print(result[f"{energy:.6g}"]["means"])
    return result


def means(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the mean largest exponent of the motions that are chaotic, and ratios of times."""
    wild = [row for row in rows if row["rk-4"]["verdict"] == "chaotic"]
    found: dict[str, Any] = {"chaotic": len(wild), "motions": len(rows)}
    for code in (*STEPS, "pynamicalsys"):
        values = [row[code]["lambda"] for row in wild]
        if len(values) > 1:
            found[code] = {
                "mean": statistics.fmean(values),
                "standard error": statistics.stdev(values) / len(values) ** 0.5,
            }
    for method in STEPS:
        ratios = [row["pynamicalsys"]["seconds"] / row[method]["seconds"] for row in rows]
        found[f"time over that of {method}"] = statistics.median(ratios)
    return found


def integrable(steps: int) -> dict[str, Any]:
    """Return exponents along runs of many steps, and their growth over that of a power of time."""
    result = {}
    for name, method in INTEGRABLE.items():
        scene = gi.load_scene(name)
        p, y0 = scene.problem, scene.state
        step = gi.find_method(method).step_fraction * characteristic_time(p, y0)
        end = {"tau_end" if p.time == "tau" else "t_end": steps * step}
        found, seconds = timed(lambda p=p, y0=y0, m=method, h=step, end=end: gi.lyapunov(
            p, y0, method=m, step=h, **end))  # fmt: skip
        at = [int(np.searchsorted(found.t, found.t[-1] / 10.0**k)) for k in (4, 3, 2, 1, 0)]
        rows = [
            {"t": found.t[i], "lambda": found.running[i, 0],
             "over ln(t/T)/t": found.running[i, 0] * found.t[i] / np.log(found.t[i] / found.unit)}
            for i in np.minimum(at, len(found.t) - 1)
        ]  # fmt: skip
        result[name] = {
            "method": method, "steps": found.steps, "verdict": found.verdict, "seconds": seconds,
            "exponents": found.exponents.tolist(), "errors": found.errors.tolist(), "along": rows,
        }  # fmt: skip
        told = ", ".join(f"{row['over ln(t/T)/t']:.2f}" for row in rows)
        print(f"{name} {method}: {found.verdict}, λ₁ over ln(t/T)/t: {told}; {seconds:.0f} s")
    return result


def costs(steps: int, repeats: int) -> dict[str, Any]:
    """Return seconds of a million steps with the whole spectrum, of a state of six numbers."""
    scene, result = gi.load_scene("hamiltonized-n3"), {}
    for name in COSTS:
        step = 0.1 if name.startswith("gauss") else 0.02
        seconds = []
        for i in range(repeats + 1):
            count = 100 if i == 0 else steps
            _, spent = timed(lambda m=name, h=step, n=count: gi.lyapunov(
                scene.problem, scene.state, tau_end=n * h, method=m, step=h))  # fmt: skip
            seconds.append(spent * 1e6 / count)
        result[name] = statistics.median(seconds[1:])
        print(f"{name}: {result[name]:.2f} s for a million steps")
    return result


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--motions", type=int, default=8)
    parser.add_argument("--steps", type=int, default=10_000_000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    result = {
        "chaotic": chaotic(arguments.motions),
        "million steps": costs(1_000_000, arguments.repeats),
        "integrable": integrable(arguments.steps),
        "machine": describe(["geomint", "numba", "numpy", "pynamicalsys"]),
    }
    path = arguments.out / "lyapunov.json"
    path.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
