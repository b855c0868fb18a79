"""Cost and error of a state at time T: the exact flow against stepping. Picture for docs/systems.md.

    python benchmarks/exact_flow.py [--out DIR] [--longest STEPS]

The Hamiltonised sphere of `hamiltonized_n3`. Integrations are run as long as they take seconds;
beyond, their time is extrapolated (dashed). heyoka, if installed, with its best formulation. The second
part compares the exact flow with integrations in double-double arithmetic at n = 3, 4, 5, that share
nothing with it.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import chaplygin as ch
import geomint as gi
from geomint.compare.reference import reference_solution
from hamiltonized_n3 import A, D as SCALE
from heyoka_fields import sphere
from machine import describe

METHODS = {"gauss-8": 0.25, "gauss-4": 0.1, "verlet-4": 0.05}
COLORS = {
    "gauss-8": "#0072b2",
    "gauss-4": "#d55e00",
    "verlet-4": "#cc79a7",
    "heyoka": "#e69f00",
    "exact flow": "#009e73",
}
TIMES = 10.0 ** np.arange(1, 10)
REPEATS = 5
STATES = 100_000  # of an array


def cost(action: Callable[[], Any], repeats: int = REPEATS) -> float:
    """Return the median of the seconds that it takes."""
    seconds = []
    for _ in range(repeats):
        begun = time.perf_counter()
        action()
        seconds.append(time.perf_counter() - begun)
    return median(seconds)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path(__file__).parents[1] / "docs" / "images")
    parser.add_argument("--longest", type=float, default=2e6)
    arguments = parser.parse_args()
    problem = ch.ChaplyginSphere(a=A, D=SCALE).hamiltonized()
    y = problem.state(gamma=[0.48, 0.6, 0.64], p=[0.8, 1.0, -1.5375])
    record = {"exact flow": exact_costs(problem, y)}
    exact = problem.exact(y)
    for name, step in METHODS.items():
        record[name] = integrations(problem, y, exact, name, step, arguments.longest)
    try:
        record["heyoka"] = heyoka(y, exact, arguments.longest)
    except ImportError:
        print("heyoka is not installed (extra `peers`)")
    checks = [agreement(n) for n in (3, 4, 5)]
    arguments.out.mkdir(parents=True, exist_ok=True)
    picture(record, checks, arguments.out / "exact-flow.png")
    result = {"T": TIMES.tolist(), **record, "against double-double": checks}
    result["machine"] = describe(["geomint", "heyoka", "numba", "numpy"])
    path = Path(__file__).parent / "results" / "exact_flow.json"
    path.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(result, indent=1))


def exact_costs(problem: gi.Problem, y: np.ndarray) -> dict[str, Any]:
    """Return what a state costs with the torus made anew, once it is made, and in an array."""
    exact = problem.exact(y)
    exact(1.0)  # compiled, and the clock made
    rng = np.random.default_rng(1)
    arrays = [rng.uniform(0.0, T, STATES) for T in TIMES]
    return {
        "seconds": [cost(lambda T=T: problem.exact(y).at_tau(T)) for T in TIMES],
        "seconds once made": [cost(lambda T=T: exact.at_tau(T), 50) for T in TIMES],
        "seconds in an array": [cost(lambda at=at: exact.at_tau(at)) / STATES for at in arrays],
        "seconds in an array, physical time": [
            cost(lambda at=at: exact(at)) / STATES for at in arrays
        ],
        "estimated phase error": [float(exact.phase_error(T)) for T in TIMES],
    }


def integrations(
    problem: gi.Problem, y: np.ndarray, exact: Any, name: str, step: float, longest: float
) -> dict[str, Any]:
    """Return run times and errors of a method for as many T as it is run to."""
    seconds, errors = [], []
    for T in TIMES[TIMES / step <= longest]:
        solution = gi.solve(
            problem, y, tau_end=T, method=name, step=step, progress=False, clock=False
        )
        seconds.append(solution.run_seconds)
        errors.append(float(np.max(np.abs(solution.y[-1] - exact.at_tau(T)))))
    return {"step": step, "seconds": seconds, "error": errors}


def heyoka(y: np.ndarray, exact: Any, longest: float) -> dict[str, Any]:
    """Return the same for heyoka's adaptive Taylor series, at its default tolerance."""
    import heyoka as hy

    integrator = hy.taylor_adaptive(
        sphere("polynomial-2", A, SCALE), [0.5] * 6, high_accuracy=True, compact_mode=False
    )
    seconds, errors = [], []
    for T in TIMES[longest / 2 >= TIMES]:
        integrator.time = 0.0
        integrator.state[:] = y
        begun = time.perf_counter()
        integrator.propagate_until(T)
        seconds.append(time.perf_counter() - begun)
        errors.append(float(np.max(np.abs(integrator.state - exact.at_tau(T)))))
    return {"step": "adaptive", "seconds": seconds, "error": errors}


