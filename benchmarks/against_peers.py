"""What users meet: whole calls of geomint and heyoka, from random states, at the error that is wanted.

    python benchmarks/against_peers.py [--states 32] [--rows ball,sphere] [--repeats 5] [--busy]

geomint gets the error that is wanted as its ``tolerance``, and ``method="auto"``: the time is that of
the whole call of `geomint.solve` on the clock on the wall, the choosing of method and step included;
with ``--busy``, on a machine that does other things too, that of the processor.
Where that call misses the error, smaller tolerances follow, and the time is that of the first one that
meets it. heyoka gets, for each state and error, the fastest of its tolerances and formulations that
meets it: an integrator made once is given the state and goes to the end. The field is written by hand
in the best way known, and traced from geomint's source (`geomint.compare.peers`). Compilation is apart.

The truth is a Gauss method of 12 stages in double-double arithmetic, or the exact flow where there is
one; states from which heyoka at its tightest does not meet an error are left out. Errors are those of
the final state, of each piece relative to its largest number at the beginning or the end. The codes
take turns; medians of the repeats; over the states the geometric mean of heyoka's time over geomint's,
and the least. Beside it that over the steps alone: an integrator made once, with the method and the
step that were chosen; and what heyoka takes with the traced field over what it takes with the fastest
one, by single runs.
Seeds are 0, 1, ….
"""

from __future__ import annotations

import argparse
import json
import statistics
import time
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

import chaplygin as ch
import geomint as gi
import heyoka_fields as fields
from geomint.compare.peers.heyoka_peer import taylor
from geomint.compare.peers.peer import PeerError
from geomint.compare.reference import integrate_extended
from geomint.problems.testproblems import henon_heiles
from hamiltonized_n3 import A, D
from henon_heiles_states import states as henon_heiles_states
from machine import describe
from tests.problems import outer_solar_system, schwarzschild

GOALS = (1e-6, 1e-9, 1e-10)
SMALLER = (1.0, 0.25, 0.0625)  # tolerances of geomint, of the goal
FINE = (*(10.0**-k for k in range(6, 15)), 3e-10, 3e-11, 3e-12, 3e-13)
COARSE = (1e-7, 1e-9, 1e-10, 1e-11, 1e-12)  # where a tolerance compiles for seconds
MOMENTS, BALL_D = (1.0, 2.0, 3.0), 1.0
LARGE_D = 4.0

Runner = Callable[[np.ndarray], np.ndarray]


@dataclass
class Row:
    """A problem, its end, and what heyoka integrates.

    Attributes
    ----------
    systems : callable
        Formulations of the field by name.
    state : callable
        ``state(seed)``.
    finest : float
        The longest step of the truth: of motions that are faster on their way.
    floor : float
        What the geometric mean of the ratios shall not be below.
    """

    name: str
    problem: gi.Problem
    end: float
    systems: Callable[[], dict[str, fields.System]]
    floor: float
    tolerances: tuple[float, ...] = FINE
    compact: bool = False
    state: Callable[[int], np.ndarray] | None = None
    finest: float = np.inf
    integrator: tuple[Any, Any] = (None, None)

    @property
    def key(self) -> str:
        """The name of the row, with its end."""
        return f"{self.name}, {self.end:g}"

    def start(self, seed: int) -> np.ndarray:
        """Return the initial state of a seed."""
        return self.problem.random_state(seed) if self.state is None else self.state(seed)

    def ours(self, y0: np.ndarray, tolerance: float) -> gi.Solution:
        """Return geomint's run with a tolerance."""
        end: dict[str, Any] = {"t_end": self.end}
        if self.problem.time == "tau":
            end = {"tau_end": self.end, "clock": False}
        return gi.solve(self.problem, y0, **end, method="auto", tolerance=tolerance, progress=False)

    def steps(self, y0: np.ndarray, solution: gi.Solution) -> None:
        """Run with the method and the step that were chosen, by an integrator that is there."""
        if self.integrator[0] is not solution:
            made = gi.Integrator(self.problem, y0, solution.method, step=solution.step)
            self.integrator = solution, made
        motion = self.integrator[1]
        motion.reset(y0)
        motion.propagate_until(self.end)

    @cached_property
    def theirs(self) -> dict[str, Runner]:
        """Integrators of heyoka, by formulation and tolerance; compiled when first asked for."""
        found = {}
        for form, system in self.systems().items():
            for tolerance in self.tolerances:
                _, run = taylor(system, tolerance, self.compact)
                found[f"{form}, {tolerance:.0e}"] = partial(_last, run, self.end)
        return found

    def truth(self, y0: np.ndarray) -> np.ndarray:
        """Return the state at the end."""
        if self.problem.make_exact is not None and self.end >= 2500.0:
            motion = self.problem.exact(y0)
            at = motion.at_tau if self.problem.time == "tau" else motion
            return np.asarray(at(self.end))
        h = min(self.finest, 0.5 * gi.Gauss(8).default_step(self.problem, y0, self.end))
        return np.asarray(integrate_extended(self.problem, y0, self.end, h), dtype=float)[: len(y0)]

    def error(self, y0: np.ndarray, y: np.ndarray, truth: np.ndarray) -> float:
        """Return the largest deviation, relative to the size of its piece."""
        sizes = np.empty(len(y0))
        for rows in self.problem.slices.values():
            sizes[rows] = max(np.abs(y0[rows]).max(), np.abs(truth[rows]).max())
        return float(np.max(np.abs(y - truth) / sizes))


