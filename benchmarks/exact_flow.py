"""Cost and error of a state at time T: the exact flow against stepping. Picture for docs/systems.md.

    python benchmarks/exact_flow.py [--out DIR]

Integrations are run as long as they take seconds; beyond, their time is extrapolated (dashed).
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from statistics import median

import matplotlib.pyplot as plt
import numpy as np

import chaplygin as ch
import geomint as gi

METHODS = {"gauss-8": 0.25, "gauss-4": 0.1, "verlet-4": 0.05}
COLORS = {"gauss-8": "#0072b2", "gauss-4": "#d55e00", "verlet-4": "#cc79a7", "exact": "#009e73"}
LONGEST = 2e6  # steps
TIMES = 10.0 ** np.arange(1, 10)
REPEATS = 5


def cost(action) -> float:
    """Return the median of the seconds that it takes."""
    seconds = []
    for _ in range(REPEATS):
        begun = time.perf_counter()
        action()
        seconds.append(time.perf_counter() - begun)
    return median(seconds)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs/images"))
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
    y = problem.state(gamma=[0.48, 0.6, 0.64], p=[0.8, 1.0, -1.5375])
    exact = problem.exact(y)
    record: dict[str, dict[str, list[float]]] = {}
    record["exact"] = {
        "seconds": [cost(lambda T=T: problem.exact(y).at_tau(T)) for T in TIMES],
        "seconds once made": [cost(lambda T=T: exact.at_tau(T)) for T in TIMES],
        "estimated phase error": [float(exact.phase_error(T)) for T in TIMES],
    }
    for name, step in METHODS.items():
        seconds, errors = [], []
        for T in TIMES:
            if T / step > LONGEST:
                break
            run = {"method": name, "step": step, "progress": False, "clock": False}
            solution = gi.solve(problem, y, tau_end=T, **run)
            seconds.append(solution.run_seconds)
            errors.append(float(np.max(np.abs(solution.y[-1] - exact.at_tau(T)))))
        record[name] = {"step": [step], "seconds": seconds, "error": errors}
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 4), layout="constrained")
    for name, found in record.items():
        count, color = len(found["seconds"]), COLORS[name]
        left.loglog(TIMES[:count], found["seconds"], "o-", ms=4, color=color, label=name)
        if count < len(TIMES):
            rate = found["seconds"][-1] / TIMES[count - 1]
            left.loglog(TIMES[count - 1 :], rate * TIMES[count - 1 :], "--", color=color)
        if name != "exact":
            errors = np.maximum(found["error"], 1e-17)
            label = f"{name}, step {found['step'][0]:g}"
            right.loglog(TIMES[:count], errors, "o-", ms=4, color=color, label=label)
    estimate = record["exact"]["estimated phase error"]
    right.loglog(TIMES, estimate, ":", color=COLORS["exact"], label="exact, estimated")
    left.set_ylabel("time to a state (s)")
    right.set_ylabel("largest error of the state (dimensionless)")
    for axis in (left, right):
        axis.set_xlabel("T in τ (dimensionless)")
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8)
    figure.savefig(out / "exact-flow.png", dpi=150)
    results = Path(__file__).parent / "results" / "exact_flow.json"
    results.write_text(json.dumps({"T": TIMES.tolist(), **record}, indent=1) + "\n")
    print(json.dumps(record, indent=1))


if __name__ == "__main__":
    main()
