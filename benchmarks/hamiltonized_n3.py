"""Run time against error on the Hamiltonised Chaplygin sphere, n = 3: geomint and heyoka.

a = (0.8, 1.1, 1.5), D = 4, γ ∝ (1, 2, 3), p = 6·(0.3, −0.5, 0.2) projected to γ^⊥, T = 2500 in τ. The
error is the largest deviation of the final state (γ, p̃) from a double-double reference. At these
errors rounding decides, and a single run may be lucky: so every setting of either code runs from the
given state and from others near it (p scaled by 1 + j/1000), and its error is the median of all.
The error from the given state alone is kept in the results too. Runs of all settings are
interleaved; the median time counts. Time at a given error is read off the lower envelope of all
settings of a code, by straight lines between its corners in log-log.

heyoka gets its best formulation: of five ways to write the same field (with and without the
1/(γ,γ) factors, polynomial or rational), all are run; those that leave the sphere drop out by
their error.
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

import chaplygin as ch
import geomint as gi
from geomint.compare.reference import reference_solution
from heyoka_fields import SPHERE_FORMS, sphere
from machine import describe

A, D, T = (0.8, 1.1, 1.5), 4.0, 2500.0
STATES = 7
ERRORS = (1e-9, 2e-11)
FLOORS = {1e-9: 4.0, 2e-11: 4.0}
GOALS = {1e-9: 10.0, 2e-11: 8.0}

GEOMINT = [
    (stages, step, tolerance, fused)
    for fused in (False, True)
    for stages in (7, 8)
    for step in (0.2, 0.225, 0.25, 0.28, 0.3125, 0.35, 0.38, 0.4, 0.42, 0.45)
    for tolerance in (0.0, 2.0**-56, 1e-16, 1e-15, 1e-14)
]
HEYOKA = [
    (form, tolerance, high)
    for form in SPHERE_FORMS
    for tolerance in (1e-18, 2.3e-16, 1e-14, 3e-14, 1e-13, 3e-13, 1e-12, 1e-11, 1e-10)
    for high in ((False, True) if tolerance < 1e-15 else (False,))
]

Runner = Callable[[np.ndarray], tuple[float, np.ndarray]]


def geomint_runner(problem: gi.Problem, setting: tuple[Any, ...]) -> Runner:
    """Return a function that integrates from a state and returns (seconds, final state)."""
    stages, step, tolerance, fused = setting
    method = gi.Gauss(stages, iteration_tolerance=tolerance, fused=fused)

    def run(y0: np.ndarray) -> tuple[float, np.ndarray]:
        solution = gi.solve(
            problem, y0, tau_end=T, method=method, step=step, clock=False, progress=False
        )
        return solution.run_seconds, solution.y[-1]

    return run


def heyoka_runner(setting: tuple[Any, ...]) -> Runner:
    """Return a function that integrates from a state and returns (seconds, final state)."""
    import heyoka as hy

    form, tolerance, high = setting
    integrator = hy.taylor_adaptive(
        sphere(form, A, D), [0.5] * 6, tol=tolerance, high_accuracy=high, compact_mode=False
    )

    def run(y0: np.ndarray) -> tuple[float, np.ndarray]:
        integrator.time = 0.0
        integrator.state[:] = y0
        begun = time.perf_counter()
        integrator.propagate_until(T)
        return time.perf_counter() - begun, integrator.state.copy()

    return run


def measure(
    runners: dict[Any, Runner], starts: list[np.ndarray], truths: list[np.ndarray], repeats: int
) -> list[dict[str, Any]]:
    """Run every setting from every state, in turn, `repeats` times; return errors and median times."""
    seconds: dict[Any, list[float]] = {key: [] for key in runners}
    errors: dict[Any, list[float]] = {key: [] for key in runners}
    for run in runners.values():  # compiles and warms up
        run(starts[0])
    for repeat in range(repeats):
        for y0, truth in zip(starts, truths, strict=True):
            for key, run in runners.items():
                elapsed, y = run(y0)
                seconds[key].append(elapsed)
                if repeat == 0:
                    deviation = float(np.max(np.abs(y - truth)))
                    errors[key].append(deviation if np.isfinite(deviation) else np.inf)
    return [
        {
            "code": key[0],
            "setting": list(key[1:]),
            "error": statistics.median(errors[key]),
            "error_given_state": errors[key][0],
            "seconds": statistics.median(seconds[key]),
        }
        for key in runners
        if statistics.median(errors[key]) < 1.0
    ]


def envelope(
    points: list[dict[str, Any]], code: str, error: str = "error"
) -> list[tuple[float, float]]:
    """Return the corners (error, seconds) of a code that no other point of it beats in both."""
    best: list[tuple[float, float]] = []
    own = [p for p in points if p["code"] == code]
    for point in sorted(own, key=lambda p: (p[error], p["seconds"])):
        if not best or point["seconds"] < best[-1][1]:
            best.append((point[error], point["seconds"]))
    return best


def time_at(corners: list[tuple[float, float]], error: float) -> float | None:
    """Return the time at which the envelope reaches an error; None outside of it."""
    if not corners or error < corners[0][0]:
        return None
    x, y = np.log([c[0] for c in corners]), np.log([c[1] for c in corners])
    return float(np.exp(np.interp(np.log(error), x, y)))


def summary(points: list[dict[str, Any]], error: float) -> dict[str, Any]:
    """Return the times of both codes at an error, and their ratio."""
    result: dict[str, Any] = {"floor": FLOORS[error], "goal": GOALS[error]}
    for label, key in (("", "error"), ("_given_state", "error_given_state")):
        ours, theirs = (time_at(envelope(points, c, key), error) for c in ("geomint", "heyoka"))
        result[f"geomint_ms{label}"] = None if ours is None else 1e3 * ours
        result[f"heyoka_ms{label}"] = None if theirs is None else 1e3 * theirs
        result[f"heyoka_over_geomint{label}"] = theirs / ours if ours and theirs else None
    return result


def plot(points: list[dict[str, Any]], path: Path) -> None:
    """Draw all points and the envelopes."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6.5, 4.2), layout="constrained")
    styles = {"geomint": ("#0072B2", "o", "-"), "heyoka": ("#D55E00", "s", "--")}
    for code, (colour, marker, line) in styles.items():
        own = [p for p in points if p["code"] == code]
        if not own:
            continue
        axes.plot(
            [p["error"] for p in own],
            [1e3 * p["seconds"] for p in own],
            marker,
            color=colour,
            alpha=0.25,
            ms=4,
            mew=0,
        )
        corners = envelope(points, code)
        axes.plot(
            [c[0] for c in corners],
            [1e3 * c[1] for c in corners],
            line,
            color=colour,
            marker=marker,
            ms=5,
            label=code,
        )
    for error in ERRORS:
        axes.axvline(error, color="0.7", lw=0.8, zorder=0)
    axes.set(
        xscale="log",
        yscale="log",
        xlim=(1e-12, 1e-5),
        xlabel="error of the final state (max norm, dimensionless)",
        ylabel="run time (ms)",
        title="Hamiltonised Chaplygin sphere, n = 3, T = 2500 in τ",
    )
    axes.set_yticks([2, 3, 5, 10, 20, 30, 50], labels=["2", "3", "5", "10", "20", "30", "50"])
    axes.set_yticks([], minor=True)
    axes.grid(True, which="major", color="0.9")
    axes.legend()
    for suffix in (".png", ".svg"):
        figure.savefig(path.with_suffix(suffix), dpi=160)


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", gi.GeomintWarning)
    problem = ch.ChaplyginSphere(a=A, D=D).hamiltonized()
    p = np.array([1.8, -3.0, 1.2])
    starts = [problem.state(gamma=[1, 2, 3], p=(1 + j / 1000) * p) for j in range(STATES)]
    references = [reference_solution(problem, y0, T) for y0 in starts]
    runners: dict[Any, Runner] = {("geomint", *s): geomint_runner(problem, s) for s in GEOMINT}
    try:
        runners |= {("heyoka", *s): heyoka_runner(s) for s in HEYOKA}
    except ImportError:
        print("heyoka is not installed (extra `peers`): geomint alone")
    points = measure(runners, starts, [r.y for r in references], arguments.repeats)
    table = {f"{error:g}": summary(points, error) for error in ERRORS}
    print(json.dumps(table, indent=1))
    arguments.out.mkdir(parents=True, exist_ok=True)
    result = {
        "benchmark": "hamiltonized-n3",
        "at_error": table,
        "points": points,
        "reference": references[0].as_json(),
        "repeats": arguments.repeats,
        "machine": describe(["geomint", "heyoka", "numba", "numpy"]),
    }
    path = arguments.out / "hamiltonized_n3.json"
    path.write_text(json.dumps(result, indent=1), encoding="utf-8")
    plot(points, path)
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
