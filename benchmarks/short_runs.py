"""What a short call costs: an integrator in the hand, and `geomint.solve`, over four steps.

Goals, medians: four steps of an integrator 10 µs; `solve` over four steps 100 µs, with three
quantities watched 200 µs, to an end in physical time of a problem in τ 200 µs.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import chaplygin as ch
import geomint as gi
from hamiltonized_n3 import A, D
from machine import describe

STATES = range(8)
STEP, STEPS = 0.05, 4
GOALS = {"integrator": 10.0, "solve": 100.0, "solve, observe": 200.0, "solve, t_end": 200.0}


def calls(problem: gi.Problem, seed: int) -> dict[str, Callable[[], Any]]:
    """Return what is timed, from one state."""
    y0 = problem.random_state(seed)
    motion = gi.Integrator(problem, y0, "gauss-8", step=STEP)
    watched = list(problem.diagnostics)[:3]

    def run(**options: Any) -> Callable[[], Any]:
        return lambda: gi.solve(problem, y0, step=STEP, progress=False, **options)

    end = {"tau_end": STEP * STEPS, "clock": False}
    t_end = gi.solve(problem, y0, step=STEP, tau_end=STEP * STEPS, clock=True).t[-1]
    return {
        "integrator": lambda: motion.step(STEPS),
        "solve": run(**end),
        "solve, observe": run(**end, observe=watched),
        "solve, t_end": run(t_end=t_end),
    }


def microseconds(call: Callable[[], Any], repeats: int) -> list[float]:
    """Return the wall time of each call."""
    times = []
    for _ in range(repeats):
        begun = time.perf_counter()
        call()
        times.append((time.perf_counter() - begun) * 1e6)
    return times


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=500)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    problem = ch.ChaplyginSphere(a=A, D=D).hamiltonized()
    found: dict[str, list[float]] = {name: [] for name in GOALS}
    for seed in STATES:
        for name, call in calls(problem, seed).items():
            call()
            found[name] += microseconds(call, arguments.repeats)
    medians = {name: statistics.median(times) for name, times in found.items()}
    result = {
        "benchmark": "short-runs",
        "microseconds": medians,
        "goals": GOALS,
        "states": len(STATES),
        "repeats": arguments.repeats,
        "machine": describe(["geomint", "numba", "numpy"]),
    }
    path = arguments.out / "short_runs.json"
    path.write_text(json.dumps(result, indent=1), encoding="utf-8")
    print({name: round(value, 1) for name, value in medians.items()})
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
