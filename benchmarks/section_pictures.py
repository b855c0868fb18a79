"""Pictures of the pages on sections, times and events, into ``docs/images``.

``sections.png``: the reduced Chaplygin sphere, n = 3, which is integrable, beside the system of Hénon
and Heiles at energy 1/8, which is not; twelve motions of one energy each. ``states-at-times.png`` and
``stop-when.png`` show the examples of their pages.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import geomint as gi
from geomint.plots.canvas import new_figure
from geomint.plots.section_plot import draw_section
from geomint.plots.style import COLOURS, WIDTH
from geomint.problems.testproblems import henon_heiles
from geomint.run.level import states_on_level

IMAGES = Path(__file__).parents[1] / "docs" / "images"
MOTIONS, POINTS = 12, 700


def sections() -> gi.Section:
    """Draw both sections; return that of the system which is not integrable."""
    scene = gi.load_scene("sphere-n3")
    control = henon_heiles.problem()
    q2 = 0.1  # H = ½ p₁² + ½ q₂² − q₂³/3 on the surface
    begin = [0.0, q2, np.sqrt(2.0 * (0.125 - 0.5 * q2**2 + q2**3 / 3.0)), 0.0]
    cases = [
        ("integrable: reduced sphere, n = 3", scene.problem, scene.state, "gamma[2]", 0.5),
        ("not: Hénon and Heiles, energy 1/8", control, begin, "q[0]", 0.25),
    ]
    with new_figure(1.6 * WIDTH, 0.68 * WIDTH, layout="constrained") as figure:
        panels = figure.subplots(1, 2)
        for panel, (title, problem, y0, event, step) in zip(panels, cases, strict=True):
            others = states_on_level(problem, y0, MOTIONS - 1, seed=1)
            found = gi.poincare_section(
                problem, [y0, *others], gi.Event(event, "up"), POINTS, step=step
            )
            draw_section(panel, found.coordinates(), found.motions, found.axes, found.boundary)
            panel.set_title(f"{title}; {event} = 0, up")
        figure.savefig(IMAGES / "sections.png", dpi=130)
    return found


def times() -> None:
    """Draw steps, and states between them."""
    scene = gi.load_scene("hamiltonized-n3")
    t = np.linspace(0.0, 12.0, 400)
    run = gi.solve(scene.problem, scene.state, t_end=12.0, step=0.5, dense=True, save_every=1)
    with new_figure(WIDTH, 0.5 * WIDTH, layout="constrained") as figure:
        panel = figure.subplots()
        for i in range(3):
            panel.plot(t, run.sol(t)[:, i], color=COLOURS[i], label=f"γ{'₁₂₃'[i]}")
            panel.plot(
                run.t, run.y[:, i], linestyle="none", marker="o", markersize=4, color=COLOURS[i]
            )
        panel.set_xlabel("physical time t")
        panel.set_ylabel("γ; dots: steps of 0.5 in τ")
        panel.set_ylim(-1.1, 1.35)
        panel.legend(loc="upper right", ncols=3)
        figure.savefig(IMAGES / "states-at-times.png", dpi=130)


def stop() -> None:
    """Draw a run that ends at the third of its events."""
    scene = gi.load_scene("sphere-n3")
    event = gi.Event("gamma[2]", "up", terminal=3)
    run = gi.solve(scene.problem, scene.state, t_end=1000.0, dense=True, events=event)
    end = float(run.t[-1])
    t = np.linspace(0.0, end, 500)
    met = run.events["gamma[2]"]
    with new_figure(WIDTH, 0.45 * WIDTH, layout="constrained") as figure:
        panel = figure.subplots()
        panel.axhline(0.0, color="#999999", linewidth=0.8)
        panel.plot(t, run.sol(t)[:, 2], color=COLOURS[0])
        panel.plot(met.t, met.y[:, 2], linestyle="none", marker="o", color=COLOURS[1])
        panel.set_xlabel("physical time t")
        panel.set_ylabel("γ₃")
        panel.set_title(f"ended by the third event, at t = {end:.6f}")
        figure.savefig(IMAGES / "stop-when.png", dpi=130)


def main() -> None:
    """Draw all pictures."""
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    sections()
    times()
    stop()


if __name__ == "__main__":
    main()
