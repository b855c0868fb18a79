"""A chart of the system of Hénon and Heiles at energy 1/8: digits of an average, motion by motion."""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import matplotlib as mpl
import numpy as np

import geomint as gi
from geomint.problems.testproblems import henon_heiles
from machine import describe

ENERGY, END, STEP = 1 / 8, 1000.0, 0.4


def starts(side: int) -> tuple[np.ndarray, np.ndarray]:
    """Return which points of a grid of (q, p) have the energy, and their states at x = 0."""
    q, p = np.meshgrid(np.linspace(-0.45, 0.68, side), np.linspace(-0.5, 0.5, side))
    rest = 2 * ENERGY - q**2 + 2 * q**3 / 3 - p**2
    inside = rest > 0
    return inside, np.array([0 * q[inside], q[inside], np.sqrt(rest[inside]), p[inside]]).T


def main() -> None:
    """Draw the chart and write how long it took."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=120)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    parser.add_argument(
        "--images", type=Path, default=Path(__file__).parents[1] / "docs" / "images"
    )
    arguments = parser.parse_args()
    problem = henon_heiles.problem()
    inside, states = starts(arguments.side)
    gi.solve_ensemble(problem, states[:9], t_end=END, step=STEP, save_every=1)  # compiles
    begun = time.perf_counter()
    digits = []
    for some in np.array_split(states, max(len(states) // 2000, 1)):
        many = gi.solve_ensemble(problem, some, t_end=END, step=STEP, save_every=1)
        digits += [gi.birkhoff_average(y[:, :2] ** 2).digits for y in many.y]
    seconds = time.perf_counter() - begun
    draw(inside, np.array(digits), arguments.images / "chart.png")
    record = {
        "benchmark": "ensemble-chart",
        "members": len(states),
        "seconds": seconds,
        "machine": describe(["geomint", "numba", "numpy"]),
    }
    path = arguments.out / "ensemble_chart.json"
    path.write_text(json.dumps(record, indent=1), encoding="utf-8")
    print(f"{len(states)} members in {seconds:.1f} s; wrote {path}")


def draw(inside: np.ndarray, digits: np.ndarray, path: Path) -> None:
    """Draw the chart."""
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    values = np.full(inside.shape, np.nan)
    values[inside] = digits
    figure, axes = plt.subplots(figsize=(5.4, 4.4), layout="constrained")
    shown = axes.imshow(
        values, origin="lower", extent=(-0.45, 0.68, -0.5, 0.5), cmap="viridis", vmin=1, vmax=8
    )
    axes.set(
        xlabel="q₂ at q₁ = 0",
        ylabel="p₂",
        title="Hénon–Heiles, energy 1/8, to t = 1000",
    )
    figure.colorbar(shown, label="digits of the averages of q₁² and q₂²", extend="max")
    figure.savefig(path, dpi=130)


if __name__ == "__main__":
    main()
