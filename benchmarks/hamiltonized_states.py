"""What users meet: geomint and heyoka on the Hamiltonised sphere, n = 3, from random states.

The ball of `hamiltonized_n3`, from `random_state(0)` … `random_state(31)`, to several ends in τ. For
each state the fastest setting of either code counts whose error of the final state is below the
goal; the error is the largest deviation of (γ, p̃) from a double-double reference. Times are those of
the whole call, as a clock on the wall shows them: an integrator of either code, made once, gets the
state and goes to the end; `geomint.Integrator` with what it checks of the state. Compilation, and
making integrators, are apart. Codes take turns; the median of the repeats counts, and of the states
the geometric mean of the ratios.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import chaplygin as ch
import geomint as gi
from geomint.compare.reference import reference_solution
from hamiltonized_n3 import A, D, heyoka_field
from machine import describe

ENDS = (2500.0, 250.0)
STATES = range(32)
GOAL = 1e-9
STEPS = (
    *(0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.4, 1.7, 2.0, 2.5, 3.0, 4.0),
    *(5.0, 7.0, 10.0, 14.0, 20.0),
)
FORMS = ("rational", "polynomial-2", "homogeneous", "on-sphere", "on-sphere-polynomial")
TOLERANCES = (1e-14, 1e-13, 3e-13, 1e-12, 3e-12, 1e-11, 3e-11, 1e-10, 1e-9)

Runner = Callable[[float], np.ndarray]


def geomint_runners(problem: gi.Problem, y0: np.ndarray) -> dict[str, Runner]:
    """Return functions that integrate to an end, by setting."""

    def runner(step: float) -> Runner:
        motion = gi.Integrator(problem, y0, "gauss-8", step=step)

        def run(end: float) -> np.ndarray:
            motion.reset(y0)
            motion.propagate_until(end)
            return motion.state

        return run

    return {f"gauss-8, step {step}": runner(step) for step in STEPS}


def heyoka_runners(integrators: dict[str, Any], y0: np.ndarray) -> dict[str, Runner]:
    """Return functions that integrate to an end, by setting."""

    def runner(integrator: Any) -> Runner:
        def run(end: float) -> np.ndarray:
            integrator.time = 0.0
            integrator.state[:] = y0
            integrator.propagate_until(end)
            return np.asarray(integrator.state.copy())

        return run

    return {name: runner(integrator) for name, integrator in integrators.items()}


def heyoka_integrators() -> dict[str, Any]:
    """Return an integrator for each formulation and tolerance."""
    import heyoka as hy

    return {
        f"{form}, tolerance {tolerance:g}": hy.taylor_adaptive(
            heyoka_field(form), [0.5] * 6, tol=tolerance, compact_mode=False
        )
        for form in FORMS
        for tolerance in TOLERANCES
    }


def good_enough(runners: dict[str, Runner], end: float, truth: np.ndarray) -> dict[str, float]:
    """Return the errors of the settings whose error is below the goal."""
    errors = {}
    for name, run in runners.items():
        try:
            errors[name] = float(np.max(np.abs(run(end) - truth)))
        except gi.ConvergenceError:
            continue
    return {name: error for name, error in errors.items() if error < GOAL}


def times_of(runners: dict[str, Runner], end: float, repeats: int) -> dict[str, float]:
    """Return the median wall time of each setting, all of them in turn."""
    seconds: dict[str, list[float]] = {name: [] for name in runners}
    for _ in range(repeats):
        for name, run in runners.items():
            begun = time.perf_counter()
            run(end)
            seconds[name].append(time.perf_counter() - begun)
    return {name: statistics.median(values) for name, values in seconds.items()}


def compared(problem: gi.Problem, integrators: Any, seed: int, end: float, repeats: int) -> Any:
    """Return the fastest setting of both codes from one state, with times and errors."""
    y0 = problem.random_state(seed)
    truth = reference_solution(problem, y0, end).y
    ours, theirs = geomint_runners(problem, y0), heyoka_runners(integrators, y0)
    errors = {**good_enough(ours, end, truth), **good_enough(theirs, end, truth)}
    seconds = times_of(
        {k: run for k, run in {**ours, **theirs}.items() if k in errors}, end, repeats
    )
    row: dict[str, Any] = {"seed": seed}
    for code, runners in (("geomint", ours), ("heyoka", theirs)):
        best = min((name for name in runners if name in seconds), key=lambda name: seconds[name])
        row[code] = {"setting": best, "seconds": seconds[best], "error": errors[best]}
    row["heyoka_over_geomint"] = row["heyoka"]["seconds"] / row["geomint"]["seconds"]
    return row


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    problem = ch.ChaplyginSphere(a=A, D=D).hamiltonized()
    integrators = heyoka_integrators()
    table = {}
    for end in ENDS:
        rows = [compared(problem, integrators, s, end, arguments.repeats) for s in STATES]
        ratios = [row["heyoka_over_geomint"] for row in rows]
        table[f"{end:g}"] = {
            "geometric_mean": statistics.geometric_mean(ratios),
            "least": min(ratios),
            "largest": max(ratios),
            "states": rows,
        }
        print(end, {k: v for k, v in table[f"{end:g}"].items() if k != "states"})
    result = {
        "benchmark": "hamiltonized-states",
        "goal": GOAL,
        "ends": table,
        "repeats": arguments.repeats,
        "machine": describe(["geomint", "heyoka", "numba", "numpy"]),
    }
    path = arguments.out / "hamiltonized_states.json"
    path.write_text(json.dumps(result, indent=1), encoding="utf-8")
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
