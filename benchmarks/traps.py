"""How often a run is silently wrong: motions that mislead a step chosen from one look at the start.

    python benchmarks/traps.py --seeds 21 22 23 [--count 3024] [--family NAME …] [--workers 2]
    python benchmarks/traps.py --seeds 21 --only 1234     # one motion again, with what it was told

Every motion is drawn by seed and number from a family of `trap_families.py`, with what is asked of it:
nothing (promise: 1e-9 at the end), a method (what a step may err by, `docs/how-accurate.md`), or a
tolerance, by ``"auto"`` or a method. The truth is SciPy's DOP853 at 2.3e-14, begun anew where a force
jumps, and how well it is known its difference from the same at 1e-12.

A run is *wrong* if its error is more than 30 times the promise, and what the truth is not known to
besides; *silent* if it then gave no warning; *warned though right* if it warned and erred less than
three times the promise; *refused* if it raised a typed error. What cannot be told is *unknown*. Pulses
much shorter than a step (`narrow-pulse`) are reported apart. Writes
``results/traps.json`` and a picture.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
import warnings
from collections import Counter, defaultdict
from collections.abc import Iterator
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

import geomint as gi
from geomint.plots.canvas import new_figure
from geomint.plots.style import COLOURS, WIDTH
from geomint.problems.evaluate import rates_of
from machine import describe
from trap_families import FAMILIES, Motion

WRONG, RIGHT = 30.0, 3.0  # times the promise
APART = ("narrow-pulse",)
PROMISED = ((7, 1e-9), (4, 1e-7), (2, 1e-3), (1, 1e-2))
NAMED = ("gauss-8", "gauss-6", "gauss-4", "rk-4", "dop853", "heun-2", "dormand-prince-5")
LOOSEST, TIGHTEST = -3.0, {"rk-4": -7.0, "gauss-4": -7.0, "dormand-prince-5": -8.0}
OF_FORMS = {"action": ("cf-4", "rkmk-4"), "hamiltonian": ("rattle-4",), "splitting": ("verlet-4",)}
DEAREST = 200_000  # evaluations of a rate for the truth
LOOKS = 16  # steps whose error is looked at, spread evenly, and where the motion changes most


class Found(NamedTuple):
    """What became of a motion: error over promise, and how well the truth is known, in promises."""

    number: int
    family: str
    asked: str
    outcome: str
    ratio: float = 0.0
    unknown: float = 0.0
    told: str = ""


def ask(rng: np.random.Generator, problem: gi.Problem) -> dict[str, Any]:
    """Return what is asked of `solve`."""
    fitting = [*NAMED, *(m for form in problem.forms for m in OF_FORMS.get(form, ()))]
    kind, method = rng.uniform(), str(rng.choice(fitting))
    if kind < 0.3:
        return {}
    if kind < 0.55:
        return {"method": method}
    if kind < 0.8 or method == "heun-2":
        return {"method": "auto", "tolerance": float(10.0 ** rng.uniform(-10.5, LOOSEST))}
    method = "dop853-adaptive" if method == "gauss-6" else method
    least = TIGHTEST.get(method, -6.0 if method in ("rattle-4", "verlet-4", "cf-4") else -10.0)
    return {"method": method, "tolerance": float(10.0 ** rng.uniform(least, LOOSEST))}


def flow(motion: Motion, y0: np.ndarray, t0: float, t1: float, rtol: float = 2.3e-14) -> np.ndarray:
    """Return the states of SciPy's steps from t0 to t1, one a row."""
    problem, rate = motion.problem, rates_of(motion.problem, y0)
    low, high = min(t0, t1), max(t0, t1)
    ends = sorted([*(b for b in motion.breaks if low < b < high), t1], reverse=bool(t1 < t0))
    states, sizes = [y0], sizes_of(problem, y0[None])
    if problem.space is not None:  # whose conditions are kept to roundings of all numbers
        sizes[:] = 30.0 * sizes.max()
    asked = itertools.count()

    def asked_rate(t: float, y: np.ndarray, a: float, b: float) -> np.ndarray:
        if next(asked) > DEAREST:
            raise RuntimeError("the truth takes too long")
        return rate(problem, y, float(np.clip(t, min(a, b), max(a, b)))).copy()

    for begin, end in zip([t0, *ends], ends, strict=False):
        if begin != end:  # no rate beyond the jump at the end is asked for
            inside = np.sign(end - begin) * np.spacing(max(abs(begin), abs(end)))
            found = solve_ivp(
                lambda t, y, a=begin + inside, b=end - inside: asked_rate(t, y, a, b),
                (begin, end),
                states[-1],
                method="DOP853",
                rtol=rtol,
                atol=0.01 * rtol * sizes + 1e-30,
            )
            if found.status != 0:
                raise RuntimeError(found.message)
            states += list(found.y.T[1:])
    return np.array(states)


