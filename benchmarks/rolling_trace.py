"""Pictures of an exact rolling motion, n = 3: contact point, vertical, torus. For docs/systems.md.

python benchmarks/rolling_trace.py [--out DIR]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import chaplygin as ch

BLUE, ORANGE, GREY = "#0072b2", "#d55e00", "#999999"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs/images"))
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    sphere = ch.ChaplyginSphere.from_moments([1.0, 1.5, 2.6], 1.0, 1.0)
    problem = sphere.classical()
    exact = problem.exact(problem.state(gamma=[0.36, 0.48, 0.8], k=[1.2, -0.9, 0.6]))
    path = ch.ContactPath(exact, 1.0)
    times = np.linspace(0.0, 400.0, 8001)
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.9), layout="constrained")
    _contact(axes[0], path, times)
    _vertical(axes[1], exact, times)
    _torus(axes[2], exact, times[:400])
    figure.savefig(out / "rolling-trace.png", dpi=150)
    print(f"drift {path.drift}, frequencies {exact.mean_frequencies}")


def _contact(axis, path, times) -> None:
    """Show the quasi-periodic part of the contact point."""
    trace = path.contact(times) - np.outer(times, path.drift)
    axis.plot(*trace.T, color=BLUE, lw=0.6)
    speed = np.linalg.norm(path.drift)
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlabel("$r_1/\\rho$ less drift")
    axis.set_ylabel("$r_2/\\rho$ less drift")
    axis.set_title(f"contact point, less a drift of {speed:.3f} ρ per time")


def _vertical(axis, exact, times) -> None:
    """Show γ₁ of the ball with area zero, and the curves λ = const that bound it, from above."""
    gamma = exact._map(exact.torus.solve(exact.phases(exact.tau(times))))[0]
    axis.plot(gamma[:, 0], gamma[:, 1], color=BLUE, lw=0.6)
    chart = ch.Spheroconical(exact.a)
    low, high = chart.a.min(), chart.a.max()
    middle = np.sort(chart.a)[1]
    for k, oval in enumerate(exact.separation.ovals):
        for value in (float(oval.lower), float(oval.upper)):
            if np.min(np.abs(chart.a - value)) < 1e-12:
                continue  # a coordinate plane: no boundary
            other = np.linspace(middle, high, 200) if k == 0 else np.linspace(low, middle, 200)
            lam = np.stack([np.full(200, value), other] if k == 0 else [other, np.full(200, value)])
            points = np.array([chart.gamma(x[:, None] - chart.a, np.ones(3)) for x in lam.T])
            for sx in (1, -1):
                for sy in (1, -1):
                    axis.plot(sx * points[:, 0], sy * points[:, 1], color=ORANGE, lw=1.4)
    axis.add_patch(plt.Circle((0, 0), 1, fill=False, color=GREY, lw=0.8))
    axis.set_aspect("equal")
    axis.set_xlabel("$\\gamma_1$")
    axis.set_ylabel("$\\gamma_2$")
    axis.set_title("vertical, and the λ that bound it")


def _torus(axis, exact, times) -> None:
    """Show the motion in θ, unwrapped, and the straight line that it is in φ."""
    phi = exact.start + np.outer(exact.tau(times), exact.frequencies)
    theta = exact.torus.solve(phi)
    axis.plot(*(theta / np.pi).T, color=BLUE, lw=1.0, label="θ")
    axis.plot(*(phi / np.pi).T, "--", color=ORANGE, lw=1.0, label="φ, linear in τ")
    axis.set_xlabel("first angle / π")
    axis.set_ylabel("second angle / π")
    axis.set_title("torus, unwrapped")
    axis.legend(fontsize=8)
    axis.grid(alpha=0.3)


if __name__ == "__main__":
    main()
