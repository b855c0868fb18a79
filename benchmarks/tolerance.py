"""How well `tolerance=` is met, and what choosing costs, for every built-in scene.

    python benchmarks/tolerance.py [--states 8] [--end 300] [--out DIR] [--images DIR]

From ``random_state(1)`` … of every scene whose motions are regular, to the end in the problem's own
time. The truth is a Gauss method of 12 stages in double-double arithmetic. Errors are the largest of
all numbers of the state at the end, each relative to the largest number that its piece has had on the
way. A motion counts as regular if two that begin 1e-9 apart are at the end less than 400 times as far
apart as after a sixteenth of it.

Three parts. *auto*: error over tolerance with ``method="auto"``, and times against the fastest of many
settings whose error is below the tolerance (stages 5 … 8, sixteen steps each, iterations to rounding):
of the run at the chosen step, and of the whole call, the choosing included; the least of several calls
in turn. *methods*: error over tolerance of a method of each family, from two states. *own*: that of
``method="auto"`` for 13 systems that a user writes, with even motions. An error below a hundredth of
the tolerance is *free* if longer steps would take as many iterations.
"""

from __future__ import annotations

import argparse
import json
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import geomint as gi
import trap_families as traps
from geomint.compare.reference import integrate_extended
from geomint.plots.canvas import new_figure
from geomint.plots.style import COLOURS, WIDTH
from geomint.scene.load import builtin_scenes
from machine import describe
from traps import sizes_of

TOLERANCES = (1e-6, 1e-9, 1e-10)
OWN = {  # fields, parameters, and states near which motions begin
    "pendulum": (traps.pendulum, (1.0, 0.0), (1.2, 0.3)),
    "pendulum that turns": (traps.pendulum, (1.0, 0.0), (0.3, 2.8)),
    "soft spring": (traps.cubic, (0.1,), (1.0, 0.2)),
    "double well": (traps.cubic, (-1.0,), (1.6, 0.3)),
    "far from the origin": (traps.away, (100.0, 1.3), (103.0, 0.2)),
    "body": (traps.euler, (1.0, 2.0, 3.0), (0.3, 0.4, 1.0)),
    "orbit": (traps.kepler, (1.0,), (1.0, 0.0, 0.1, 1.1)),
    "Hénon–Heiles": (traps.henon_heiles, (), (0.1, 0.1, 0.2, 0.1)),
    "gyration": (traps.gyration, (1.0, 0.1), (0.5, 0.2, 0.7, 0.3)),
    "oscillators": (
        traps.oscillators,
        (1.0, 1.3, 0.7, 2.1),
        (1.0, 0.3, 0.5, 0.7, 0.2, 0.3, 0.5, 0.4),
    ),
    "forced": (traps.forced, (0.6, 0.5), (0.3, 0.2)),
    "Mathieu": (traps.mathieu, (1.5, 0.3), (1.0, 0.1)),
    "predators": (traps.predators, (1.2,), (1.4, 0.7)),
}
LEAST = (
    0.01  # times the tolerance: less is more work than was asked for, if a longer step saves some
)
CONTROLS = ("control-momentum-n4", "control-physical-n4")  # whose motions are not regular
METHODS = {
    "gauss-4": 1e-8,
    "dop853": 1e-8,
    "rk-4": 1e-6,
    "cf-4": 1e-6,
    "rkmk-dop853": 1e-8,
    "verlet-6": 1e-7,
    "rattle-4": 1e-5,
    "gauss-2-suzuki-6": 1e-7,
    "dormand-prince-5-adaptive": 1e-7,
    "dop853-adaptive": 1e-8,
}
STAGES = (5, 6, 7, 8)
STEPS = np.geomspace(0.15, 3.0, 16)  # in units of the default step of gauss-8
REPEATS = 7


def ends_of(problem: gi.Problem, end: float) -> dict[str, Any]:
    """Return the arguments of `solve` that end a run in the problem's own time."""
    return {"tau_end": end, "clock": False} if problem.time == "tau" else {"t_end": end}


def regular(problem: gi.Problem, y0: np.ndarray, end: float) -> tuple[bool, np.ndarray]:
    """Tell whether a motion is regular, and return the sizes of its pieces."""
    times = np.arange(1, 17) / 16.0 * end
    name = "tau_eval" if problem.time == "tau" else "t_eval"
    off = 1e-9 * np.random.default_rng(1).choice([-1.0, 1.0], problem.rows)
    given = {**ends_of(problem, end), name: times, "progress": False, "tolerance": 1e-11}
    one, other = (gi.solve(problem, y, **given).y for y in (y0, y0 * (1.0 + off)))
    apart = np.abs(one - other).max(axis=1)
    return bool(apart[-1] < 400.0 * apart[0]), sizes_of(problem, np.vstack((y0, one)))


