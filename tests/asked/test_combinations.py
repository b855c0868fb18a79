"""What says nothing together is refused, or said: never dropped without a word."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main
from geomint.report import drift_page

SCENE: dict[str, Any] = {
    "system": {"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.48, 0.6, 0.64], "p": [3.0, -4.0, 1.5]},
    "time": {"t_end": 1.0},
    "integrate": {"method": "rk-4", "step": 0.125},
    "observe": {"quantities": ["energy"]},
}
IN_TAU = {
    **SCENE,
    "system": {**SCENE["system"], "name": "chaplygin-sphere-hamiltonized"},
    "time": {"tau_end": 1.0},
}
POISSON = {
    **IN_TAU,
    "system": {"name": "ball-poisson", "moments": [1.0, 1.5, 2.0], "D": 4.0},
    "integrate": {"method": "cf-4", "step": 0.125},
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


REFUSED_BY_SOLVE = {
    "observe_every of nothing": ({"observe_every": 3}, "observe_every = 3.*something to observe"),
    "observe_every = None": ({"observe_every": None}, "observe_every = None"),
    "options of what the problem has not": (
        {"observe": {"measure": {"steps": 3}}},
        "observe = 'measure': .*states no measure",
    ),
    "options that it has not": (
        {"observe": {"size": {"stops": 3}}},
        "stops = 3: .*no such option. Did you mean 'steps'",
    ),
    "options of a group": ({"observe": {"all": {"steps": 3}}}, "a group has no options"),
    "no steps to watch": ({"observe": {"size": {"steps": 0}}}, "steps = 0"),
    "t_eval after the end": ({"t_eval": [0.5, 1.5]}, "t_eval = .*from 0 to 1.0"),
    "t_eval before the start": ({"t_eval": [-0.5]}, "t_eval"),
    "t_eval the other way": ({"t_eval": [0.5], "t_end": -1.0}, "t_eval"),
    "no t_eval": ({"t_eval": []}, "at least one time"),
    "a clock in t": ({"clock": True}, "clock = True"),
    "two ends": ({"tau_end": 1.0, "t_end": 1.0}, "exactly one of them"),
    "an end in tau in t": ({"tau_end": 1.0, "t_end": None}, "tau_end = 1.0"),
}


@pytest.mark.parametrize("name", REFUSED_BY_SOLVE)
def test_solve_refuses(name: str) -> None:
    given, words = REFUSED_BY_SOLVE[name]
    with pytest.raises(gi.DomainError, match=words):
        solve(**given)


def test_a_clock_that_is_not_to_run_is_refused_where_it_is_needed() -> None:
    for given in ({"t_end": 1.0}, {"tau_end": 1.0, "t_eval": [0.5]}):
        with pytest.raises(gi.DomainError, match="clock = False"):
            solve(CLOCKED, clock=False, **given)


def test_a_problem_in_tau_without_a_clock() -> None:
    """Runs to an end in τ; what needs physical time is refused, and says so."""
    assert solve(CLOCKLESS, tau_end=1.0).physical is None
    for given in ({"t_end": 1.0}, {"tau_end": 1.0, "clock": True}, {"tau_end": 1.0, "t_eval": [1]}):
        with pytest.raises(gi.FormError, match="has no clock"):
            solve(CLOCKLESS, **given)
    with pytest.raises(gi.DomainError, match="own time is physical"):
        gi.Problem("turning", (("y", 2),), field=turning, clock=rate)


@pytest.mark.parametrize(
    ("problem", "given"),
    [
        (IN_T, {"t_end": 1.0}),
        (IN_T, {"t_end": -1.0}),
        (CLOCKED, {"t_end": 1.0}),
        (CLOCKED, {"tau_end": 1.0}),
        (IN_T, {"t_end": 1.0, "method": "dop853-adaptive"}),
    ],
)
def test_a_step_longer_than_the_run_is_said(problem: gi.Problem, given: dict) -> None:
    with pytest.warns(gi.GeomintWarning, match=r"step = 2 is longer than the run") as caught:
        solution = solve(problem, step=2.0, **given)
    assert caught[0].filename == __file__
    assert abs(solution.tau[-1]) == pytest.approx(1.0)
    solve(problem, **{**given, "step": 1.0 if "method" not in given else 0.01})
    solve(problem, **{**given, "step": None})


def test_what_a_refused_run_costs_is_nothing() -> None:
    def never(params, t, y, out, work):  # type: ignore[no-untyped-def]
        raise AssertionError("evaluated")

    problem = gi.Problem("never", (("y", 2),), field=gi.field(never))
    with pytest.raises(gi.DomainError, match="observe_every"):
        gi.solve(problem, [1.0, 0.0], t_end=1.0, step=0.1, method="rk-4", observe_every=2)


# --- scenes ---------------------------------------------------------------------------------------

REFUSED_SCENES = {
    "iteration tolerance of an explicit method": (
        {"integrate": {"method": "rk-4", "iteration_tolerance": 1e-15}},
        r"iteration_tolerance = 1e-15: no such key, nor an option of 'rk-4'",
    ),
    "rtol at fixed step": ({"integrate": {"method": "dop853", "rtol": 1e-9}}, "rtol"),
    "every and t_eval": ({"save": {"every": 2, "t_eval": [0.5]}}, "every or t_eval"),
    "no t_eval": ({"save": {"t_eval": []}}, "t_eval"),
    "method and methods": ({"drift": {"methods": ["rk-4"], "method": "rk-4"}}, "methods"),
    "step and methods": ({"drift": {"methods": ["rk-4"], "step": 0.1}}, "NAME:STEP"),
    "no methods": ({"compare": {"methods": []}}, "methods"),
    "no steps": ({"compare": {"steps": []}}, "steps"),
    "every of nothing": (
        {"observe": {"quantities": [], "every": 3}},
        r"\[observe\] every = 3: nothing is observed",
    ),
    "options of what is not observed": (
        {"observe": {"quantities": ["energy"], "measure": {"steps": 3}}},
        r"\[observe\] measure = {'steps': 3}: 'measure' is observed neither",
    ),
    "options that it has not": (
        {"observe": {"quantities": ["measure"], "measure": {"stops": 3}}},
        r"\[observe.measure\] stops = 3: expected no such option",
    ),
    "options that are none": (
        {"observe": {"quantities": ["measure"], "measure": 3}},
        r"\[observe\] measure = 3: no such key",
    ),
    "two ends": ({"time": {"t_end": 1.0, "tau_end": 1.0}}, "exactly one"),
    "two other ends": ({"drift": {"t_end": 1.0, "tau_end": 1.0}}, "t_end or tau_end"),
    "an end in tau": ({"compare": {"tau_end": 1.0}}, "expected t_end"),
}


@pytest.mark.parametrize("name", REFUSED_SCENES)
def test_a_scene_refuses(name: str) -> None:
    sections, words = REFUSED_SCENES[name]
    with pytest.raises(gi.SceneError, match=words):
        gi.Scene(**{**SCENE, **sections})


def test_options_may_be_of_what_the_drift_report_watches() -> None:
    """And go with it, where something else is watched."""
    watched = {"quantities": ["energy"], "measure": {"steps": 3}}
    scene = gi.Scene(**{**SCENE, "observe": watched, "drift": {"quantities": ["measure"]}})
    assert scene.for_drift().content.observe.options == {"measure": {"steps": 3}}
    assert scene.for_drift().changed_observation(["K"]).content.observe.options == {}
    assert scene.changed_observation(every=2).content.observe.options["measure"] == {"steps": 3}
    none = gi.Scene(**{**SCENE, "observe": {"quantities": ["K"], "every": 5}}).changed_observation(
        []
    )
    assert none.content.observe.every == 1


def test_a_plan_refuses_times_outside_of_the_run() -> None:
    scene = gi.Scene(**SCENE, save={"t_eval": [0.5, 2.0]})
    for purpose in ("run", "drift"):
        if purpose == "run":
            with pytest.raises(gi.DomainError, match=r"t_eval = \[0.5, 2.0\].*from 0 to 1.0"):
                gi.make_plan(scene, purpose)
        else:
            gi.make_plan(scene, purpose)  # keeps no states
    back = gi.Scene(**{**SCENE, "time": {"t_end": -1.0}}, save={"t_eval": [0.5]})
    with pytest.raises(gi.DomainError, match="t_eval"):
        gi.make_plan(back)


def test_states_at_physical_times_by_a_group_method() -> None:
    """Of a problem in τ: the clock goes beside the group."""
    scene = gi.Scene(**POISSON).changed(save={"t_eval": [0.5]})
    plan = gi.make_plan(scene)
    assert plan.problem.time == "tau"
    assert plan.clock.chosen
    assert plan.solve().t.tolist() == [0.5]


def test_a_drift_report_of_which_nothing_is_left_is_refused() -> None:
    """One of nothing says so itself."""
    scene = gi.Scene(**{**SCENE, "observe": {"quantities": []}})
    for purpose in ("run", "drift"):
        assert gi.make_plan(scene, purpose).watched.value == "nothing"
    forced = gi.Scene(**SCENE).changed_integration(representation="reduced")
    with pytest.raises(gi.SceneError, match=r"nothing to show.*reduced has no spatial-momentum"):
        gi.make_plan(forced.changed_observation(["spatial-momentum"]), "drift")


def test_a_named_quantity_is_never_another() -> None:
    """It is watched, in whatever form has it; or refused; or, in a drift report, said to be missing."""
    ball = {"name": "rolling-ball", "a": [0.8, 1.1, 1.5], "D": 4.0}
    scene = gi.Scene(**{**SCENE, "system": ball})
    scene = scene.changed_observation(["energy", "orthogonality"])
    for purpose in ("run", "drift"):
        plan = gi.make_plan(scene, purpose)
        assert plan.watched.chosen == ("energy", "orthogonality")
        assert plan.notes == ()
    forced = scene.changed_integration(representation="reduced")
    with pytest.raises(
        gi.FormError, match=r"'reduced'.*has no orthogonality\. It has energy, K, .*norm"
    ):
        gi.make_plan(forced, "run")
    plan = gi.make_plan(forced, "drift")
    assert plan.watched.chosen == ("energy",)
    assert plan.notes[0].startswith(
        "not watched: orthogonality: reduced has no such quantity; only in"
    )
    group = forced.changed_observation(["energy", "constraints"])
    for purpose in ("run", "drift"):
        watched = gi.make_plan(group, purpose).watched.chosen
        assert watched == ("energy", "norm", "tangency")


def test_what_a_drift_report_misses_is_said(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(drift_page, "write_drift_report", lambda *args: tmp_path)  # no pictures
    scene = gi.Scene(**SCENE).changed_integration(representation="reduced")
    scene = scene.changed_observation(["energy", "spatial-momentum"])
    with pytest.warns(gi.GeomintWarning, match="not watched: spatial-momentum"):
        result = gi.drift_report(scene, tmp_path, False)
    assert list(result[0].drift) == ["energy"]
    (tmp_path / "s.toml").write_text(scene.toml(), encoding="utf-8")
    told = invoke("drift", tmp_path / "s.toml", "--quiet", "--out", tmp_path)
    assert told.exit_code == 0
    assert "note: not watched: spatial-momentum" in told.stderr


def test_a_splitting_that_is_not_symplectic_is_not_called_so() -> None:
    import dataclasses

    scene = gi.load_scene("neumann-n3")
    assert "symplectic" in gi.make_plan(scene).method.reason
    problem = scene.problem
    assert problem.splitting is not None
    other = dataclasses.replace(
        problem, splitting=dataclasses.replace(problem.splitting, symplectic=False)
    )
    scene.model.problems[next(iter(scene.model.problems))] = other
    assert "symplectic" not in gi.make_plan(scene).method.reason


# --- the command line -----------------------------------------------------------------------------


def invoke(*arguments: Any) -> Any:
    return CliRunner().invoke(main, [str(a) for a in arguments], env={"COLUMNS": "120"})


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("drift sphere-n3 --methods rk-4 --step 0.1", "write NAME:STEP"),
        ("drift sphere-n3 --methods rk-4 --method rk-4", "write NAME:STEP"),
        ("check sphere-n3 --methods rk-4 --method rk-4", "write NAME:STEP"),
        (
            "drift sphere-n3 --observe spatial-momentum --representation reduced",
            "nothing to show",
        ),
        ("check sphere-n3 --t-end 1 --tau-end 1", "one of them"),
        ("compare sphere-n3 --t-end 1 --tau-end 1", "exactly one of t_end and tau_end"),
        ("compare sphere-n3 --tau-end 1", "expected t_end"),
        ("compare sphere-n3 --methods ,", "names with commas"),
        ("compare sphere-n3 --steps ,", "numbers with commas"),
        ("compare sphere-n3 --steps 0.1,a", "--steps = '0.1,a'"),
        ("compare sphere-n3 --steps -0.1", "--steps"),
        ("compare sphere-n3 --methods dop853-adaptive --steps 0.1", "choose their steps"),
        ("compare neumann-n3 --reference exact --t-end 1", "no exact flow"),
        ("exact hamiltonized-n3 --frames 5", "--frames"),
        ("audit --brief --quiet", "--brief"),
        ("stress --systems neumann --axis nothing", "no such axis"),
        ("stress --seconds 0", "--seconds"),
        ("inertia --a 1,2 --moments 1,2,3", "exactly one"),
        ("inertia --a 1,2 --d 1 --m 1", "--m and --rho alone"),
    ],
)
def test_a_command_refuses(arguments: str, words: str, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = invoke(*arguments.split())
    assert result.exit_code == 2
    assert words in result.stderr
    assert "Traceback" not in result.stderr


def test_a_stress_test_of_nothing_is_refused() -> None:
    from geomint.stress.sweep import Selection, run_selection, selected

    with pytest.raises(gi.GeomintError, match="no case has these"):
        selected(Selection(systems=("ellipsoid-n3",), axes=("step",)))
    with pytest.raises(gi.GeomintError, match="fits any of these cases"):
        run_selection(Selection(methods=("rattle-2",), systems=("ball-full-n4",)), None)


def test_options_of_steps_reach_the_points(monkeypatch) -> None:
    """``--steps`` takes what the documentation says: numbers with commas between."""
    from geomint.compare import of_scene
    from geomint.compare.runs import Comparison
    from geomint.report import compare_page

    asked: list[Any] = []

    def note(*args: Any) -> Comparison:
        asked.append(args[2])
        return Comparison([], {})

    monkeypatch.setattr(of_scene, "compare_scene", note)
    monkeypatch.setattr(compare_page, "write_compare_report", lambda *args: None)
    assert invoke("compare", "sphere-n3", "--steps", "0.1, 0.25", "--quiet").exit_code == 0
    np.testing.assert_array_equal(asked, [[0.1, 0.25]])