def _last(run: Callable[[np.ndarray, float], Any], end: float, y0: np.ndarray) -> np.ndarray:
    return np.asarray(run(y0, end).y)


def rows() -> list[Row]:
    """Return the rows of the table."""

    def by_hand(problem: gi.Problem, **written: Any) -> Callable[[], dict[str, fields.System]]:
        return lambda: {
            **{name: make() for name, make in written.items()},
            "traced": fields.traced(problem),
        }

    found = []
    problem = ch.ChaplyginSphere(a=A, D=D).hamiltonized()
    forms = {form: partial(fields.sphere, form, A, D) for form in fields.SPHERE_FORMS}
    for end, floor in ((250.0, 1.3), (2500.0, 2.2)):
        found.append(Row("sphere, n = 3", problem, end, by_hand(problem, **forms), floor))
    problem = ch.ChaplyginSphere.from_moments(MOMENTS, BALL_D, 1.0).classical()
    forms = {"by hand": partial(fields.ball, MOMENTS, BALL_D)}
    for end, floor in ((100.0, 0.8), (1000.0, 1.7), (1e4, 2.2)):
        found.append(Row("ball in R³", problem, end, by_hand(problem, **forms), floor))
    for n, floor, compact in ((10, 2.0, False), (100, 6.0, True)):
        a = np.linspace(0.7, 1.5, n)
        problem = ch.ChaplyginSphere(a=a, D=LARGE_D).hamiltonized()
        forms = {form: partial(fields.sphere, form, a, LARGE_D) for form in ("homogeneous",)}
        systems = by_hand(problem, **forms)
        found.append(Row(f"sphere, n = {n}", problem, 20.0, systems, floor, COARSE, compact))
    for n, floor, compact in ((8, 4.0, False), (16, 9.0, True)):
        problem = ch.ChaplyginSphere(a=np.linspace(0.7, 1.5, n), D=LARGE_D).ball()
        tolerances = COARSE if compact else COARSE[:-1]
        found.append(
            Row(f"ball, so({n})", problem, 20.0, by_hand(problem), floor, tolerances, compact)
        )
    problem = henon_heiles.problem()
    states = henon_heiles_states(1.0 / 12.0, 64, 0)
    found.append(
        Row("Hénon–Heiles", problem, 1000.0, by_hand(problem), 1.0, state=states.__getitem__)
    )
    problem = outer_solar_system.problem()
    written = partial(fields.n_body, outer_solar_system.CONSTANT, outer_solar_system.MASSES)
    found.append(
        Row(
            "outer Solar System",
            problem,
            200_000.0,
            lambda: {"heyoka's model": written()},
            1.0,
            (*COARSE, 1e-13, 1e-14, 1e-15),
            state=solar_system_state,
        )
    )
    problem = schwarzschild.problem()
    found.append(
        Row(
            "Schwarzschild",
            problem,
            100_000.0,
            by_hand(problem),
            1.0,
            state=partial(hole_state, problem),
            finest=5.0,
        )
    )
    return found