def extended(problem: gi.Problem, y0: Any, end: float) -> np.ndarray:
    """Return the state at the end by 12 stages in double-double arithmetic."""
    step = 0.5 * gi.Gauss(8).default_step(problem, y0, end)
    for h in (step, 0.5 * step, 0.25 * step):
        try:
            found = integrate_extended(problem, y0, end, h)
            break
        except gi.ConvergenceError:
            continue
    return np.asarray(found[: problem.rows].astype(np.float64))


def least_seconds(calls: list[Callable[[], Any]], repeats: int = REPEATS) -> list[float]:
    """Return the least time of each call, all of them in turn."""
    found = [float("inf")] * len(calls)
    for _ in range(repeats):
        for i, call in enumerate(calls):
            begun = time.perf_counter()
            call()
            found[i] = min(found[i], time.perf_counter() - begun)
    return found


def with_search(
    problem: gi.Problem, y0: Any, end: float, tolerance: float, error: Callable[[Any], float]
) -> dict[str, Any]:
    """Return the error of an automatic run, and its times against the best setting found."""
    given = {**ends_of(problem, end), "progress": False}
    sol = gi.solve(problem, y0, **given, method="auto", tolerance=tolerance)
    step = gi.Gauss(8).default_step(problem, problem.canonical(y0), end)
    fastest: list[tuple[float, int, float]] = []
    for stages in STAGES:
        for h in STEPS * step:
            try:
                run = gi.solve(problem, y0, **given, method=gi.Gauss(stages), step=min(h, end))
            except gi.StepError:
                continue
            if error(run.y[-1]) <= tolerance:
                fastest.append((run.iterations, stages, h))
    fastest.sort()

    def at(method: Any, h: float) -> Callable[[], Any]:
        return lambda: gi.solve(problem, y0, **given, method=method, step=min(h, end))

    calls = [at(gi.Gauss(stages), h) for _, stages, h in fastest[:4]]
    calls.append(at(sol.method, abs(sol.step)))
    calls.append(lambda: gi.solve(problem, y0, **given, method="auto", tolerance=tolerance))
    *searched, chosen, whole = least_seconds(calls)
    best = min(searched, default=float("nan"))
    return {
        "tolerance": tolerance,
        "method": sol.method.name,
        "error_over_tolerance": float(f"{error(sol.y[-1]) / tolerance:.3g}"),
        "free": error(sol.y[-1]) < LEAST * tolerance and saves_nothing(problem, y0, end, sol),
        "run_over_best": float(f"{chosen / best:.3g}"),
        "call_over_best": float(f"{whole / best:.3g}"),
        "best_milliseconds": float(f"{1e3 * best:.3g}"),
    }


def of_scene(name: str, seed: int, end: float, methods: bool) -> tuple[list[Any], list[Any]]:
    """Return the rows of both parts from a random state; none if its motion is not regular."""
    problem = gi.load_scene(name).problem
    y0 = problem.canonical(problem.random_state(seed))
    is_regular, sizes = regular(problem, y0, end)
    if not is_regular:
        return [], []
    truth = extended(problem, y0, end)

    def error(y: np.ndarray) -> float:
        return float(np.max(np.abs(y - truth) / sizes))

    about = {"scene": name, "seed": seed}
    rows = [{**about, **with_search(problem, y0, end, tol, error)} for tol in TOLERANCES]
    others = []
    for method, tol in METHODS.items() if methods else ():
        if gi.find_method(method).needs in problem.forms:
            given = {**ends_of(problem, end), "progress": False}
            sol = gi.solve(problem, y0, **given, method=method, tolerance=tol)
            ratio = float(f"{error(sol.y[-1]) / tol:.3g}")
            others.append(
                {**about, "method": method, "tolerance": tol, "error_over_tolerance": ratio}
            )
    return rows, others


def saves_nothing(problem: gi.Problem, y0: Any, end: float, sol: gi.Solution) -> bool:
    """Tell whether longer steps take as many iterations: a smaller error costs nothing then."""
    given = {**ends_of(problem, end), "progress": False, "method": sol.method}
    work = []
    for longer in (1.1, 1.2, 1.3):
        try:
            work.append(gi.solve(problem, y0, **given, step=longer * sol.step).iterations)
        except gi.StepError:
            continue
    return min(work, default=np.inf) > 0.97 * sol.iterations


