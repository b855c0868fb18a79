"""Points of a Poincaré section a second: geomint and heyoka, on Chaplygin's ball in R³.

Moments 1, 2, 3, mρ² = 1: (k, γ) without the attitude, from the state of the scene `ball-3d` and the
first random ones whose motion crosses the surface γ₃ = 0 upwards again and again. geomint is called as
a user calls it, `geomint.poincare_section`, with gauss-8 at tolerance 2⁻⁵⁶; heyoka has a non-terminal
event whose callback keeps the time and the state, and tolerance 1e-13. Both run until they have the
points; whole calls, compilation apart. Errors are those of ten of the first 1000 points against
double-double arithmetic; of geomint's steps the fastest is taken whose error is not above heyoka's, if
there is one.
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
from pathlib import Path
from typing import Any

import numpy as np

import geomint as gi
from geomint.compare.reference import integrate_extended
from heyoka_fields import ball as ball_field
from machine import describe

MOMENTS, D = (1.0, 2.0, 3.0), 1.0
TOLERANCE = 1e-13
STEPS = (0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8)
EXTENDED_STEP = 0.25
JUDGED = 1000
METHOD = gi.Gauss(8, iteration_tolerance=2.0**-56)
SURFACE = gi.Event("gamma[2]", "up")


def ball() -> gi.Problem:
    """Return the ball in R³ without its attitude."""
    system = {"name": "chaplygin-ball", "moments": list(MOMENTS), "D": D, "attitude": False}
    initial = {"gamma": [0.6, 0.0, 0.8], "k": [1.0, 0.7, -0.4]}
    scene = gi.Scene(
        system=system, initial=initial, time={"t_end": 1.0}, integrate={"method": "gauss-8"}
    )
    return scene.problem


def heyoka_points(y0: np.ndarray, count: int) -> tuple[float, np.ndarray]:
    """Return the time that heyoka takes for so many points, and the points: time, state."""
    import heyoka as hy

    field = ball_field(MOMENTS, D)
    points: list[np.ndarray] = []

    def met(integrator: Any, t: float, sign: int) -> None:
        integrator.update_d_output(t)
        points.append(np.append(t, integrator.d_output))

    event = hy.nt_event(field[5][0], met, direction=hy.event_direction.positive)
    integrator = hy.taylor_adaptive(field, y0, tol=TOLERANCE, nt_events=[event], compact_mode=False)
    integrator.propagate_until(10.0)  # everything has been called once
    points.clear()
    integrator.time, integrator.state[:] = 0.0, y0
    begun = time.perf_counter()
    while len(points) < count:
        integrator.propagate_for(4096.0 if count > JUDGED else 512.0)
    seconds = time.perf_counter() - begun
    return seconds * count / len(points), np.array(points[:count])


def geomint_points(
    problem: gi.Problem, y0: np.ndarray, count: int, step: float
) -> tuple[float, np.ndarray]:
    """Return the time that geomint takes for so many points, and the points: time, state."""
    begun = time.perf_counter()
    found = gi.poincare_section(
        problem, y0, SURFACE, count, method=METHOD, step=step, progress=False
    )
    return time.perf_counter() - begun, np.column_stack((found.tau, found.y))


def errors(problem: gi.Problem, y0: np.ndarray, points: np.ndarray) -> float:
    """Return the largest error of ten of the points, times included, in double-double arithmetic.

    The truth at a point's time is moved to its own crossing by Newton's method.
    """
    worst = 0.0
    for t, *y in points[len(points) // 10 - 1 :: len(points) // 10]:
        truth = np.asarray(integrate_extended(problem, y0, t, EXTENDED_STEP)[: problem.rows], float)
        rate = gi.derivative(problem, truth)
        late = -truth[5] / rate[5]
        worst = max(worst, abs(late), float(np.abs(truth + late * rate - y).max()))
    return worst


def compared(problem: gi.Problem, y0: np.ndarray, count: int, repeats: int) -> dict[str, Any]:
    """Return points a second and errors of both codes from one state."""
    _, theirs = heyoka_points(y0, JUDGED)
    row: dict[str, Any] = {"heyoka_error": errors(problem, y0, theirs)}
    settings = {}
    for step in STEPS:
        try:
            _, ours = geomint_points(problem, y0, JUDGED, step)
        except gi.ConvergenceError:
            continue
        settings[step] = errors(problem, y0, ours)
    good = [step for step, error in settings.items() if error <= row["heyoka_error"]]
    good = good or [min(settings, key=lambda s: settings[s])]
    quick = {h: min(geomint_points(problem, y0, 5000, h)[0] for _ in range(2)) for h in good}
    step = min(quick, key=lambda h: quick[h])
    seconds: dict[str, list[float]] = {"geomint": [], "heyoka": []}
    for _ in range(repeats):
        seconds["geomint"].append(geomint_points(problem, y0, count, step)[0])
        seconds["heyoka"].append(heyoka_points(y0, count)[0])
    row |= {"geomint_step": step, "geomint_error": settings[step]}
    row |= {f"{code}_per_second": count / statistics.median(s) for code, s in seconds.items()}
    row["ratio"] = row["geomint_per_second"] / row["heyoka_per_second"]
    return row


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=100_000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--states", type=int, default=8)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    problem = ball()
    starts = [problem.state(gamma=[0.6, 0.0, 0.8], k=[1.0, 0.7, -0.4])]
    seed = 0
    while len(starts) <= arguments.states:  # not all motions cross the surface
        y0, seed = problem.random_state(seed), seed + 1
        if gi.poincare_section(problem, y0, SURFACE, 200, step=0.8, progress=False).complete:
            starts.append(y0)
    rows = []
    for y0 in starts:
        rows.append(compared(problem, y0, arguments.points, arguments.repeats))
        print(rows[-1])
    ratios = [row["ratio"] for row in rows]
    result = {
        "benchmark": "section-points",
        "points": arguments.points,
        "tolerance": TOLERANCE,
        "states": rows,
        "geometric_mean": statistics.geometric_mean(ratios),
        "least": min(ratios),
        "repeats": arguments.repeats,
        "machine": describe(["geomint", "heyoka", "numba", "numpy"]),
    }
    path = arguments.out / "section_points.json"
    path.write_text(json.dumps(result, indent=1), encoding="utf-8")
    print(result["geometric_mean"], result["least"], f"wrote {path}")


if __name__ == "__main__":
    main()
