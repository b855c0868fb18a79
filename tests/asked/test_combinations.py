"""What says nothing together is refused, or said: never dropped without a word."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

import geomint as gi
from tests.cli.calls import invoke

SCENE: dict[str, Any] = {
    "system": {"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.48, 0.6, 0.64], "p": [3.0, -4.0, 1.5]},
    "time": {"t_end": 1.0},
    "integrate": {"method": "rk-4", "step": 0.125},
    "observe": {"quantities": ["energy"]},
}


@gi.field
def turning(params, t, y, out, work):
    out[0] = -y[1]
    out[1] = y[0]


@gi.observable
def size(params, t, y, work):
    return y[0] * y[0] + y[1] * y[1]


@gi.observable
def rate(params, t, y, work):
    return 1.0 + 0.0 * y[0]


IN_T = gi.Problem("turning", (("y", 2),), field=turning, invariants={"size": size})
CLOCKED = gi.Problem("turning", (("y", 2),), field=turning, time="tau", clock=rate)
CLOCKLESS = gi.Problem("turning", (("y", 2),), field=turning, time="tau")


def solve(problem: gi.Problem = IN_T, **given: Any) -> gi.Solution:
    given = {"method": "rk-4", "step": 0.25, "compiled": False, "progress": False, **given}
    end = {} if "tau_end" in given else {"t_end": 1.0}
    return gi.solve(problem, [0.8, 0.6], **{**end, **given})


REFUSED_BY_SOLVE: list[tuple[dict[str, Any], str]] = [
    ({"observe_every": 3}, "observe_every = 3.*something to observe"),
    ({"observe_every": None}, "observe_every = None"),
    ({"observe": {"measure": {"steps": 3}}}, "observe = 'measure': .*states no measure"),
    ({"observe": {"size": {"stops": 3}}}, "stops = 3: .*no such option. Did you mean 'steps'"),
    ({"observe": {"all": {"steps": 3}}}, "a group has no options"),
    ({"observe": {"size": {"steps": 0}}}, "steps = 0"),
    ({"t_eval": [0.5, 1.5]}, "t_eval = .*from 0 to 1.0"),
    ({"t_eval": [-0.5]}, "t_eval"),
    ({"t_eval": [0.5], "t_end": -1.0}, "t_eval"),
    ({"t_eval": []}, "at least one time"),
    ({"clock": True}, "clock = True"),
    ({"tau_end": 1.0, "t_end": 1.0}, "exactly one of them"),
    ({"tau_end": 1.0, "t_end": None}, "tau_end = 1.0"),
    ({"problem": CLOCKED, "clock": False, "t_end": 1.0}, "clock = False"),
    ({"problem": CLOCKED, "clock": False, "tau_end": 1.0, "t_eval": [0.5]}, "clock = False"),
    ({"problem": CLOCKLESS, "t_end": 1.0}, "has no clock"),
    ({"problem": CLOCKLESS, "tau_end": 1.0, "clock": True}, "has no clock"),
    ({"problem": CLOCKLESS, "tau_end": 1.0, "t_eval": [1]}, "has no clock"),
]


@pytest.mark.parametrize(("given", "words"), REFUSED_BY_SOLVE, ids=str)
def test_solve_refuses(given: dict[str, Any], words: str) -> None:
    with pytest.raises((gi.DomainError, gi.FormError), match=words):
        solve(**given)


def test_only_a_problem_in_tau_has_a_clock() -> None:
    assert solve(CLOCKLESS, tau_end=1.0).physical is None
    with pytest.raises(gi.DomainError, match="own time is physical"):
        gi.Problem("turning", (("y", 2),), field=turning, clock=rate)


LONGER = [(IN_T, {"t_end": -1.0}), (CLOCKED, {"t_end": 1.0}), (CLOCKED, {"tau_end": 1.0})]
LONGER += [(IN_T, {"t_end": 1.0, "method": "dop853-adaptive"})]


@pytest.mark.parametrize(("problem", "given"), LONGER)
def test_a_step_longer_than_the_run_is_said(problem: gi.Problem, given: dict[str, Any]) -> None:
    with pytest.warns(gi.GeomintWarning, match=r"step = 2 is longer than the run") as caught:
        solution = solve(problem, step=2.0, **given)
    assert caught[0].filename == __file__
    assert abs(solution.tau[-1]) == pytest.approx(1.0)
    for step in (1.0 if "method" not in given else 0.01, None):
        solve(problem, **{**given, "step": step})


# --- scenes ---------------------------------------------------------------------------------------

NOTHING_OF = {"quantities": ["energy"], "measure": {"steps": 3}}
NO_TABLE = {"quantities": ["measure"], "measure": 3}
WRONG_OF = {"quantities": ["measure"], "measure": {"stops": 3}}
REFUSED_SCENES: list[tuple[dict[str, Any], str]] = [
    ({"integrate": {"method": "rk-4", "iteration_tolerance": 1e-15}}, "nor an option of 'rk-4'"),
    ({"integrate": {"method": "dop853", "rtol": 1e-9}}, "rtol"),
    ({"save": {"every": 2, "t_eval": [0.5]}}, "every or t_eval"),
    ({"save": {"t_eval": []}}, "t_eval"),
    ({"drift": {"methods": ["rk-4"], "method": "rk-4"}}, "methods"),
    ({"drift": {"methods": ["rk-4"], "step": 0.1}}, "NAME:STEP"),
    ({"compare": {"methods": []}}, "methods"),
    ({"compare": {"steps": []}}, "steps"),
    ({"observe": {"quantities": [], "every": 3}}, r"\[observe\] every = 3: nothing is observed"),
    ({"observe": NOTHING_OF}, r"\[observe\] measure = {'steps': 3}: 'measure' is observed neither"),
    ({"observe": WRONG_OF}, r"\[observe.measure\] stops = 3: expected no such option"),
    ({"observe": NO_TABLE}, r"\[observe\] measure = 3: no such key"),
    ({"time": {"t_end": 1.0, "tau_end": 1.0}}, "exactly one"),
    ({"drift": {"t_end": 1.0, "tau_end": 1.0}}, "t_end or tau_end"),
    ({"compare": {"tau_end": 1.0}}, "expected t_end"),
]


@pytest.mark.parametrize(("sections", "words"), REFUSED_SCENES, ids=str)
def test_a_scene_refuses(sections: dict[str, Any], words: str) -> None:
    with pytest.raises(gi.SceneError, match=words):
        gi.Scene(**{**SCENE, **sections})


def test_options_may_be_of_what_the_drift_report_watches() -> None:
    """And go with it, where something else is watched."""
    watched = {"quantities": ["energy"], "measure": {"steps": 3}}
    scene = gi.Scene(**{**SCENE, "observe": watched, "drift": {"quantities": ["measure"]}})
    assert scene.for_drift().content.observe.options == {"measure": {"steps": 3}}
    assert scene.for_drift().changed_observation(["K"]).content.observe.options == {}
    assert scene.changed_observation(every=2).content.observe.options["measure"] == {"steps": 3}
    every = gi.Scene(**{**SCENE, "observe": {"quantities": ["K"], "every": 5}})
    assert every.changed_observation([]).content.observe.every == 1


def test_a_plan_refuses_times_outside_of_the_run() -> None:
    scene = gi.Scene(**SCENE, save={"t_eval": [0.5, 2.0]})
    with pytest.raises(gi.DomainError, match=r"t_eval = \[0.5, 2.0\].*from 0 to 1.0"):
        gi.make_plan(scene)
    gi.make_plan(scene, "drift")  # keeps no states
    with pytest.raises(gi.DomainError, match="t_eval"):
        gi.make_plan(scene.changed(time={"t_end": -1.0}, save={"t_eval": [0.5]}))


@pytest.mark.usefixtures("blank_pictures")
def test_what_a_drift_report_misses_is_said(tmp_path) -> None:
    scene = gi.Scene(**SCENE).changed_integration(representation="reduced")
    scene = scene.changed_observation(["energy", "spatial-momentum"])
    with pytest.warns(gi.GeomintWarning, match="not watched: spatial-momentum"):
        result = gi.drift_report(scene, tmp_path, progress=False)
    assert list(result[0].drift) == ["energy"]
    (tmp_path / "s.toml").write_text(scene.toml(), encoding="utf-8")
    told = invoke("drift", tmp_path / "s.toml", "--quiet", "--out", tmp_path)
    assert told.exit_code == 0
    assert "note: not watched: spatial-momentum" in told.stderr


def test_a_splitting_that_is_not_symplectic_is_not_called_so() -> None:
    scene = gi.load_scene("neumann-n3")
    assert "symplectic" in gi.make_plan(scene).method.reason
    splitting = dataclasses.replace(scene.problem.splitting, symplectic=False)
    other = dataclasses.replace(scene.problem, splitting=splitting)
    scene.model.problems[next(iter(scene.model.problems))] = other
    assert "symplectic" not in gi.make_plan(scene).method.reason
