"""The sum over steps against one determinant: that of the derivative of the whole run."""

from __future__ import annotations

from importlib import resources

import numpy as np
import pytest

import geomint as gi
from geomint.problems.derivatives import slopes_of

SCENES = sorted(
    path.name.removesuffix(".toml")
    for path in (resources.files("chaplygin") / "scenes").iterdir()
    if path.name.endswith(".toml")
)
OWN_METHODS = ("rattle-2", "verlet-2", "cf-4")
STEPS = 25


def frame(problem: gi.Problem, y: np.ndarray, t: float) -> tuple[np.ndarray, float]:
    """Orthonormal tangent vectors, and the logarithm of the density of their cell."""
    measure = problem.measure
    assert measure is not None
    density = gi.value(problem, measure.log_density, y, t)
    if measure.manifold is None:
        return np.eye(problem.rows), density
    C = slopes_of(problem, measure.manifold, y, t, measure.conditions)
    Q, R = np.linalg.qr(C.T, mode="complete")
    return Q[:, measure.conditions :], density - float(np.log(np.abs(np.diag(R))).sum())


def off(problem: gi.Problem, y: np.ndarray) -> float:
    """How far a state is from the manifold."""
    return max((abs(gi.value(problem, c, y)) for c in problem.constraints.values()), default=0.0)


def in_turn(name: str, problem: gi.Problem) -> list[str]:
    """The methods that fit, by turns another one first; a Gauss method in every fourth scene."""
    at = SCENES.index(name)
    own = [m for m in OWN_METHODS if gi.find_method(m).needs in problem.forms]
    own = own[at // 2 % 2 :] + own[: at // 2 % 2]
    return ["gauss-4", *own] if at % 4 == 0 else [*own, "gauss-4"]


@pytest.mark.parametrize(
    ("name", "every"),
    [
        *(
            pytest.param(x, False, marks=[pytest.mark.nightly] * (i % 6 > 0))
            for i, x in enumerate(SCENES)
        ),
        *(pytest.param(x, True, marks=pytest.mark.nightly) for x in SCENES[::3]),
    ],
)
def test_the_sum_is_one_determinant(name: str, every: bool) -> None:
    """For a method that stays on the manifold, or every such one, in every built-in scene."""
    scene, seen = gi.load_scene(name), 0
    p, y0 = scene.problem, scene.state
    assert p.measure is not None
    for method in in_turn(name, p):
        h = gi.find_method(method).default_step(p, y0, 1.0)
        end = {"tau_end" if p.time == "tau" else "t_end": STEPS * h}
        run = {"method": method, "step": h}
        if off(p, gi.solve(p, y0, **end, **run, compiled=False).y[-1]) > 1e-12:
            continue
        drift = gi.solve(p, y0, **end, **run, observe=["measure"]).drift["measure"]
        flow = gi.tangent_flow(p, y0, **end, **run)
        (Q0, before), (Q1, after) = frame(p, y0, 0.0), frame(p, flow.y, STEPS * h)
        whole = np.linalg.slogdet(Q1.T @ flow.slopes @ Q0)[1] + after - before
        assert drift.final_error == pytest.approx(whole, rel=1e-6, abs=1e-13), method
        seen += 1
        if not every:
            break
    assert seen, "no method stays on the manifold"


@pytest.mark.parametrize("method", ["rattle-2", "rattle-4"])
@pytest.mark.parametrize("name", ["hamiltonized-n3", "clebsch-n4"])
@pytest.mark.parametrize("part", [1.0, 0.2], ids=["default", "small"])
def test_implicit_rattle_has_no_bias(name: str, method: str, part: float) -> None:
    """Where the constraint is met to rounding its derivative is not; slopes converge after values."""
    scene = gi.load_scene(name)
    p, y0 = scene.problem, scene.state
    h = part * gi.find_method(method).default_step(p, y0, 1.0)
    end = {"tau_end" if p.time == "tau" else "t_end": 3000 * h}
    sol = gi.solve(p, y0, **end, method=method, step=h, observe=["measure"])
    assert sol.drift["measure"].within_roundoff