def of_own(name: str, seed: int, end: float) -> list[dict[str, Any]]:
    """Return the rows of a system that a user writes; none if the motion is not regular."""
    field, params, near = OWN[name]
    problem, rows = traps.problem_of(field, len(near), params), []
    y0 = np.array(near) * (1.0 + 0.2 * np.random.default_rng(seed).uniform(-1.0, 1.0, len(near)))
    is_regular, sizes = regular(problem, y0, end)
    truth = extended(problem, y0, end)
    for tol in TOLERANCES if is_regular else ():
        sol = gi.solve(problem, y0, t_end=end, method="auto", tolerance=tol, progress=False)
        ratio = float(f"{np.max(np.abs(sol.y[-1] - truth) / sizes) / tol:.3g}")
        about = {"system": name, "seed": seed, "method": sol.method.name, "tolerance": tol}
        free = ratio < LEAST and saves_nothing(problem, y0, end, sol)
        rows.append({**about, "error_over_tolerance": ratio, "free": free})
    return rows


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return how errors and times are distributed."""
    ratios = np.array([row["error_over_tolerance"] for row in rows])
    found: dict[str, Any] = {
        "runs": len(rows),
        "within 0.01 … 10": round(float(np.mean((ratios >= 0.01) & (ratios <= 10.0))), 3),
        "within 0.03 … 3": round(float(np.mean((ratios >= 0.03) & (ratios <= 3.0))), 3),
        "median": float(f"{np.median(ratios):.3g}"),
        "least": float(ratios.min()),
        "largest": float(ratios.max()),
    }
    for key in ("run_over_best", "call_over_best"):
        if key in rows[0]:
            found[key] = float(f"{np.nanmedian([row[key] for row in rows]):.3g}")
    return found


def picture(rows: list[Any], others: list[Any], path: Path) -> None:
    """Draw errors against tolerances."""
    with new_figure(1.6 * WIDTH, 0.68 * WIDTH, layout="constrained") as figure:
        left, right = figure.subplots(1, 2)
        rng = np.random.default_rng(0)
        pairs = np.array([[r["tolerance"], r["error_over_tolerance"]] for r in rows])
        spread = 10.0 ** rng.uniform(-0.15, 0.15, len(pairs))
        errors = np.maximum(pairs[:, 0] * pairs[:, 1], 1e-16)
        left.loglog(
            pairs[:, 0] * spread, errors, "o", ms=3, mfc="none", color=COLOURS[0], alpha=0.6
        )
        limits = np.array([1e-11, 1e-5])
        left.loglog(limits, limits, color="0.4", lw=0.8)
        left.fill_between(limits, limits / 100, limits * 10, color="0.93", label="0.01 … 10")
        left.fill_between(limits, limits * 0.03, limits * 3, color="0.86", label="0.03 … 3")
        left.set(xlabel="tolerance", ylabel="error at the end", xlim=limits)
        left.set_title(f"auto, {len(rows)} runs")
        left.legend(frameon=False, loc="upper left")
        names = list(METHODS)
        for i, name in enumerate(names):
            ratios = [r["error_over_tolerance"] for r in others if r["method"] == name]
            height = i + rng.uniform(-0.2, 0.2, len(ratios))
            shown = np.maximum(ratios, 1e-4)
            right.semilogx(shown, height, "o", ms=3, mfc="none", color=COLOURS[1], alpha=0.7)
        right.axvspan(0.01, 10, color="0.93")
        right.axvspan(0.03, 3, color="0.86")
        right.axvline(1.0, color="0.4", lw=0.8)
        right.set_yticks(range(len(names)), [f"{n}, {METHODS[n]:.0e}" for n in names])
        right.set(xlabel="error / tolerance", title=f"methods, {len(others)} runs")
        figure.savefig(path, dpi=130)


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--states", type=int, default=8)
    parser.add_argument("--end", type=float, default=300.0)
    parser.add_argument("--scenes", nargs="+", default=sorted(builtin_scenes()))
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    images = Path(__file__).parents[1] / "docs" / "images"
    parser.add_argument("--images", type=Path, default=images)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", gi.GeomintWarning)
    rows: list[dict[str, Any]] = []
    others: list[dict[str, Any]] = []
    left_out = []
    for name in arguments.scenes:
        for seed in range(1, arguments.states + 1) if name not in CONTROLS else ():
            found, more = of_scene(name, seed, arguments.end, methods=seed <= 2)
            rows, others = rows + found, others + more
            if not found:
                left_out.append([name, seed])
            print(f"{name:20} {seed}", [r["error_over_tolerance"] for r in found],
                  [r["call_over_best"] for r in found], flush=True)  # fmt: skip
    own = [
        row
        for name in OWN
        for seed in range(arguments.states)
        for row in of_own(name, seed, arguments.end)
    ]
    by_tolerance = {
        f"{tol:g}": summary([r for r in rows if r["tolerance"] == tol]) for tol in TOLERANCES
    }
    by_method = {
        name: summary(some)
        for name in METHODS
        if (some := [r for r in others if r["method"] == name])
    }
    result = {
        "end": arguments.end,
        "auto": {"all": summary(rows), **by_tolerance},
        "methods": by_method,
        "own": summary(own),
        "not regular": left_out,
        "rows": rows,
        "rows of methods": others,
        "rows of own systems": own,
        "machine": describe(["geomint", "numba", "numpy"]),
    }
    for key in ("auto", "methods", "own", "not regular"):
        print(key, json.dumps(result[key], indent=1, ensure_ascii=False))
    path = arguments.out / "tolerance.json"
    path.write_text(json.dumps(result, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    picture(rows, others, arguments.images / "tolerance.png")


if __name__ == "__main__":
    main()
