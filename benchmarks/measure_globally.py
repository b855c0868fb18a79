"""The invariant measure, globally: draws from a density, pushed forward, against other draws.

Samples are compared by the energy distance of (γ₁², γ₂², γ₃²), with a p-value by permutations
(G. J. Székely, M. L. Rizzo, J. Stat. Plann. Inference 143 (2013) 1249): small where what was pushed
forward is told from the measure. Of the reduced sphere, at a temperature of 0.2, after 10³ to 10⁵
steps of 0.1: `gauss-8` from the density of the measure, `gauss-8` from the uniform density, which the
flow does not keep, and `heun-2`, which heats. Writes ``results/measure_globally.json`` and the picture
``docs/images/measure-globally.png``.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import chaplygin as ch
import geomint as gi
from geomint.plots.canvas import new_figure
from geomint.plots.style import COLOURS, MARKERS, WIDTH
from machine import describe

REDUCED = ch.ChaplyginSphere(a=[0.1, 1.0, 2.9], D=3.0).reduced()
UNIFORM = dataclasses.replace(
    REDUCED,
    measure=gi.Measure(manifold=REDUCED.measure.manifold, conditions=REDUCED.measure.conditions),
)
CASES = {
    "gauss-8": (REDUCED, "gauss-8"),
    "gauss-8, uniform density": (UNIFORM, "gauss-8"),
    "heun-2": (REDUCED, "heun-2"),
}
COUNT, PERMUTATIONS, STEP = 1000, 99, 0.1
PUSHES = (1_000, 10_000, 100_000)
ROOT = Path(__file__).parents[1]


def chance(one: np.ndarray, other: np.ndarray, permutations: int) -> float:
    """Return the part of permutations of both samples that are as far apart as these."""
    joined = np.concatenate([one[:, :3] ** 2, other[:, :3] ** 2])
    apart = np.sqrt(((joined[:, None] - joined[None]) ** 2).sum(axis=-1))
    n, m, total = len(one), len(other), apart.sum()

    def distance(first: np.ndarray) -> float:
        s = np.zeros(n + m)
        s[first] = 1.0
        along = apart @ s
        within, across = s @ along, (1.0 - s) @ along
        rest = total - within - 2.0 * across
        return float(2.0 * across / (n * m) - within / n**2 - rest / m**2)

    rng = np.random.default_rng(0)
    found = distance(np.arange(n))
    larger = sum(distance(rng.permutation(n + m)[:n]) >= found for _ in range(permutations))
    return (1 + larger) / (1 + permutations)


def chances(
    case: str, seed: int, pushes: Sequence[int], permutations: int = PERMUTATIONS
) -> list[float]:
    """Return p-values after so many steps, of draws by a case's density against others by it."""
    problem, method = CASES[case]
    states, others = (
        gi.draw_states(problem, COUNT, temperature=0.2, seed=s) for s in (seed, 1000 + seed)
    )
    found = []
    for steps in pushes:
        many = gi.solve_ensemble(REDUCED, states, t_end=STEP * steps, method=method, step=STEP)
        sound = np.isfinite(many.final).all(axis=1) & (np.abs(many.final) < 1e6).all(axis=1)
        enough = sound.sum() > 1
        least = 1 / (1 + permutations)
        found.append(chance(many.final[sound], others, permutations) if enough else least)
    return found


def picture(record: dict[str, Any], path: Path) -> None:
    """Draw p-values over steps, a mark a seed."""
    with new_figure(0.62 * WIDTH, 0.42 * WIDTH, layout="constrained") as figure:
        axes = figure.subplots()
        for k, (case, rows) in enumerate(record["chances"].items()):
            for i, row in enumerate(rows):
                at = np.array(record["pushes"]) * 1.12 ** (k - 1)  # beside each other
                look = {"color": COLOURS[k], "marker": MARKERS[k], "ms": 4, "mfc": "none"}
                axes.loglog(at, row, ls="", label=case if i == 0 else None, **look)
        axes.axhline(0.05, color="0.5", lw=0.8, ls="--")
        axes.annotate("5 %", (record["pushes"][0] / 1.3, 0.052), va="bottom", color="0.4")
        axes.set_xlabel("steps")
        axes.set_ylabel("p-value of the energy distance")
        axes.set_ylim(0.007, 1.3)
        axes.legend(fontsize="small")
        figure.savefig(path, dpi=200)


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=2, help="from 10 on: the tests have 0 to 2")
    parser.add_argument("--out", type=Path, default=ROOT / "benchmarks" / "results")
    parser.add_argument("--images", type=Path, default=ROOT / "docs" / "images")
    arguments = parser.parse_args()
    found: dict[str, list[list[float]]] = {}
    for case in CASES:
        for seed in range(10, 10 + arguments.seeds):
            found.setdefault(case, []).append(chances(case, seed, PUSHES))
            print(case, seed, found[case][-1], flush=True)
    record = {
        "pushes": PUSHES,
        "draws": COUNT,
        "permutations": PERMUTATIONS,
        "chances": found,
        "machine": describe(["geomint", "numba", "numpy"]),
    }
    (arguments.out / "measure_globally.json").write_text(json.dumps(record, indent=1), "utf-8")
    picture(record, arguments.images / "measure-globally.png")


if __name__ == "__main__":
    main()