def agreement(n: int) -> dict[str, Any]:
    """Return the deviation of the exact flow from double-double integrations."""
    problem = ch.ChaplyginSphere(a=np.linspace(0.7, 1.5, n), D=4.0).hamiltonized()
    y = problem.random_state(n)
    exact = problem.exact(y)
    taus, deviations = [1.0, 1e2, 1e4], []
    for tau in taus:
        truth = reference_solution(problem, y, tau)
        found = exact.at_tau(tau)
        deviations.append(float(np.max(np.abs(found - truth.y)) / np.max(np.abs(truth.y))))
    return {
        "n": n,
        "tau": taus,
        "deviation": deviations,
        "estimated phase error": [float(exact.phase_error(tau)) for tau in taus],
        "condition": exact.condition,
    }


def picture(record: dict[str, Any], checks: list[dict[str, Any]], path: Path) -> None:
    """Draw cost, error of integrations, and the agreement with double-double arithmetic."""
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(13, 4), layout="constrained")
    for name, found in record.items():
        count, color = len(found["seconds"]), COLORS[name]
        label = "exact flow, torus made anew" if name == "exact flow" else name
        left.loglog(TIMES[:count], found["seconds"], "o-", ms=4, color=color, label=label)
        if count < len(TIMES):
            rate = found["seconds"][-1] / TIMES[count - 1]
            left.loglog(TIMES[count - 1 :], rate * TIMES[count - 1 :], "--", color=color)
        if name != "exact flow":
            step = found["step"]
            detail = f"{name}, {step}" if isinstance(step, str) else f"{name}, step {step:g}"
            errors = np.maximum(found["error"], 1e-17)
            middle.loglog(TIMES[:count], errors, "o-", ms=4, color=color, label=detail)
    own = record["exact flow"]
    green = COLORS["exact flow"]
    left.loglog(
        TIMES, own["seconds once made"], "s--", ms=4, color=green, label="torus made before"
    )
    left.loglog(TIMES, own["seconds in an array"], "^:", ms=4, color=green, label="in an array")
    middle.loglog(
        TIMES, own["estimated phase error"], ":", color=green, label="exact flow, estimated"
    )
    for check, marker, color in zip(checks, "os^", list(COLORS.values())[:3], strict=True):
        deviation = np.maximum(check["deviation"], 1e-17)
        right.loglog(check["tau"], deviation, marker, color=color, label=f"n = {check['n']}")
        right.loglog(check["tau"], check["estimated phase error"], ":", color=color)
    right.plot([], [], ":", color="black", label="estimated")
    left.set_ylabel("time to a state (s)")
    middle.set_ylabel("error of the state against the exact flow")
    right.set_ylabel("exact flow against double-double")
    for axis in (left, middle, right):
        axis.set_xlabel("T in τ (dimensionless)")
        axis.grid(alpha=0.3)
        axis.legend(fontsize=7)
    figure.savefig(path, dpi=120)


if __name__ == "__main__":
    main()
