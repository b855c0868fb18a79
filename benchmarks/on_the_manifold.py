"""What a symplectic map on T*S² costs: methods at an error of 1e-9 against gauss-8.

The Hamiltonised sphere, n = 3, to τ = 100 from γ = (1, 2, 3)/√14, p = (1.8, −3, 1.2), and from random
states. Of each method the longest step that keeps the end within 1e-9 of the exact flow, found by a
sweep; process time, medians, one process, methods by turns: of whole calls of `geomint.solve`, and of
the steps alone, a tenth of what τ = 1100 takes more. Writes ``results/on_the_manifold.json``.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import chaplygin as ch
import geomint as gi
from machine import describe

END, ERROR = 100.0, 1e-9
METHODS = ("gauss-8", "lobatto-8", "verlet-8", "verlet-10", "rattle-8", "rattle-10")
PROBLEM = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()


def solved(method: str, y0: Any, steps: int, times: int = 1) -> tuple[float, Any]:
    """Return the process time of a run, so many times as long, and its end; none if it fails."""
    begun = time.process_time()
    try:
        end = gi.solve(PROBLEM, y0, tau_end=times * END, method=method, step=END / steps).y[-1]
    except gi.StepError:
        end = None
    return time.process_time() - begun, end


def best_steps(method: str, y0: Any, exact: Any) -> int:
    """Return the least number of steps, 5 % more each time, with an error below that wanted."""
    steps = 20.0
    good = 0
    first = 0
    while good < 2:  # two in a row: an error may pass through zero
        steps = math.ceil(1.05 * steps)
        end = solved(method, y0, int(steps))[1]
        good = good + 1 if end is not None and np.max(np.abs(end - exact)) < ERROR else 0
        first = int(steps) if good == 1 else first
    return first


def main() -> None:
    """Find the steps, take times by turns, print the ratios and write them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--states", type=int, default=8)
    parser.add_argument("--repeats", type=int, default=15)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", gi.GeomintWarning)
    states = {"readme": PROBLEM.state(gamma=[1, 2, 3], p=[1.8, -3.0, 1.2])}
    states |= {f"random {k}": PROBLEM.random_state(k) for k in range(arguments.states)}
    found: dict[str, Any] = {}
    for name, y0 in states.items():
        exact = np.ravel(PROBLEM.exact(y0).at_tau(END))[:6]
        steps = {method: best_steps(method, y0, exact) for method in METHODS}
        calls: dict[str, list[float]] = {method: [] for method in METHODS}
        alone: dict[str, list[float]] = {method: [] for method in METHODS}
        for _ in range(arguments.repeats):
            for method in METHODS:
                solved(method, y0, steps[method])  # after another method the first call is slower
                whole, longer = (solved(method, y0, steps[method], k)[0] for k in (1, 11))
                calls[method].append(whole)
                alone[method].append((longer - whole) / 10)
        found[name] = {"steps": steps}
        for kind, times in (("call", calls), ("steps alone", alone)):
            seconds = {method: statistics.median(t) for method, t in times.items()}
            found[name][kind] = seconds
            ratios = {m: f"{t / seconds['gauss-8']:.2f}" for m, t in seconds.items()}
            print(name, kind, f"gauss-8 {1e3 * seconds['gauss-8']:.3f} ms", ratios)
        print(name, steps)
    means: dict[str, dict[str, float]] = {"call": {}, "steps alone": {}}
    for kind, mean in means.items():
        for method in METHODS:
            logs = [math.log(x[kind][method] / x[kind]["gauss-8"]) for x in found.values()]
            mean[method] = math.exp(statistics.fmean(logs))
        print("geometric means", kind, {method: round(x, 2) for method, x in mean.items()})
    result = {
        "benchmark": "on-the-manifold",
        "states": found,
        "means": means,
        "repeats": arguments.repeats,
        "machine": describe(["geomint", "numba", "numpy"]),
    }
    path = arguments.out / "on_the_manifold.json"
    path.write_text(json.dumps(result, indent=1), encoding="utf-8")
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
