"""Pictures of exact motions for docs/systems.md: a rolling motion, its animation, families.

python benchmarks/exact_pictures.py [--out DIR]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import chaplygin as ch
import geomint as gi
from chaplygin.pictures.diagrams import draw_bifurcations, draw_rotation_numbers
from chaplygin.pictures.motion import motion_figure

FRAMES, FPS, SECONDS = 60, 20.0, 12.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path(__file__).parents[1] / "docs" / "images")
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    sphere = ch.ChaplyginSphere(inertia=ch.SpecialInertia.from_moments([1.0, 1.5, 2.6], 1.0))
    problem = sphere.classical()
    y0 = problem.state(gamma=[0.36, 0.48, 0.8], k=[1.2, -0.9, 0.6])
    exact = problem.exact(y0)
    path = ch.ContactPath(exact, 1.0)
    motion_figure(exact, path).savefig(out / "rolling-trace.png", dpi=110)
    motion = gi.solve(problem, y0, t_end=SECONDS, method="exact", dense=True)
    motion.animate(out / "rolling.gif", fps=FPS, speed=SECONDS * FPS / (FRAMES - 1))
    families().savefig(out / "families.png", dpi=130)
    print(f"drift {path.drift}, frequencies {exact.mean_frequencies}")


def families() -> plt.Figure:
    """Return the bifurcation diagram, and rotation numbers along a family that crosses it twice."""
    a, D = [0.8, 1.1, 1.5], 4.0
    problem = ch.ChaplyginSphere(a=a, D=D).hamiltonized()
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.6), layout="constrained")
    draw_bifurcations(axes[0], a, D, [problem.random_state(seed) for seed in range(40)])
    gamma = np.array([0.48, 0.6, 0.64])
    first = np.cross(gamma, [0.0, 0.0, 1.0])
    first /= np.linalg.norm(first)
    second = np.cross(gamma, first)
    angles = np.linspace(-0.5, 0.5, 801) * np.pi
    momenta = np.cos(angles)[:, None] * first + np.sin(angles)[:, None] * second
    states = [problem.state(gamma=gamma, p_tilde=p) for p in momenta]
    draw_rotation_numbers(axes[1], problem, states, "direction of the momentum (rad)", angles)
    axes[1].set_title("cusps: separatrices of the turns about axis 2")
    return figure


if __name__ == "__main__":
    main()
