"""Ensembles: what lanes, cores and members cost, and heyoka's ensembles beside them.

Throughput: seconds a step of single runs (`run_seconds`, median over states) over those of a member
of an ensemble on one core (wall time of the whole call). What vectors gain at most here is in
`vector_limit`. Overhead: wall time of a call with short runs, less that of the steps, a member.
Cores: wall times of one thread over two. heyoka: 4096 random states of the Hamiltonised sphere to
T = 250 in τ, both cores, an error of 1e-9 (the 95th percentile over 64 states, against double-double
references), each at its fastest setting: ours by stages, step and tolerance of the iteration,
heyoka's by tolerance and batch.
"""

from __future__ import annotations

import argparse
import itertools
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
from hamiltonized_n3 import A, D
from heyoka_fields import sphere
from machine import describe
from vector_limit import vector_limit

LANES = {
    "hamiltonized-n3": ("rk-4", "dop853", "verlet-4", "gauss-8"),
    "ball-3d": ("rk-4", "rkmk-4", "cf-4"),
    "hamiltonized-n5": ("rk-4", "dop853"),
}
FLOORS = {"rk-4": 6.0, "dop853": 6.0, "rkmk-4": 5.0, "cf-4": 4.5}
MEMBERS, JUDGED, T, ERROR = 4096, 64, 250.0, 1e-9
STEPS = (0.25, 0.3, 0.35, 0.4, 0.45, 0.5)
TOLERANCES = (1e-10, 1e-11, 1e-12, 1e-13)


def seconds(call: Callable[[], Any], repeats: int) -> float:
    """Return the median wall time of a call, after one that is not counted."""
    call()
    times = []
    for _ in range(repeats):
        begun = time.perf_counter()
        call()
        times.append(time.perf_counter() - begun)
    return statistics.median(times)


def states_of(problem: gi.Problem, count: int) -> np.ndarray:
    """Return random states, from seeds that begin with 0."""
    return np.array([problem.random_state(seed) for seed in range(count)])


def lanes(scene: str, name: str, repeats: int) -> dict[str, float]:
    """Return the times of a step, alone and in company, and of two cores."""
    problem = gi.load_scene(scene).problem
    states = states_of(problem, 256)
    end = "tau_end" if problem.time == "tau" else "t_end"
    asked: dict[str, Any] = {"method": name, "step": 0.05, end: 500.0, "progress": False}
    steps = 10_000
    runs = [gi.solve(problem, y, **asked).run_seconds / steps for y in states[:24]]
    single = statistics.median(runs)
    one, two = (
        seconds(lambda w=w: gi.solve_ensemble(problem, states, workers=w, **asked), repeats)
        for w in (1, 2)
    )
    member = one / (steps * len(states))
    return {
        "single_ns": 1e9 * single,
        "member_ns": 1e9 * member,
        "throughput": single / member,
        "cores": one / two,
    }


def overhead(repeats: int) -> dict[str, float]:
    """Return microseconds a member of a call with short runs, less those of its steps."""
    problem = ch.ChaplyginSphere(a=A, D=D).hamiltonized()
    states = states_of(problem, MEMBERS)
    found = {}
    for name in ("rk-4", "gauss-8"):
        asked: dict[str, Any] = {"method": name, "step": 0.25, "progress": False}
        short, long = (
            seconds(
                lambda e=e, a=asked: gi.solve_ensemble(problem, states, tau_end=e, **a), repeats
            )
            for e in (10.0, 50.0)
        )
        found[name] = 1e6 * (short - (long - short) / 4.0) / MEMBERS
    return found


def ours(repeats: int) -> list[dict[str, Any]]:
    """Return error and time of the ensemble for every step."""
    problem = ch.ChaplyginSphere(a=A, D=D).hamiltonized()
    states = states_of(problem, MEMBERS)
    truths = truth(problem, states)
    found = []
    for stages, tolerance in itertools.product((6, 7, 8), (0.0, 1e-15, 1e-13)):
        method = gi.Gauss(stages, iteration_tolerance=tolerance)
        for step in STEPS:
            asked: dict[str, Any] = {"method": method, "step": step, "clock": False}
            run = lambda some, a=asked: gi.solve_ensemble(  # noqa: E731
                problem, some, tau_end=T, progress=False, **a
            )
            few = run(states[:JUDGED])
            error = percentile(few.final, truths) if few.success else np.inf
            took = seconds(lambda r=run: r(states), repeats) if error < ERROR else np.nan
            setting = {"stages": stages, "tolerance": tolerance, "step": step}
            found.append({**setting, "error": error, "seconds": took})
    return found


