"""States by the exact flow where a scene allows it: the same, without a step; and when not."""

import pickle

import numpy as np
import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main

CONTENT = {
    "system": {"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.6, 0.0, 0.8], "p": [0.8, 1.0, -0.6]},
    "time": {"t_end": 20.0},
    "integrate": {"step": 0.125, "exact": True},
    "observe": {"quantities": []},
}
BALL = {
    "system": {"name": "chaplygin-ball", "a": [0.7, 0.9, 1.2, 1.4], "D": 4.0},
    "initial": {"gamma": [0.5, 0.5, -0.5, 0.5], "p": [1.0, -0.5, 0.25, -0.25]},
}
SPINNING = {"gamma": [0.5, 0.5, -0.5, 0.5], "k": [1.0, 0.4, -0.3, 0.8, 0.2, -0.6]}
IN_TAU = {"system": {**CONTENT["system"], "name": "chaplygin-sphere-hamiltonized"}}
HOMOGENEOUS = {
    "system": {"name": "homogeneous-ball", "n": 4, "s": 1.5, "D": 2.0},
    "initial": SPINNING,
}


def scene(**sections):
    return gi.Scene(**{**CONTENT, **sections})


@pytest.mark.parametrize(
    "sections",
    [
        {"save": {"t_eval": [0.5, 3.0]}},
        {"time": {"t_end": -4.0}, "save": {"t_eval": [-0.5, -3.0]}},
        {**IN_TAU, "time": {"tau_end": 7.0}},
        {**IN_TAU, "time": {"tau_end": 7.0}, "save": {"t_eval": [0.5, 3.0]}},
        {**IN_TAU, "time": {"t_end": 7.0}},
        BALL,
        pytest.param(HOMOGENEOUS, marks=pytest.mark.nightly),
    ],
    ids=["times", "back", "tau", "times in tau", "t in tau", "lifted", "homogeneous"],
)
def test_the_states_are_those_of_steps(sections):
    asked = scene(**sections)
    exact, stepped = gi.make_plan(asked), gi.make_plan(asked.changed(integrate={"exact": False}))
    assert exact.exact.chosen is exact.route
    assert exact.steps.chosen == 0
    assert stepped.exact is None
    one, other = exact.solve(progress=False), stepped.solve(progress=False)
    assert one.problem is other.problem
    assert one.steps == one.evaluations == 0
    assert one.route == "exact flow"
    np.testing.assert_allclose(one.y, other.y, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(one.tau, other.tau, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(one.t, other.t, rtol=0.0, atol=1e-12)


def test_two_states_far_apart_take_no_evaluations():
    asked = scene(time={"t_end": 1e9}, save={"t_eval": [1.0, 1e9]})
    plain = gi.make_plan(asked.changed(integrate={"exact": False}), costs=True)
    assert plain.evaluations.chosen > 1e10
    motion = asked.problem.exact(asked.state)
    tau = motion.tau(1e9)
    known = motion.phase_error(tau) + motion.time_error(tau)
    assert f"phases are known to {known:.1e}" in gi.make_plan(asked).exact.reason
    solution = gi.run_scene(asked, progress=False)
    np.testing.assert_array_equal(solution.t, [1.0, 1e9])
    energies = [gi.value(asked.problem, "energy", y) for y in solution.y]
    np.testing.assert_allclose(energies, gi.value(asked.problem, "energy", asked.state), rtol=1e-13)


@pytest.mark.parametrize(
    ("sections", "purpose", "reason"),
    [
        ({}, "drift", "a drift report is one of steps"),
        ({"observe": {"quantities": ["K"]}}, "run", "are watched after steps"),
        ({"save": {"every": 2}}, "run", "every counts steps"),
        ({**BALL, "initial": SPINNING}, "run", "has one that gives ball"),
        ({"initial": {"gamma": [0.6, 0.0, 0.8], "p": [0.0] * 3}}, "run", "at rest"),
        ({**BALL, "integrate": {"exact": True, "representation": "own"}}, "run", ""),
        ({"time": {"t_end": 1e15}, "integrate": {"step": 1.0, "exact": True}}, "run", "radian"),
    ],
    ids=["drift", "watched", "every", "momentum", "at rest", "lifted", "too late"],
)
def test_where_it_is_not_taken(sections, purpose, reason):
    asked = scene(**sections)
    if purpose == "drift":
        asked = asked.changed_observation(["K"])
    plan = gi.make_plan(asked, purpose)
    taken = plan.exact.chosen is not None
    assert taken == (not reason)
    assert reason in plan.exact.reason
    if not taken:
        assert plan.exact.value == "not taken"
        assert plan.route.asked in asked.model.problems
        assert plan.steps.chosen > 0


def test_without_leave_there_are_steps():
    assert gi.make_plan(scene(integrate={"step": 0.125})).exact is None


def test_times_outside_of_the_run_are_refused():
    save = {"t_eval": [0.1, 5.0]}
    with pytest.raises(gi.DomainError, match="t_eval"):
        gi.make_plan(scene(time={"t_end": 1.0}, save=save))
    later = scene(**IN_TAU, time={"tau_end": 0.1}, save=save)
    assert "t_eval" in gi.make_plan(later).exact.reason


def test_the_plan_travels():
    plan = gi.make_plan(scene(**BALL))
    again = pickle.loads(pickle.dumps(plan))
    assert again == plan
    assert again.solve() == plan.solve()


def test_the_command_says_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.toml").write_text(scene(save={"t_eval": [1.0, 20.0]}).toml(), encoding="utf-8")
    for command in ("check", "run"):
        result = CliRunner().invoke(main, [command, "s.toml"], env={"COLUMNS": "120"})
        assert result.exit_code == 0, result.output
        assert "exact flow" in result.stdout
    assert gi.load(tmp_path / "s.nc").provenance["route"] == "exact flow"