def solar_system_state(seed: int) -> np.ndarray:
    """Return the outer Solar System with velocities off by 2 %."""
    y = outer_solar_system.initial()
    y[21:] *= 1.0 + 0.02 * np.random.default_rng(seed).normal(size=15)
    return y


def hole_state(problem: gi.Problem, seed: int) -> np.ndarray:
    """Return a particle between 10 and 30 GM/c² from the black hole."""
    return schwarzschild.initial(problem, np.random.default_rng(seed).uniform(10.0, 30.0))


def compared(row: Row, seed: int, repeats: int, clock: Callable[[], float]) -> list[dict[str, Any]]:
    """Return for each goal what both codes take from one state, and their errors."""

    def seconds_of(run: Callable[[], Any]) -> float:
        begun = clock()
        run()
        return clock() - begun

    y0 = row.start(seed)
    truth = row.truth(y0)
    settings = {}
    for name, run in row.theirs.items():
        try:
            error = row.error(y0, run(y0), truth)
        except PeerError:  # on-sphere forms leave the sphere
            continue
        settings[name] = (seconds_of(partial(run, y0)), error)
    tightest = min(error for _, error in settings.values())
    found = []
    for goal in GOALS:
        if tightest >= GOALS[0]:
            raise SystemExit(f"{row.key}, seed {seed}: heyoka is off by {tightest:.1e}")
        if tightest >= goal:  # by its roundings
            print(
                f"  seed {seed} is left out: heyoka is off by {tightest:.1e} at least", flush=True
            )
            continue
        good = {name: seconds for name, (seconds, error) in settings.items() if error < goal}
        best = sorted(good, key=lambda name: good[name])[:2]
        for part in SMALLER:
            solution = row.ours(y0, part * goal)
            error = row.error(y0, solution.y[-1], truth)
            if error < goal:
                break
        runs: dict[str, Callable[[], Any]] = {name: partial(row.theirs[name], y0) for name in best}
        runs["geomint"] = partial(row.ours, y0, part * goal)
        runs["steps alone"] = partial(row.steps, y0, solution)
        seconds: dict[str, list[float]] = {name: [] for name in runs}
        row.steps(y0, solution)
        for _ in range(repeats):
            for name, call in runs.items():
                seconds[name].append(seconds_of(call))
        medians = {name: statistics.median(times) for name, times in seconds.items()}
        fastest = min(best, key=lambda name: medians[name])
        found.append(
            {
                "seed": seed,
                "goal": goal,
                "geomint": {
                    "seconds": medians["geomint"],
                    "steps_alone": medians["steps alone"],
                    "error": error,
                    "tolerance": part * goal,
                    "method": solution.method.name,
                },
                "heyoka": {
                    "seconds": medians[fastest],
                    "error": settings[fastest][1],
                    "setting": fastest,
                },
                "traced": min((t for n, t in good.items() if n.startswith("traced")), default=0.0),
                "fastest": min(good.values()),
                "ratio": medians[fastest] / medians["geomint"],
            }
        )
    return found


def summary(row: Row, goal: float, states: list[dict[str, Any]], count: int) -> dict[str, Any]:
    """Return what the states of a row, of so many, say about a goal."""
    ratios = [state["ratio"] for state in states]
    alone = [s["heyoka"]["seconds"] / s["geomint"]["steps_alone"] for s in states]
    traced = [s["traced"] / s["fastest"] for s in states if s["traced"] > 0.0]
    return {
        "problem": row.name,
        "end": row.end,
        "goal": goal,
        "floor": row.floor,
        "geometric_mean": statistics.geometric_mean(ratios),
        "least": min(ratios),
        "largest": max(ratios),
        "steps_alone_mean": statistics.geometric_mean(alone),
        "traced_over_fastest": statistics.geometric_mean(traced or [1.0]),
        "geomint_ms": 1e3 * statistics.median(s["geomint"]["seconds"] for s in states),
        "heyoka_ms": 1e3 * statistics.median(s["heyoka"]["seconds"] for s in states),
        "missed": sum(s["geomint"]["tolerance"] < goal for s in states),
        "not_met": sum(s["geomint"]["error"] >= goal for s in states),
        "left_out": count - len(states),
        "states": states,
    }