def truth(problem: gi.Problem, states: np.ndarray) -> np.ndarray:
    """Return references of the first states."""
    return np.array([reference_solution(problem, y, T).y for y in states[:JUDGED]])


def percentile(ends: np.ndarray, truths: np.ndarray) -> float:
    """Return the error that 95 of 100 states are within."""
    return float(np.quantile(np.abs(ends - truths).max(axis=1), 0.95))


def theirs(repeats: int) -> list[dict[str, Any]]:
    """Return error and time of heyoka's ensembles for every setting."""
    import heyoka as hy

    problem = ch.ChaplyginSphere(a=A, D=D).hamiltonized()
    states = states_of(problem, MEMBERS)
    truths = truth(problem, states)
    found = []
    for form in ("polynomial-2", "homogeneous"):
        for tolerance in TOLERANCES:
            for batch in (1, 4, 8):
                few = heyoka_run(hy, form, tolerance, batch, states[:JUDGED])
                error = percentile(few(), truths)
                run = heyoka_run(hy, form, tolerance, batch, states)
                took = seconds(run, repeats) if error < ERROR else np.nan
                setting = {"form": form, "tolerance": tolerance, "batch": batch}
                found.append({**setting, "error": error, "seconds": took})
    return found


def heyoka_run(
    hy: Any, form: str, tolerance: float, batch: int, states: np.ndarray
) -> Callable[[], np.ndarray]:
    """Return what integrates all states with heyoka on both cores."""
    shared = {"tol": tolerance, "compact_mode": False}
    if batch == 1:
        template = hy.taylor_adaptive(sphere(form, A, D), [0.5] * 6, **shared)

        def begin(integrator: Any, i: int) -> Any:
            integrator.state[:] = states[i]
            integrator.time = 0.0
            return integrator

        def run() -> np.ndarray:
            done = hy.ensemble_propagate_until(template, T, len(states), begin)
            return np.array([ended[0].state for ended in done])

        return run
    template = hy.taylor_adaptive_batch(sphere(form, A, D), np.full((6, batch), 0.5), **shared)

    def begin_batch(integrator: Any, i: int) -> Any:
        integrator.state[:] = states[i * batch : (i + 1) * batch].T
        integrator.set_time([0.0] * batch)
        return integrator

    def run_batches() -> np.ndarray:
        done = hy.ensemble_propagate_until_batch(template, T, len(states) // batch, begin_batch)
        return np.concatenate([ended[0].state.T for ended in done])

    return run_batches


def fastest(points: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the fastest point that is accurate enough."""
    return min((p for p in points if p["error"] < ERROR), key=lambda p: p["seconds"])


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--without-heyoka", action="store_true")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    path = arguments.out / "ensembles.json"
    result: dict[str, Any] = {"benchmark": "ensembles", "floors": FLOORS, "lanes": {}}
    for scene, names in LANES.items():
        for name in names:
            found = lanes(scene, name, arguments.repeats)
            result["lanes"].setdefault(scene, {})[name] = found
            print(scene, name, {k: round(v, 2) for k, v in found.items()}, flush=True)
    result["overhead_us"] = overhead(arguments.repeats)
    print(result["overhead_us"], flush=True)
    if not arguments.without_heyoka:
        own, other = ours(arguments.repeats), theirs(arguments.repeats)
        best = {"geomint": fastest(own), "heyoka": fastest(other)}
        ratio = best["heyoka"]["seconds"] / best["geomint"]["seconds"]
        result["heyoka"] = {
            "members": MEMBERS, "end": T, "error": ERROR, "best": best, "ratio": ratio,
            "floor": 1.0, "goal": 1.5,
        }  # fmt: skip
        print(best, round(ratio, 2))
    result["vectors"] = vector_limit()
    print(result["vectors"])
    result["machine"] = describe(["geomint", "heyoka", "numba", "numpy"])
    path.write_text(json.dumps(result, indent=1), encoding="utf-8")
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