def off(problem: gi.Problem, a: np.ndarray, b: np.ndarray, sizes: np.ndarray) -> float:
    """Return the largest difference of two states relative to the sizes of their pieces."""
    return float(np.max(np.abs(a - b) / sizes))


def sizes_of(problem: gi.Problem, states: np.ndarray) -> np.ndarray:
    """Return for each number the largest that its piece has been."""
    sizes = np.abs(states).max(axis=0)
    for rows in problem.slices.values():
        sizes[rows] = sizes[rows].max() or sizes.max() or 1.0
    return sizes


def step_errors(motion: Motion, sol: gi.Solution, sizes: np.ndarray) -> float:
    """Return the largest error of those steps of a run that are looked at."""
    y, t = sol.y, sol.t
    count = len(t) - 1
    bends = np.zeros(count)
    if count > 2:
        bends[1:] = np.max(np.abs(np.diff(y, 2, axis=0)) / sizes, axis=1)
    looks = {*np.linspace(0, count - 1, min(LOOKS, count)).astype(int), *np.argsort(bends)[-LOOKS:]}
    ends = {k: flow(motion, y[k], float(t[k]), float(t[k + 1]))[-1] for k in looks}
    return max(off(motion.problem, y[k + 1], end, sizes) for k, end in ends.items())


def judged(seed: int, number: int, only: tuple[str, ...]) -> Found:
    """Return what became of a motion."""
    family = only[number % len(only)]
    rng = np.random.default_rng([seed, number])
    motion = FAMILIES[family](rng)
    problem, given = motion.problem, ask(rng, motion.problem)
    y0 = problem.canonical(np.asarray(motion.y0, dtype=float))
    text = " ".join(f"{k}={v:.2g}" if k == "tolerance" else f"{v}" for k, v in given.items())
    text, end, t0 = text or "default", motion.t0 + motion.span, motion.t0
    local = "method" in given and "tolerance" not in given
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            saved = {"save_every": 1} if local else {}
            sol = gi.solve(problem, y0, t0=t0, t_end=end, progress=False, **saved, **given)
        except gi.GeomintError as error:
            return Found(number, family, text, "refused", told=f"{type(error).__name__}: {error}")
    told = [str(w.message) for w in told if issubclass(w.category, gi.GeomintWarning)]
    try:
        states = flow(motion, y0, t0, end)
        sizes = sizes_of(problem, states)
        if local:
            order = sol.method.order
            promise = sol.method.step_fraction * next(e for p, e in PROMISED if order >= p)
            error, doubt = step_errors(motion, sol, sizes) / promise, 1e-15 / promise
        else:
            promise = given.get("tolerance", 1e-9)
            error = off(problem, sol.y[-1], states[-1], sizes) / promise
            other = flow(motion, y0, t0, end, 1e-12)[-1]
            doubt = off(problem, other, states[-1], sizes) / promise
        if (
            problem.space is not None
        ):  # roundings of forces, in a piece that is small beside the others
            doubt += 3e-15 * sizes.max() / sizes.min() / promise
    except RuntimeError as failure:
        return Found(number, family, text, "unknown", told=str(failure))
    outcome = "right"
    if not error - 3.0 * doubt <= WRONG:
        outcome = "told" if told else "silent"
    elif error + 3.0 * doubt > WRONG:
        outcome = "unknown"
    elif told and error + 3.0 * doubt < RIGHT:
        outcome = "warned"
    return Found(number, family, text, outcome, error, doubt, " | ".join(told))


