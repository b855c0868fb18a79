"""States at 1000 given physical times, T = 100: geomint and heyoka, from random states of the ball.

Two problems of one ball, n = 3: the reduced sphere, in physical time, and the Hamiltonised one in τ, at
physical times; heyoka integrates the reduced sphere for both, in the faster of two ways to write it,
and its `propagate_grid` gives the states. geomint is called as a user calls it, ``geomint.solve(…,
t_eval=…)``: everything included. γ and the direction of p are those of `random_state(0 … 15)`, and |p|
is that of the scene `sphere-n3`. For each state the fastest setting of either code counts whose largest
error at all times is below the goal, against a run of the other code at its finest; the two finest runs
have to agree. Codes take turns; medians of the repeats; geometric mean, least and largest ratio.
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
from hamiltonized_n3 import A, D
from machine import describe

T, COUNT = 100.0, 1000
GOALS = (1e-11, 1e-9)
STATES = range(16)
TIMES = np.linspace(0.0, T, COUNT)
STEPS = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0, 1.2, 1.5, 2.0)
ITERATED_TO = (0.0, 1e-13, 1e-11)
TOLERANCES = (2.3e-16, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10)

Runner = Callable[[], np.ndarray]


def heyoka_field(on_sphere: bool) -> list[Any]:
    """Return the reduced field in physical time; on the sphere (γ, γ) = 1 and (γ, p) = 0."""
    import heyoka as hy

    g, p = hy.make_vars("g1", "g2", "g3"), hy.make_vars("p1", "p2", "p3")

    def dot(x: Any, y: Any, weights: Any = (1.0, 1.0, 1.0)) -> Any:
        return hy.sum([w * u * v for w, u, v in zip(weights, x, y, strict=True)])

    inverse = [1.0 / a for a in A]
    u, pp, bgp = dot(g, g, inverse), dot(p, p), dot(g, p, inverse)
    gag, gap, pap = dot(g, g, A), dot(g, p, A), dot(p, p, A)
    g2, gp = (1.0, 0.0) if on_sphere else (dot(g, g), dot(g, p))
    s = 1.0 / (D * D * u)
    r = D * s
    gaq, paq = s * (g2 * gap - gp * gag), s * (g2 * pap - gp * gap)
    pq = r * (g2 * pp - gp * gp)
    q = [g2 * p[i] - gp * g[i] for i in range(3)]
    field = [(g[i], (r * u - s * g2 * A[i]) * q[i] + gaq * g[i]) for i in range(3)]
    return field + [
        (p[i], (r * bgp - s * gp * A[i]) * q[i] + (paq - pq * inverse[i]) * g[i]) for i in range(3)
    ]


def heyoka_runners(integrators: dict[str, Any], y0: np.ndarray) -> dict[str, Runner]:
    """Return functions that give the states at all times, by setting."""

    def runner(integrator: Any) -> Runner:
        def run() -> np.ndarray:
            integrator.time = 0.0
            integrator.state[:] = y0
            return np.asarray(integrator.propagate_grid(TIMES)[-1])

        return run

    return {name: runner(integrator) for name, integrator in integrators.items()}


def geomint_runners(problem: gi.Problem, y0: np.ndarray) -> dict[str, Runner]:
    """Return functions that give the states at all times, by setting."""

    def runner(step: float, tolerance: float) -> Runner:
        method = gi.Gauss(8, iteration_tolerance=tolerance)

        def run() -> np.ndarray:
            options: dict[str, Any] = {"method": method, "step": step, "progress": False}
            return np.asarray(gi.solve(problem, y0, t_end=T, t_eval=TIMES, **options).y)

        return run

    return {
        f"gauss-8, step {step}, tolerance {tolerance:g}": runner(step, tolerance)
        for step in STEPS
        for tolerance in ITERATED_TO
    }


def seconds_of(runners: dict[str, Runner], repeats: int) -> dict[str, float]:
    """Return the median wall time of each setting, all of them in turn."""
    seconds: dict[str, list[float]] = {name: [] for name in runners}
    for _ in range(repeats):
        for name, run in runners.items():
            begun = time.perf_counter()
            run()
            seconds[name].append(time.perf_counter() - begun)
    return {name: statistics.median(values) for name, values in seconds.items()}


def state(reduced: gi.Problem, seed: int, speed: float) -> np.ndarray:
    """Return a random state of the given |p|."""
    z = reduced.random_state(seed)
    z[3:] *= speed / np.linalg.norm(z[3:])
    return z


def compared(
    problem: gi.Problem, sphere: Any, integrators: Any, seed: int, speed: float, repeats: int
) -> Any:
    """Return by goal the fastest setting of both codes from one state, with times and errors."""
    finest, reduced = integrators["finest"], sphere.reduced()
    z0 = state(reduced, seed, speed)
    y0 = z0 if problem.name == reduced.name else hamiltonised(problem, z0)
    (truth,) = heyoka_runners({"": finest}, z0).values()
    theirs_finest = as_reduced(problem, truth(), True)
    ours_finest = as_reduced(
        problem,
        gi.solve(problem, y0, t_end=T, t_eval=TIMES, step=0.1, method="gauss-12", progress=False).y,
        False,
    )
    assert np.abs(ours_finest - theirs_finest).max() < 0.5 * min(GOALS), "the truths differ"
    others = {name: i for name, i in integrators.items() if name != "finest"}
    ours, theirs = geomint_runners(problem, y0), heyoka_runners(others, z0)
    errors: dict[str, float] = {}
    for runners, known, own in ((ours, theirs_finest, False), (theirs, ours_finest, True)):
        for name, run in runners.items():
            try:
                error = float(np.abs(as_reduced(problem, run(), own) - known).max())
            except gi.ConvergenceError:
                continue
            if error < max(GOALS):
                errors[name] = error
    seconds = seconds_of({k: r for k, r in {**ours, **theirs}.items() if k in errors}, repeats)
    found = {}
    for goal in GOALS:
        row: dict[str, Any] = {"seed": seed}
        for code, runners in (("geomint", ours), ("heyoka", theirs)):
            good = [name for name in runners if errors.get(name, np.inf) < goal]
            if good:
                best = min(good, key=lambda name: seconds[name])
                row[code] = {"setting": best, "seconds": seconds[best], "error": errors[best]}
        if "geomint" in row and "heyoka" in row:
            row["geomint_over_heyoka"] = row["geomint"]["seconds"] / row["heyoka"]["seconds"]
        found[f"{goal:g}"] = row
    return found


def multiplier(gamma: np.ndarray) -> np.ndarray:
    """Return p̃/p, Chaplygin's multiplier, at one γ a row."""
    return np.asarray(1.0 / (D * np.sqrt((gamma**2 / np.array(A)).sum(axis=-1))))


