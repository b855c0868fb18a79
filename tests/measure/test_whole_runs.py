"""The sum over steps against one determinant: that of the derivative of the whole run."""

from __future__ import annotations

from importlib import resources
from typing import Any

import mpmath
import numpy as np
import pytest

import geomint as gi
from tests.measure.exact_maps import PROBLEMS, change

SCENES = sorted(
    path.name.removesuffix(".toml")
    for path in (resources.files("chaplygin") / "scenes").iterdir()
    if path.name.endswith(".toml")
)
OWN_METHODS = ("rattle-2", "verlet-2", "cf-4")
STEPS = 25


def off(problem: gi.Problem, y: np.ndarray) -> float:
    """How far a state is from the manifold."""
    return max((abs(gi.value(problem, c, y)) for c in problem.constraints.values()), default=0.0)


def in_turn(name: str, problem: gi.Problem) -> list[str]:
    """The methods that fit, by turns another one first; a Gauss method in every fourth scene."""
    at = SCENES.index(name)
    own = [m for m in OWN_METHODS if gi.find_method(m).needs in problem.forms]
    own = own[at // 2 % 2 :] + own[: at // 2 % 2]
    return ["gauss-4", *own] if at % 4 == 0 else [*own, "gauss-4"]


def begun(name: str, method: str, part: float = 1.0) -> tuple[gi.Problem, Any, float, str]:
    """A scene's problem and state, a step of the method, and the name of its time's end."""
    scene = gi.load_scene(name)
    h = part * gi.find_method(method).default_step(scene.problem, scene.state, 1.0)
    return scene.problem, scene.state, h, f"{scene.problem.time}_end"


def check(p: gi.Problem, y0: Any, run: dict[str, Any]) -> None:
    drift = gi.solve(p, y0, **run, observe=["measure"]).drift["measure"]
    flow = gi.tangent_flow(p, y0, **run)
    with mpmath.workdps(30):
        first, last = (np.array([mpmath.mpf(float(x)) for x in y]) for y in (y0, flow.y))
        J = mpmath.matrix(flow.slopes.tolist())
        whole = change(p, J, (0.0, first), (STEPS * run["step"], last))
    assert drift.final_error == pytest.approx(whole, rel=1e-6, abs=1e-13), run["method"]


def test_the_sum_is_one_determinant() -> None:
    """Of a method that does not keep the measure; its density depends on state and time."""
    check(*PROBLEMS["lotka-volterra"], {"method": "rk-4", "step": 0.1, "t_end": STEPS * 0.1})


@pytest.mark.nightly
@pytest.mark.parametrize("name", SCENES)
def test_it_is_in_every_scene(name: str) -> None:
    """For a method that stays on the manifold, in every third built-in scene for every such one."""
    seen = 0
    for method in in_turn(name, gi.load_scene(name).problem):
        p, y0, h, end = begun(name, method)
        run = {"method": method, "step": h, end: STEPS * h}
        if off(p, gi.solve(p, y0, **run, compiled=False).y[-1]) < 1e-12:
            check(p, y0, run)
            seen += 1
            if SCENES.index(name) % 3:
                break
    assert seen, "no method stays on the manifold"


@pytest.mark.nightly
@pytest.mark.parametrize("method", ["rattle-2", "rattle-4"])
@pytest.mark.parametrize("name", ["hamiltonized-n3", "clebsch-n4"])
@pytest.mark.parametrize("part", [1.0, 0.2])
def test_implicit_rattle_has_no_bias(name: str, method: str, part: float) -> None:
    """Where the constraint is met to rounding its derivative is not; slopes converge after values."""
    p, y0, h, end = begun(name, method, part)
    run = {"method": method, "step": h, end: 3000 * h, "observe": ["measure"]}
    assert gi.solve(p, y0, **run).drift["measure"].within_roundoff