def run(
    chosen: Iterable[Row], states: int, repeats: int, clock: Callable[[], float]
) -> list[dict[str, Any]]:
    """Return the table, row after row."""
    table = []
    for row in chosen:
        begun = time.perf_counter()
        row.ours(row.start(0), GOALS[0])
        count = len(row.theirs)
        made = time.perf_counter() - begun
        print(f"{row.key}: {count} settings compiled in {made:.0f} s", flush=True)
        found = [entry for seed in range(states) for entry in compared(row, seed, repeats, clock)]
        for goal in GOALS:
            table.append(summary(row, goal, [e for e in found if e["goal"] == goal], states))
            told = {k: v for k, v in table[-1].items() if k not in ("states", "problem", "end")}
            print("  ", {k: round(v, 3) if v > 1e-3 else v for k, v in told.items()}, flush=True)
        print(f"  {time.perf_counter() - begun:.0f} s", flush=True)
        del row.theirs
    return table


def picture(table: list[dict[str, Any]], path: Path) -> None:
    """Draw the ratios: geometric means, least to largest, and the floors."""
    import matplotlib.pyplot as plt

    names = list(dict.fromkeys((r["problem"], r["end"]) for r in table))
    figure, axes = plt.subplots(figsize=(6.5, 0.42 * len(names) + 1.1), layout="constrained")
    colours = {1e-6: "#0072B2", 1e-9: "#D55E00", 1e-10: "#009E73"}
    markers = {1e-6: "o", 1e-9: "s", 1e-10: "^"}
    for r in table:
        at = names.index((r["problem"], r["end"])) + 0.22 * (GOALS.index(r["goal"]) - 1)
        colour = colours[r["goal"]]
        axes.plot([r["least"], r["largest"]], [at, at], color=colour, lw=1.2, alpha=0.6)
        axes.plot(r["geometric_mean"], at, markers[r["goal"]], color=colour, ms=5)
    for i, name in enumerate(names):
        floor = next(r["floor"] for r in table if (r["problem"], r["end"]) == name)
        axes.plot([floor, floor], [i - 0.4, i + 0.4], color="0.35", lw=1.0, ls=(0, (2, 1.5)))
    for goal in GOALS:
        axes.plot([], [], markers[goal], color=colours[goal], label=f"error {goal:g}")
    axes.plot([], [], color="0.35", lw=1.0, ls=(0, (2, 1.5)), label="floor")
    axes.axvline(1.0, color="0.6", lw=0.8, zorder=0)
    axes.set_xscale("log")
    axes.set_yticks(range(len(names)), [f"{name}, T = {end:g}" for name, end in names])
    axes.invert_yaxis()
    axes.set_xlabel("time of heyoka / time of geomint, whole calls")
    axes.xaxis.set_major_formatter("{x:g}")
    axes.grid(axis="x", color="0.9")
    figure.legend(loc="outside upper center", ncols=4, frameon=False, fontsize=8)
    for suffix in (".png", ".svg"):
        figure.savefig(path.with_suffix(suffix), dpi=160)


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--states", type=int, default=32)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--busy", action="store_true", help="Processor time, not that on the wall.")
    parser.add_argument("--rows", help="Only rows whose names have one of these texts in them.")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", gi.GeomintWarning)
    wanted = [""] if arguments.rows is None else arguments.rows.split(",")
    chosen = [row for row in rows() if any(text in row.key for text in wanted)]
    clock = time.process_time if arguments.busy else time.perf_counter
    table = run(chosen, arguments.states, arguments.repeats, clock)
    result = {
        "benchmark": "against-peers",
        "rows": table,
        "states": arguments.states,
        "repeats": arguments.repeats,
        "clock": "processor" if arguments.busy else "wall",
        "machine": describe(["geomint", "heyoka", "numba", "numpy"]),
    }
    arguments.out.mkdir(parents=True, exist_ok=True)
    path = arguments.out / "against_peers.json"
    path.write_text(json.dumps(result, ensure_ascii=False) + "\n", encoding="utf-8")
    picture(table, path)
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
