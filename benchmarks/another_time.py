"""Uneven motions by ``method="auto"``: in another time, and in their own.

    python benchmarks/another_time.py [--out DIR] [--images DIR]

Orbits of Kepler's of semi-axis 1 from both apsides, whose truth is Kepler's equation, and geodesics of
the ellipsoid with semi-axes 1, 5, 30, whose truth is a run by twelve stages in the time of N. *Call*:
the least time of a whole call of `geomint.solve` with a tolerance, in turns; "fixed" is the method that
``"auto"`` begins with, in the motion's own time, "adaptive" `dop853-adaptive`. Errors are relative to
the largest number of a piece. Left out: runs that are too short for another time.
"""

from __future__ import annotations

import argparse
import json
import math
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import chaplygin as ch
import geomint as gi
import trap_families as traps
from geomint.plots.canvas import new_figure
from geomint.plots.style import COLOURS, WIDTH
from geomint.run.accuracy.auto import auto_method
from machine import describe
from tolerance import least_seconds
from traps import sizes_of

ECCENTRICITIES = (0.5, 0.7, 0.8, 0.9, 0.95, 0.98)
TOLERANCES = (1e-6, 1e-9)
ORBITS, GEODESIC = 2000.25, 20_000.0  # revolutions; length
LABELS = {
    "auto": 'method="auto"',
    "fixed": "Gauss, even steps of t",
    "adaptive": "dop853-adaptive",
}
ALL = tuple(LABELS)
Case = tuple[str, float | None, gi.Problem, np.ndarray, float, np.ndarray, np.ndarray]


def orbits() -> Iterator[Case]:
    """Return names, eccentricities, problems, states, ends, what is there, and sizes of numbers."""
    problem = traps.problem_of(traps.kepler, 4, (1.0,))
    end = 2.0 * math.pi * ORBITS
    for e in ECCENTRICITIES:
        for side, name in ((-1, "pericentre"), (1, "apocentre")):
            y0 = np.array(
                [1.0 + side * e, 0.0, 0.0, math.sqrt((1.0 - side * e) / (1.0 + side * e))]
            )
            mean = math.remainder(end, 2.0 * math.pi)
            anomaly = mean
            for _ in range(200):
                anomaly += (mean + side * -e * math.sin(anomaly) - anomaly) / (
                    1.0 + side * e * math.cos(anomaly)
                )
            s, c, b = math.sin(anomaly), math.cos(anomaly), math.sqrt(1.0 - e * e)
            r = 1.0 + side * e * c
            there = np.array([c + side * e, b * s, -s / r, b * c / r])
            sizes = np.repeat([1.0 + e, math.sqrt((1.0 + e) / (1.0 - e))], 2)
            yield f"from the {name}", e, problem, y0, end, there, sizes


def geodesics() -> Iterator[Case]:
    """Return the same of geodesics."""
    problem = ch.ellipsoid_problem([1.0, 25.0, 900.0])
    for seed in range(2):
        y0 = problem.random_state(seed)
        y0[3:] /= np.linalg.norm(y0[3:])
        uneven = gi.time_transformed(problem, "normal_squared", y0)
        given = {"t_end": GEODESIC, "method": gi.Gauss(12), "progress": False}
        run = gi.solve(uneven, y0, **given, tolerance=1e-12, save_every=1)
        yield f"geodesic {seed}", None, problem, y0, GEODESIC, run.y[-1], sizes_of(problem, run.y)


def of_case(case: Case, tolerance: float) -> dict[str, Any]:
    """Return errors and times of all ways."""
    name, e, problem, y0, end, there, sizes = case
    fixed = auto_method(problem, tolerance)[0]
    methods = dict(zip(ALL, ("auto", fixed, "dop853-adaptive"), strict=True))
    given = {"t_end": end, "tolerance": tolerance, "progress": False}
    found: dict[str, Any] = {"motion": name, "e": e, "tolerance": tolerance}

    def run(way: str) -> gi.Solution:
        return gi.solve(problem, y0, **given, method=methods[way])

    runs = {way: run(way) for way in ALL}
    times = least_seconds([lambda way=way: run(way) for way in ALL], 3)
    for (way, sol), seconds in zip(runs.items(), times, strict=True):
        error = float(np.max(np.abs(sol.y[-1] - there) / sizes)) / tolerance
        found[way] = {
            "problem": sol.problem.name,
            "evaluations": sol.evaluations,
            "error_over_tolerance": float(f"{error:.3g}"),
            "call_milliseconds": float(f"{1e3 * seconds:.4g}"),
        }
    return found


def picture(rows: list[dict[str, Any]], path: Path) -> None:
    """Draw the times of calls against the eccentricity, of both apsides the mean."""
    with new_figure(1.5 * WIDTH, 0.6 * WIDTH, layout="constrained") as figure:
        for axes, tolerance in zip(figure.subplots(1, 2, sharey=True), TOLERANCES, strict=True):
            for way, colour in zip(ALL, COLOURS, strict=False):
                some = [
                    (r["e"], r[way]["call_milliseconds"])
                    for r in rows
                    if r["tolerance"] == tolerance
                ]
                times = [
                    np.exp(np.mean([np.log(ms) for e, ms in some if e == one]))
                    for one in ECCENTRICITIES
                ]
                at = range(len(ECCENTRICITIES))
                axes.semilogy(at, times, "o-", ms=4, color=colour, label=LABELS[way])
            axes.set_xticks(at, [f"{e:g}" for e in ECCENTRICITIES])
            axes.set(xlabel="eccentricity", title=f"tolerance {tolerance:g}")
        figure.axes[0].set(ylabel="a call, ms")
        figure.axes[0].legend(frameon=False)
        figure.savefig(path, dpi=130)


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    images = Path(__file__).parents[1] / "docs" / "images"
    parser.add_argument("--images", type=Path, default=images)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", gi.GeomintWarning)
    rows = []
    for case in (*orbits(), *geodesics()):
        for tolerance in TOLERANCES:
            rows.append(of_case(case, tolerance))
            row = rows[-1]
            told = ", ".join(f"{way} {row[way]['call_milliseconds']:g} ms" for way in ALL)
            print(row["motion"], row["e"], tolerance, row["auto"]["problem"], told, flush=True)
    result = {"rows": rows, "machine": describe(["geomint", "numba", "numpy"])}
    text = json.dumps(result, indent=1, ensure_ascii=False) + "\n"
    (arguments.out / "another_time.json").write_text(text, encoding="utf-8")
    picture(rows, arguments.images / "another-time.png")


if __name__ == "__main__":
    main()