def many(seed: int, numbers: list[int], only: tuple[str, ...], workers: int) -> Iterator[Found]:
    """Yield what became of motions, as they are done."""
    with get_context("spawn").Pool(workers) as pool:
        tasks = [pool.apply_async(judged, (seed, number, only)) for number in numbers]
        for k, task in enumerate(tasks):
            yield task.get()
            if k % 20 == 19:
                print(f"\r{k + 1} of {len(tasks)}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)


def picture(found: list[Found], path: Path) -> None:
    """Draw error over promise of every motion, by family: what was told, and what was not."""
    rows = {name: k for k, name in enumerate(FAMILIES)}
    with new_figure(1.3 * WIDTH, 0.155 * len(rows) + 1.0, layout="constrained") as figure:
        axes = figure.subplots()
        for outcome, colour in (("right", 0), ("warned", 4), ("told", 2), ("silent", 3)):
            some = [f for f in found if f.outcome == outcome]
            x = np.clip([f.ratio for f in some], 1e-8, 1e10)
            y = [rows[f.family] + 0.6 * ((f.number * 0.618) % 1.0 - 0.5) for f in some]
            size = 2.5 if outcome == "right" else 5.0
            label = {"warned": "right, but warned", "told": "wrong, and told"}.get(outcome, outcome)
            axes.plot(x, y, ".", ms=size, color=COLOURS[colour], label=f"{label} ({len(some)})")
        axes.axvline(WRONG, color="0.4", lw=0.8)
        axes.set(xscale="log", xlabel="error over promise", ylim=(len(rows), -1))
        axes.set_yticks(list(rows.values()), [name.replace("-", " ") for name in rows])
        axes.tick_params(axis="y", labelsize=6)
        figure.legend(loc="outside upper center", ncols=4, fontsize=7)
        figure.savefig(path)


def shares(found: list[Found]) -> dict[str, Any]:
    """Return how many motions ended how, of all families but those apart."""
    some = [f for f in found if f.family not in APART]
    counts = Counter(f.outcome for f in some)
    part = {k: counts[k] / max(len(some), 1) for k in ("silent", "warned", "refused")}
    return {"motions": len(some), **dict(counts), "shares": part}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--count", type=int, default=3024)
    parser.add_argument("--family", nargs="+", default=list(FAMILIES))
    parser.add_argument("--only", type=int)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    images = Path(__file__).parents[1] / "docs" / "images"
    parser.add_argument("--images", type=Path, default=images)
    given = parser.parse_args()
    only = tuple(given.family)
    if given.only is not None:
        print(json.dumps(judged(given.seeds[0], given.only, only)._asdict(), indent=1))
        return 0
    every: list[Found] = []
    by_seed = {}
    for seed in given.seeds:
        found = list(many(seed, list(range(given.count)), only, given.workers))
        every += found
        by_seed[str(seed)] = shares(found)
        print(seed, by_seed[str(seed)])
        for one in found:
            if one.outcome in ("silent", "refused", "warned"):
                told = f"{one.ratio:.3g} {one.told[:150]}"
                print(one.outcome, one.number, one.family, one.asked, told)
    families: dict[str, Counter[str]] = defaultdict(Counter)
    for one in every:
        families[one.family][one.outcome] += 1
    for name, counts in families.items():
        print(f"{name:26}", *(f"{outcome} {n}" for outcome, n in counts.most_common()))
    print(shares(every))
    if only == tuple(FAMILIES):
        data = {
            "machine": describe(["geomint", "numpy", "scipy", "numba"]),
            "seeds": by_seed,
            "all": shares(every),
            "families": {k: dict(v) for k, v in families.items()},
            "silent": [f._asdict() for f in every if f.outcome == "silent"],
        }
        (given.out / "traps.json").write_text(json.dumps(data, indent=1) + "\n")
        picture(every, given.images / "traps.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
