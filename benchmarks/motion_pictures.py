"""Pictures of docs/see-the-motion.md: ``python benchmarks/motion_pictures.py [--out DIR]``."""

from __future__ import annotations

import argparse
from pathlib import Path

import chaplygin as ch
import geomint as gi

DPI = 130


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path(__file__).parents[1] / "docs" / "images")
    out = parser.parse_args().out
    ball = ch.ChaplyginSphere.from_moments([1.0, 1.5, 2.4], m=1.0, rho=1.0)
    problem = ball.contact(rho=1.0)
    y0 = problem.state(gamma=[0.36, 0.48, 0.8], k=[1.2, -0.9, 0.6])
    sol = gi.solve(problem, y0, t_end=60.0, method="cf-4", step=0.05, dense=True)
    marble = ch.Ball(mass=0.4, radius=0.1, moments=[1.2e-3, 1.6e-3, 2.0e-3]).problem()
    spun = marble.state(gamma=[0.36, 0.48, 0.8], omega_space=[0.0, 5.0, 20.0])
    spinning = gi.solve(marble, spun, t_end=3.0, method="cf-4", step=0.002, dense=True)
    figures = {
        "units": spinning.plot("omega-body", "omega-space", "contact", "reaction"),
        "over-time": sol.plot("gamma", "speed", span=(0, 30)),
        "sphere": sol.plot_sphere(),
        "trace": sol.plot_trace(),
    }
    for name, figure in figures.items():
        figure.savefig(out / f"motion-{name}.png", dpi=DPI)


if __name__ == "__main__":
    main()
