"""Plans: what they choose, what they say, and that they do not change the answer."""

import numpy as np
import pytest

import geomint as gi

REDUCED = {
    "system": {"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.6, 0.0, 0.8], "p": [0.8, 1.0, -0.6]},
    "time": {"t_end": 2.0},
    "observe": {"quantities": ["energy", "K", "tangency"]},
}
HAMILTONIZED = {
    **REDUCED,
    "system": {**REDUCED["system"], "name": "chaplygin-sphere-hamiltonized"},
    "time": {"tau_end": 2.0},
    "integrate": {"step": 0.125},
}


def plan(scene, purpose="run", costs=True):
    return gi.make_plan(scene, purpose, costs)


def test_every_choice_has_a_reason():
    for i, name in enumerate(gi.scene_names()):
        found = plan(gi.load_scene(name), ("run", "drift")[i % 2], costs=i % 8 == 0)
        assert all(choice.what and choice.value and choice.reason for choice in found.choices)


def test_the_own_representation_unless_the_method_needs_another():
    own = gi.make_plan(gi.Scene(**REDUCED))
    assert own.route.name == "reduced"
    other = gi.make_plan(gi.Scene(**REDUCED, integrate={"method": "rattle-4"}))
    assert other.route.name == "hamiltonized"
    assert "no form 'hamiltonian'" in other.representation.reason
    group = gi.make_plan(gi.Scene(**REDUCED, integrate={"method": "cf-4"}))
    assert "action" in group.problem.forms


def test_constraints_of_another_representation_are_its_own():
    """As a group; one that is named is meant itself, and a representation without it does not serve."""
    integrate = {"method": "cf-4", "representation": "classical"}
    named = gi.Scene(**REDUCED, integrate=integrate)
    for group in (["energy", "K", "constraints"], ["all"]):
        watched = plan(named.changed_observation(group)).watched.chosen
        assert watched[:2] == ("energy", "K")
        assert "norm" in watched
        assert "tangency" not in watched
    has = r"'classical'.*has no tangency\. It has energy, K, .*norm"
    with pytest.raises(gi.FormError, match=has):
        gi.make_plan(named)
    told = plan(named, "drift")
    assert told.watched.chosen == ("energy", "K")
    assert told.missing.chosen == ("tangency",)
    assert told.notes[0].startswith("not watched: tangency: classical has")


def test_a_wrong_pair_is_refused_with_what_would_fit():
    scene = gi.load_scene("ball-3d").changed_integration("rattle-4")
    with pytest.raises(gi.FormError, match=r"no form 'hamiltonian'.*cf-4"):
        gi.make_plan(scene)
    scene = gi.Scene(**{**HAMILTONIZED, "integrate": {"method": "cf-4"}})
    with pytest.raises(gi.FormError, match="give t_end"):
        gi.make_plan(scene)


def test_nothing_is_done_that_is_not_needed():
    scene = gi.Scene(**HAMILTONIZED)
    assert plan(scene, "run").clock.chosen
    assert not plan(scene, "drift").clock.chosen
    assert plan(scene.changed(time={"t_end": 2.0}), "drift").clock.chosen
    asked = scene.changed(events={name: {"what": "gamma[2]"} for name in ("one", "other")})
    assert (plan(asked).events.chosen, plan(asked).events.value) == (("one", "other"), "one, other")
    for purpose in ("run", "drift"):
        assert plan(scene.changed_observation([]), purpose).watched.value == "nothing"


def test_the_step_is_told_with_its_source():
    scene = gi.Scene(**REDUCED, integrate={"step": 0.3})
    told = plan(scene)
    assert told.step.value == "0.3 in t"
    assert told.step.chosen == 0.3
    assert told.steps.value.startswith("6 and a last one of 0.2")
    assert told.steps.chosen == 6
    assert "default: 0.6 (for gauss-8)" in plan(gi.Scene(**REDUCED)).step.reason


def test_estimates_are_near_what_a_run_does():
    for method in ("gauss-8", "rattle-4"):
        scene = gi.Scene(**{**HAMILTONIZED, "integrate": {"method": method, "step": 0.05}})
        told = plan(scene)
        solution = told.solve(progress=False)
        assert told.steps.chosen == solution.steps
        assert 0.7 < told.evaluations.chosen / solution.evaluations < 1.5


def test_a_step_that_is_too_large_is_foretold():
    given = {"step": 50.0, "method": "gauss-8", "iteration": "fixed-point"}
    told = plan(gi.Scene(**REDUCED, integrate=given)).evaluations
    assert told.value == "the run will fail"
    assert "did not converge" in told.reason


@pytest.mark.parametrize("options", [{}, {"max_iterations": 10**6}, {"iteration": "newton"}])
def test_a_step_for_newtons_method_is_not_tried(options):
    """It would take minutes in plain Python, and so would a million iterations."""
    given = {"method": "gauss-8", "step": 1e6, **options}
    told = plan(gi.Scene(**{**HAMILTONIZED, "integrate": given})).evaluations
    assert (told.value, told.chosen) == ("not known", None)
    assert ("the step is too long" in told.reason) == ("iteration" not in options)


@pytest.mark.parametrize("save", [{}, {"every": 3}, {"t_eval": [0.1, 0.7, 2.0]}])
@pytest.mark.parametrize("content", [REDUCED, HAMILTONIZED])
def test_a_plan_does_not_change_the_answer(content, save):
    scene = gi.Scene(**content, save=save)
    solution = gi.run_scene(scene, progress=False)
    time = scene.content.time
    plain = gi.solve(
        scene.problem, scene.state, t_end=time.t_end, tau_end=time.tau_end,
        step=scene.content.integrate.step, save_every=save.get("every"), t_eval=save.get("t_eval"),
        observe=["invariants", "constraints"], clock=True if scene.problem.time == "tau" else None,
        progress=False,
    )  # fmt: skip
    np.testing.assert_array_equal(solution.y, plain.y)
    np.testing.assert_array_equal(solution.t, plain.t)
    for name, drift in solution.drift.items():
        assert drift.max_abs_error == plain.drift[name].max_abs_error


def test_leaving_the_clock_out_does_not_change_the_states():
    scene = gi.Scene(**HAMILTONIZED)
    run = gi.make_plan(scene, "run").solve(progress=False)
    drift = gi.make_plan(scene, "drift").solve(progress=False)
    assert drift.physical is None
    np.testing.assert_array_equal(run.y, drift.y)


def test_representations_agree_at_the_same_physical_time():
    results = []
    for method in ("gauss-8", "rattle-4"):
        scene = gi.Scene(**REDUCED, integrate={"method": method, "step": 0.002})
        solution = gi.run_scene(scene, progress=False)
        results.append(solution.problem.physical_state(solution.y[-1])["gamma"])
    np.testing.assert_allclose(*results, atol=1e-9)


def test_purposes_are_checked():
    with pytest.raises(gi.DomainError, match="purpose"):
        gi.make_plan(gi.Scene(**REDUCED), "dance")


def test_an_adaptive_method_says_what_decides_its_steps():
    integrate = {"method": "dop853-adaptive", "rtol": 1e-9, "max_step": 0.5}
    told = plan(gi.Scene(**REDUCED, integrate=integrate))
    assert told.step.value.startswith("adaptive, rtol 1e-09, atol 1e-12, none above 0.5; the")
    assert "an estimate at the initial state" in told.step.reason
    assert "as many as" in told.steps.value
    assert "end at t = 2," in told.steps.reason
    assert "12 a step" in told.evaluations.value
    given = plan(gi.Scene(**REDUCED, integrate={**integrate, "step": 0.25}))
    assert "the first 0.25 in t" in given.step.value
    assert "[integrate] step" in given.step.reason
    physical = gi.Scene(**{**HAMILTONIZED, "time": {"t_end": 1.0}, "integrate": integrate})
    assert "end at t = 1," in plan(physical).steps.reason


@pytest.mark.nightly
def test_an_adaptive_plan_gives_what_solve_gives():
    scene = gi.Scene(**REDUCED, integrate={"method": "dop853-adaptive", "rtol": 1e-10})
    planned = gi.make_plan(scene).solve(progress=False)
    method = gi.Adaptive(gi.RungeKutta("dop853"), rtol=1e-10)
    plain = gi.solve(scene.problem, scene.state, t_end=2.0, method=method)
    np.testing.assert_array_equal(planned.y[-1], plain.y[-1])
