"""Crossings that events miss, invent or misplace, against a brute-force search.

Random motions of the ball in R³ and of the reduced sphere, by gauss-8 at random steps of 0.5 to 2.5
times the default one, so that many steps have two crossings and more; random events: components at a
level, products and other functions of the state. Brute force: the state at 64 times a step, by real
partial steps. Between two of these there is an odd number of events where the sign has changed, and an
even number where it has not; at an event the function is 0 to 1e-12 of its size. Two crossings between
neighbouring samples cannot be judged so.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

import geomint as gi
from geomint.problems.at_states import values_at
from machine import describe

STAGES = (8, 4, 1, 6, 2, 12, 3)
SAMPLES = 64  # a step
STEPS = 2000  # a run


@gi.event
def product(params: Any, t: Any, y: Any, work: Any) -> Any:
    """Return a product of three numbers of the state, less a bit."""
    return y[0] * y[1] * y[4] - 0.05


@gi.event
def quadratic(params: Any, t: Any, y: Any, work: Any) -> Any:
    """Return a quadratic form."""
    return y[0] * y[0] - 0.7 * y[1] * y[2] + 0.4 * y[3] * y[5] - 0.2


@gi.event
def curved(params: Any, t: Any, y: Any, work: Any) -> Any:
    """Return a function that oscillates faster than the state."""
    return gi.sin(3.0 * y[0] + 2.0 * y[4]) - 0.3 * y[2]


def problems() -> list[gi.Problem]:
    """Return the problems, their states of six numbers."""
    ball = {"name": "chaplygin-ball", "moments": [1.0, 2.0, 3.0], "D": 1.0, "attitude": False}
    sphere = {"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0}
    given = (
        (ball, {"gamma": [0.6, 0.0, 0.8], "k": [1.0, 0.7, -0.4]}),
        (sphere, {"gamma": [0.6, 0.0, 0.8], "p": [0.8, 1.0, -0.6]}),
    )
    return [gi.Scene(system=s, initial=i, time={"t_end": 1.0}).problem for s, i in given]


def judged(problem: gi.Problem, seed: int, stages: int = 8) -> dict[str, int] | None:
    """Return what one motion shows; None if the method does not converge at the step."""
    rng = np.random.default_rng(seed)
    y0 = problem.random_state(rng)
    rows = [f"{piece}[{i}]" for piece, n in problem.pieces for i in range(n)]
    events: dict[str, Any] = {
        f"component {i}": gi.Event(str(rng.choice(rows)), level=float(0.5 * rng.normal()))
        for i in range(2)
    } | {"product": product, "quadratic": quadratic, "curved": curved}
    step = float(rng.uniform(0.5, 2.5)) * gi.Gauss(8).default_step(problem, y0, 1.0)
    step *= 0.1 * (stages + 2)
    t = step / SAMPLES * np.arange(STEPS * SAMPLES)
    try:
        run = gi.solve(
            problem,
            y0,
            t_end=step * STEPS,
            method=gi.Gauss(stages),
            step=step,
            events=events,
            dense=True,
            progress=False,
        )
        states = run.sol(np.minimum(t, run.t[-1]))
    except gi.ConvergenceError:
        return None
    found = {"crossings": 0, "missed": 0, "invented": 0, "misplaced": 0, "steps with several": 0}
    for name, event in events.items():
        function = event.function(problem)
        values = values_at(problem, function, states)
        changed = np.sign(values[1:]) != np.sign(values[:-1])
        times = run.events[name].tau
        counts = np.histogram(times, bins=t)[0]
        near = np.zeros(
            len(counts), dtype=bool
        )  # an event so near a sample that its side is rounding
        at = np.searchsorted(t, times)
        for k in (at - 1, at):
            inside = (k >= 0) & (k < len(t))
            close = np.abs(times[inside] - t[k[inside]]) < 1e-9 * step
            for where in (k[inside][close] - 1, k[inside][close]):
                near[where[(where >= 0) & (where < len(near))]] = True
        odd = counts % 2 == 1
        met = np.abs(values_at(problem, function, run.events[name].y, times))
        found["misplaced"] += int((met > 1e-12 * np.abs(values).max()).sum())
        found["crossings"] += len(times)
        found["missed"] += int((changed & ~odd & ~near).sum())
        found["invented"] += int((~changed & odd & ~near).sum())
        several = np.histogram(times, bins=step * np.arange(STEPS + 1))[0] > 1
        found["steps with several"] += int(several.sum())
    return found


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--crossings", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    total: dict[str, int] = {}
    seed, motions, refused = arguments.seed, 0, 0
    while total.get("crossings", 0) < arguments.crossings:
        for problem in problems():
            found = judged(problem, seed, STAGES[seed % len(STAGES)])
            refused += found is None
            motions += found is not None
            for key, count in (found or {}).items():
                total[key] = total.get(key, 0) + count
            if found and (found["missed"] or found["invented"] or found["misplaced"]):
                print(problem.name, seed, found)
        seed += 1
    result = {
        "benchmark": "events-missed",
        **total,
        "motions": motions,
        "not_converged": refused,
        "samples_a_step": SAMPLES,
        "first_seed": arguments.seed,
        "machine": describe(["geomint", "numba", "numpy"]),
    }
    path = arguments.out / "events_missed.json"
    path.write_text(json.dumps(result, indent=1), encoding="utf-8")
    print({k: v for k, v in result.items() if k != "machine"}, f"wrote {path}")


if __name__ == "__main__":
    main()