def hamiltonised(problem: gi.Problem, z: np.ndarray) -> np.ndarray:
    """Return (γ, p̃) of (γ, p)."""
    return np.concatenate([z[:3], z[3:] * multiplier(z[:3])])


def as_reduced(problem: gi.Problem, states: np.ndarray, reduced: bool) -> np.ndarray:
    """Return (γ, p) of either."""
    if reduced or problem.time == "t":
        return states
    return np.hstack([states[:, :3], states[:, 3:] / multiplier(states[:, :3])[:, None]])


def heyoka_integrators() -> dict[str, Any]:
    """Return an integrator for each formulation and tolerance."""
    import heyoka as hy

    def made(on_sphere: bool, tolerance: float, high: bool = False) -> Any:
        return hy.taylor_adaptive(
            heyoka_field(on_sphere),
            [0.5] * 6,
            tol=tolerance,
            high_accuracy=high,
            compact_mode=False,
        )

    settings = {
        f"{'on-sphere' if on else 'rational'}, tolerance {tolerance:g}": made(on, tolerance)
        for on in (True, False)
        for tolerance in TOLERANCES
    }
    return {**settings, "finest": made(False, 1e-18, high=True)}


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--speed", type=float, default=5.22, help="the size of p")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    speed, repeats = arguments.speed, arguments.repeats
    sphere = ch.ChaplyginSphere(a=A, D=D)
    integrators = heyoka_integrators()
    table = {}
    for problem in (sphere.reduced(), sphere.hamiltonized()):
        rows = [compared(problem, sphere, integrators, s, speed, repeats) for s in STATES]
        table[problem.name] = {}
        for goal in rows[0]:
            both = [row[goal] for row in rows if "geomint_over_heyoka" in row[goal]]
            ratios = [row["geomint_over_heyoka"] for row in both]
            table[problem.name][goal] = {
                "geometric_mean": statistics.geometric_mean(ratios),
                "least": min(ratios),
                "largest": max(ratios),
                "states": [row[goal] for row in rows],
            }
            print(
                problem.name, goal, [f"{x:.2f}" for x in ratios], statistics.geometric_mean(ratios)
            )
    y0 = sphere.reduced().random_state(0)
    million = np.linspace(0.0, 1000.0, 10**6)
    begun = time.perf_counter()
    gi.solve(sphere.reduced(), y0, t_end=1000.0, t_eval=million, progress=False)
    result = {
        "benchmark": "states-at-times",
        "problems": table,
        "seconds_for_a_million": time.perf_counter() - begun,
        "repeats": arguments.repeats,
        "machine": describe(["geomint", "heyoka", "numba", "numpy"]),
    }
    print("a million times:", result["seconds_for_a_million"])
    path = arguments.out / "states_at_times.json"
    path.write_text(json.dumps(result, indent=1), encoding="utf-8")
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
