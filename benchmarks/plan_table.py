"""What plans leave out: every built-in scene, and scenes for further rules, against the plain way.

The plain way integrates the scene's own representation, with physical time where the method can, keeps
every state and watches every quantity that there is. Time is the least of the repeats, the two ways
in turn, without compilation; memory the peak of what Python and numpy allocate. Writes
``results/plan_table.json``.
"""

from __future__ import annotations

import argparse
import json
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import geomint as gi
from geomint.plan import estimate
from machine import describe

STEPS, REPEATS = 10_000, 3
GAMMA, P = [0.1, 0.3, 0.5, 0.7, 0.4], [1.0, 2.0, -1.0, -1.0, 1.25]
BALL: dict[str, Any] = {
    "initial": {"gamma": GAMMA, "p": P},
    "time": {"t_end": 5000.0},
    "integrate": {"method": "gauss-8", "step": 0.25},
    "observe": {"quantities": ["energy", "K"]},
    "save": {"every": 1000},
}
DIFFERENT, EQUAL = [0.7, 0.9, 1.2, 1.4, 1.7], [0.9, 0.9, 0.9, 0.9, 1.7]
FAR = {"time": {"t_end": 1e9}, "save": {"t_eval": [1.0, 1e9]}, "observe": {"quantities": []}}


def system(name: str, **keys: Any) -> dict[str, Any]:
    """Return what differs between the scenes for the rules."""
    return {**BALL, "system": {"name": name, **keys}}


RULES: dict[str, dict[str, Any]] = {
    "no momentum, n = 5: (k, γ) from (γ, p)": system("chaplygin-ball", a=DIFFERENT, D=4.0),
    "four equal $a_i$, n = 5: (γ, p)": system("chaplygin-sphere-reduced", a=EQUAL, D=4.0),
    "the same: (k, γ)": system("chaplygin-ball", a=EQUAL, D=4.0),
    "homogeneous ball, n = 5: (k, γ)": system("homogeneous-ball", n=5, s=1.5, D=2.0),
    "n = 2: (γ, p) from (k, γ)": {
        **system("chaplygin-sphere-reduced", a=[0.9, 1.2], D=4.0),
        "initial": {"gamma": [0.6, 0.8], "p": [-0.8, 0.6]},
    },
    "exact flow, n = 5: states at t = 1 and 10⁹": {
        **system("chaplygin-sphere-reduced", a=DIFFERENT, D=4.0),
        **FAR,
        "integrate": {**BALL["integrate"], "exact": True},
    },
    "exact flow of the homogeneous ball, n = 5": {
        **system("homogeneous-ball", n=5, s=1.5, D=2.0),
        **FAR,
        "integrate": {**BALL["integrate"], "exact": True},
    },
}


def shortened(scene: gi.Scene, steps: int) -> gi.Scene:
    """Return a scene that ends after so many steps."""
    name = "t_end" if scene.content.time.tau_end is None else "tau_end"
    step = scene.content.integrate.step or scene.method.default_step(scene.problem, scene.state)
    return scene.changed(time={name: steps * step}, integrate={"step": step})


def plainly(scene: gi.Scene) -> gi.Solution:
    """Integrate a scene with all that there is."""
    content = scene.content
    return gi.solve(
        scene.problem,
        scene.state,
        t_end=content.time.t_end,
        tau_end=content.time.tau_end,
        method=scene.method,
        step=content.integrate.step,
        save_every=1,
        observe="all",
        progress=False,
    )


def ways_of(scene: gi.Scene) -> dict[str, Callable[[], gi.Solution]]:
    """Return the plain way and the plans of a scene."""
    return {
        "plain": lambda: plainly(scene),
        "run": lambda: gi.make_plan(scene).solve(progress=False),
        "drift": lambda: gi.make_plan(scene.for_drift(), "drift").solve(progress=False),
    }


def measured(ways: dict[str, Callable[[], gi.Solution]]) -> dict[str, dict[str, Any]]:
    """Return time, memory and evaluations of each way, which take turns."""
    found: dict[str, dict[str, Any]] = {}
    for name, way in ways.items():
        way()
        tracemalloc.start()
        solution = way()
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        found[name] = {"seconds": np.inf, "bytes": peak, "evaluations": solution.evaluations}
    for _ in range(REPEATS):
        for name, way in ways.items():
            begun = time.perf_counter()
            way()
            found[name]["seconds"] = min(found[name]["seconds"], time.perf_counter() - begun)
    return found


def of_scene(name: str, steps: int) -> dict[str, Any]:
    """Return the row of a built-in scene; ends of ``[drift]`` aside, so that all take as many steps."""
    scene = shortened(gi.load_scene(name), steps)
    scene = scene.changed(drift={"t_end": None, "tau_end": None, "method": None, "step": None})
    return {"name": name, "ways": measured(ways_of(scene))}


def of_rule(label: str, content: dict[str, Any]) -> dict[str, Any]:
    """Return the row of a rule: the run, and steps in the scene's own representation.

    These are estimated where they would take an hour.
    """
    scene = gi.Scene(**content)
    own = scene.changed_integration(representation="own").changed(integrate={"exact": None})
    plan, plain = gi.make_plan(scene), gi.make_plan(own, costs=True)
    ways = {"run": lambda: plan.solve(progress=False)}
    if plan.exact is None:
        ways["plain"] = lambda: plain.solve(progress=False)
    found = measured(ways)
    if plan.exact is not None:
        evaluations = None if plain.evaluations is None else plain.evaluations.chosen
        seconds = estimate(plain).seconds
        found["plain"] = {"seconds": seconds, "bytes": None, "evaluations": evaluations}
    taken = "exact flow" if plan.exact is not None else plan.route.name
    return {"label": label, "taken": taken, "ways": found}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    parser.add_argument("--steps", type=int, default=STEPS)
    options = parser.parse_args()
    record = {
        "steps": options.steps,
        "scenes": [of_scene(name, options.steps) for name in gi.scene_names()],
        "rules": [of_rule(label, content) for label, content in RULES.items()],
        "machine": describe(["geomint", "numpy", "numba"]),
    }
    text = json.dumps(record, indent=1, ensure_ascii=False)
    (options.out / "plan_table.json").write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
