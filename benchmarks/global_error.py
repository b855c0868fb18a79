"""Global errors of integrators far out, with the exact flow as truth: phase, torus, frequencies.

    python benchmarks/global_error.py [--out DIR] [--end T]

The Hamiltonised sphere of `hamiltonized_n3`. An integrator's state at T is a point near a torus: its
*phase error* is how far its linear angles are from φ₀ + ωT, and its *torus error* how far its integrals
are from those of the initial state. Each method goes on to the next power of ten as long as that takes
less than 150 s. Frequencies are measured from its trajectory by Laskar's method.
"""

from __future__ import annotations

import argparse
import json
import warnings
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import chaplygin as ch
import geomint as gi
from hamiltonized_n3 import A, D as SCALE
from machine import describe

METHODS = {
    "gauss-8": 0.25,
    "gauss-4": 0.05,
    "verlet-8": 0.1,
    "verlet-4": 0.05,
    "rattle-4": 0.1,
    "dop853": 0.2,
    "rk-4": 0.025,
}
COLORS = ("#0072b2", "#56b4e9", "#cc79a7", "#d55e00", "#e69f00", "#009e73", "#000000")
SAMPLES = 2**14  # of a trajectory, whose frequencies are measured
WINDOW = 5
LONGEST = 150.0  # seconds: no run is begun that would take longer


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path(__file__).parents[1] / "docs" / "images")
    parser.add_argument("--end", type=float, default=1e7)
    arguments = parser.parse_args()
    problem = ch.ChaplyginSphere(a=A, D=SCALE).hamiltonized()
    y = problem.state(gamma=[0.48, 0.6, 0.64], p=[0.8, 1.0, -1.5375])
    exact = problem.exact(y)
    times = 10.0 ** np.arange(1, int(np.log10(arguments.end)) + 1)
    record = {name: errors(problem, y, exact, name, h, times) for name, h in METHODS.items()}
    arguments.out.mkdir(parents=True, exist_ok=True)
    estimate = [float(exact.phase_error(T)) for T in times]
    picture(record, times, estimate, arguments.out / "global-error.png")
    result = {
        "T": times.tolist(),
        "methods": record,
        "estimated phase error of the exact flow": estimate,
        "frequencies": exact.frequencies.tolist(),
        "machine": describe(["geomint", "numba", "numpy"]),
    }
    path = Path(__file__).parent / "results" / "global_error.json"
    path.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    for name, found in record.items():
        print(
            f"{name:10} step {found['step']:<6} {found['seconds']:6.1f} s  phase "
            + " ".join(f"{x:8.1e}" for x in found["phase"])
            + f"  torus {found['torus'][-1]:8.1e}  frequency {found['frequency']:8.1e}"
        )


def errors(
    problem: gi.Problem, y: np.ndarray, exact: Any, name: str, step: float, times: np.ndarray
) -> dict[str, Any]:
    """Return phase and torus errors at all times, and the error of the leading frequency."""
    warnings.simplefilter("ignore", gi.GeomintWarning)  # states that have left the sphere
    phase, torus, seconds = [], [], 0.0
    scale = {key: abs(gi.value(problem, key, y)) for key in problem.invariants}
    for T in times:
        if 10.0 * seconds > LONGEST:
            break
        run = gi.solve(problem, y, tau_end=T, method=name, step=step, progress=False, clock=False)
        seconds, end = run.run_seconds, run.y[-1]
        expected = exact.angles(exact.at_tau(T))
        phase.append(float(np.max(np.abs(turned(exact.angles(end) - expected)))))
        changes = [
            abs(gi.value(problem, key, end) - gi.value(problem, key, y)) / size
            for key, size in scale.items()
        ]
        torus.append(float(max(changes)))
    return {
        "step": step,
        "seconds": seconds,
        "phase": phase,
        "torus": torus,
        "frequency": frequency_error(problem, y, exact, name, step),
    }


def frequency_error(
    problem: gi.Problem, y: np.ndarray, exact: Any, name: str, step: float
) -> float:
    """Return the relative error of the leading frequency of γ_1, by Laskar's method."""
    every = max(1, round(0.25 / step))
    run = gi.solve(
        problem, y, tau_end=step * every * SAMPLES, method=name, step=step, save_every=every,
        progress=False, clock=False,
    )  # fmt: skip
    truth = gi.frequencies(exact.at_tau(run.tau)[:, 0], step * every, order=WINDOW)[0]
    found = gi.frequencies(run.y[:, 0], step * every, order=WINDOW)[0]
    return abs(abs(found.frequency) - abs(truth.frequency)) / abs(truth.frequency)


def turned(x: np.ndarray) -> np.ndarray:
    """Return angles modulo 2π, in [−π, π]."""
    return x - 2 * np.pi * np.rint(x / (2 * np.pi))


def picture(record: dict[str, Any], times: np.ndarray, estimate: list[float], path: Path) -> None:
    """Draw phase and torus errors against time."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
    for (name, found), color in zip(record.items(), COLORS, strict=True):
        label = f"{name}, step {found['step']:g}, {found['seconds']:.0f} s to the last"
        own = times[: len(found["phase"])]
        left.loglog(own, np.maximum(found["phase"], 1e-17), "o-", ms=4, color=color, label=label)
        right.loglog(own, np.maximum(found["torus"], 1e-17), "o-", ms=4, color=color)
    left.loglog(times, estimate, ":", color="black", label="exact flow, estimated")
    left.axhline(np.pi, color="#999999", lw=0.8)
    left.set_ylabel("phase error (rad)")
    right.set_ylabel("largest relative error of H and K")
    for axis in (left, right):
        axis.set_xlabel("T in τ (dimensionless)")
        axis.grid(alpha=0.3)
    figure.legend(fontsize=8, loc="outside right center")
    figure.savefig(path, dpi=120)


if __name__ == "__main__":
    main()
