"""Pictures of docs/systems.md: controls where no multiplier exists, and systems that correspond.

python benchmarks/systems.py [--out DIR]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import chaplygin as ch
import geomint as gi
from chaplygin.manifold import wedge

BLUE, ORANGE, GREEN, BLACK = "#0072b2", "#d55e00", "#009e73", "#222222"
POINTS = 12


def controls(out: Path) -> None:
    """Show closedness and measure defects at random states, by system and dimension."""
    rng = np.random.default_rng(5)
    names = [
        "special operator\nno momentum",
        "Lagrange's body\nno momentum",
        "special operator\nwith momentum",
        "rigid body, any J\nno momentum",
    ]
    figure, axes = plt.subplots(1, 3, figsize=(10.5, 3.9), sharey=True, layout="constrained")
    for axis, n in zip(axes, (3, 4, 5), strict=True):
        for x, name in enumerate(names):
            for point in range(POINTS):
                found = _defects(rng, n, x)
                shift = (point / POINTS - 0.5) * 0.5
                for value, marker, color in (
                    (found.closedness, "o", BLUE),
                    (found.measure, "+", ORANGE),
                ):
                    axis.semilogy(x + shift, max(value, 1e-17), marker, color=color, ms=4)
            del name
        axis.set_title(f"n = {n}")
        axis.set_xticks(range(len(names)), names, fontsize=7, rotation=35, ha="right")
        axis.grid(axis="y", alpha=0.3)
    axes[0].set_ylabel("defect, relative to the parts of $[\\Pi, \\Pi]$")
    axes[0].plot([], [], "o", color=BLUE, ms=4, label="closedness: no multiplier at all")
    axes[0].plot([], [], "+", color=ORANGE, ms=5, label="measure: not the measure's multiplier")
    axes[0].legend(loc="center left", fontsize=7)
    figure.savefig(out / "controls.png", dpi=150)


def _defects(rng: np.random.Generator, n: int, which: int) -> ch.MultiplierDefects:
    gamma = rng.normal(size=n)
    gamma /= np.linalg.norm(gamma)
    p = rng.normal(size=n)
    p -= (gamma @ p) * gamma
    a = rng.uniform(0.5, 1.6, n)
    if which == 1:
        a[:-1] = a[0]
    D = 1.5 * float(np.prod(np.sort(a)[-2:]))
    inertia: ch.SpecialInertia | ch.GeneralInertia = ch.SpecialInertia(a, D)
    if which == 3:
        inertia = ch.GeneralInertia.from_mass_tensor(rng.uniform(0.3, 2.0, n))
    k = rng.normal(size=n * (n - 1) // 2) if which == 2 else wedge(gamma, p)
    return ch.multiplier_defects(inertia, D, gamma, k)


def correspondence(out: Path) -> None:
    """Show the vertical of the sphere and that of Clebsch's system, integrated apart, n = 3."""
    sphere = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)
    flow = sphere.hamiltonized()
    y = flow.state(gamma=[0.48, 0.6, 0.64], p=[0.8, 1.0, -1.5375])
    map_ = ch.to_clebsch(sphere, y)
    run = {"method": "gauss-8", "step": 0.1, "save_every": 1, "progress": False}
    own = gi.solve(flow, y, tau_end=400.0, **run)
    other = gi.solve(map_.target, map_.forward(y), t_end=400.0, **run)
    times = own.tau
    carried = np.array([map_.forward(state) for state in own.y])
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4.1), layout="constrained")
    shown = 700
    left.plot(own.y[:shown, 0], own.y[:shown, 1], color=BLUE, lw=0.8, label="sphere, γ")
    every = slice(0, shown, 10)
    left.plot(other.y[every, 0], other.y[every, 1], "o", color=ORANGE, ms=3, label="Clebsch, q")
    left.add_patch(plt.Circle((0, 0), 1, fill=False, color=BLACK, lw=0.6))
    left.set_aspect("equal")
    left.set_xlabel("$\\gamma_1$, $q_1$ (dimensionless)")
    left.set_ylabel("$\\gamma_2$, $q_2$ (dimensionless)")
    left.legend(loc="lower left", fontsize=8)
    distance = np.max(np.abs(carried - other.y), axis=1)
    right.loglog(times[1:], np.maximum(distance[1:], 1e-17), color=GREEN, lw=0.8)
    right.set_xlabel("time τ (dimensionless)")
    right.set_ylabel("largest difference of the states")
    right.grid(alpha=0.3)
    figure.savefig(out / "correspondence.png", dpi=150)
    print(f"largest difference until τ = {times[-1]:g}: {np.max(distance):.2g}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path(__file__).parents[1] / "docs" / "images")
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    controls(out)
    correspondence(out)


if __name__ == "__main__":
    main()
