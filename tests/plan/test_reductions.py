"""What a run may integrate in place of what is asked for: equal answers, and where it must not."""

import pickle

import numpy as np
import pytest

import geomint as gi

night = pytest.mark.nightly
GAMMA, P = [0.5, 0.5, -0.5, 0.5], [1.0, -0.5, 0.25, -0.25]
DIFFERENT, THREE, ALL = [0.7, 0.9, 1.2, 1.4], [0.9, 0.9, 0.9, 1.4], [0.9] * 4


def wedge(x, y):
    """Return the entries of x∧y above the diagonal."""
    product = np.outer(x, y)
    return (product - product.T)[np.triu_indices(len(x), 1)]


CONTENT = {
    "system": {"name": "chaplygin-ball", "a": DIFFERENT, "D": 4.0},
    "initial": {"gamma": GAMMA, "p": P},
    "time": {"t_end": 20.0},
    "integrate": {"step": 0.25},
    "observe": {"quantities": ["energy", "K"]},
    "save": {"every": 7},
}


def scene(name="chaplygin-ball", a=DIFFERENT, **sections):
    return gi.Scene(**{**CONTENT, "system": {"name": name, "a": a, "D": 4.0}, **sections})


def both(asked):
    """Return the plan of a run, and that of the scene's own representation."""
    return gi.make_plan(asked), gi.make_plan(asked.changed_integration(representation="own"))


def assert_equal_answers(asked, expected, atol=1e-13):
    """What is integrated is the cheaper problem; what is handed out is the same."""
    short, plain = both(asked)
    assert short.route.name == expected
    assert short.problem.rows < plain.problem.rows
    assert f"→ {expected}: " in short.representation.reason
    assert f"saved states are those of {plain.route.name} again" in short.representation.reason
    one, other = short.solve(progress=False), plain.solve(progress=False)
    assert one.problem is other.problem
    assert (one.route, other.route) == (expected, "")
    np.testing.assert_allclose(one.tau, other.tau, rtol=1e-14, atol=0.0)
    np.testing.assert_allclose(one.y, other.y, rtol=0.0, atol=atol)
    if one.physical is not None:
        np.testing.assert_allclose(one.t, other.t, rtol=0.0, atol=1e-12)
    for name, drift in one.drift.items():
        assert drift.initial == pytest.approx(other.drift[name].initial, rel=1e-14)
        assert abs(drift.final_error - other.drift[name].final_error) <= 1e-13 * drift.scale
    return one


@pytest.mark.parametrize("save", [{"every": 7}, {"t_eval": [0.1, 20.0]}])
def test_no_momentum(save):
    """Also one within rounding."""
    assert_equal_answers(scene(save=save), "reduced")
    within = scene(initial={"gamma": GAMMA, "k": wedge(GAMMA, P)}, save=save)
    assert gi.make_plan(within).route.name == "reduced"


@pytest.mark.parametrize(
    ("name", "a", "expected"),
    [
        ("chaplygin-ball", THREE, "reduced, n = 3"),
        pytest.param("chaplygin-ball", ALL, "reduced, n = 2", marks=night),
        pytest.param("chaplygin-sphere-reduced", THREE, "reduced, n = 3", marks=night),
        pytest.param("chaplygin-sphere-hamiltonized", THREE, "hamiltonized, n = 3", marks=night),
        pytest.param("veselova", ALL, "reduced, n = 2", marks=night),
    ],
)
def test_equal_parameters(name, a, expected):
    assert_equal_answers(scene(name, a), expected)


@night
def test_a_homogeneous_ball_without_momentum():
    system = {"name": "homogeneous-ball", "n": 4, "s": 1.5, "D": 2.0}
    assert_equal_answers(gi.Scene(**{**CONTENT, "system": system}), "reduced, n = 2")


def test_axes_at_rest():
    initial = {"gamma": [0.6, 0.0, 0.8, 0.0], "p": [0.8, 0.0, -0.6, 0.0]}
    one = assert_equal_answers(scene("chaplygin-sphere-reduced", initial=initial), "reduced, n = 2")
    assert not one.y[:, [1, 3, 5, 7]].any()


def test_two_dimensions():
    initial = {"gamma": [0.6, 0.8], "p": [-0.8, 0.6]}
    asked = scene("chaplygin-sphere-reduced", [0.9, 1.2], initial=initial)
    assert_equal_answers(asked, "ball")
    assert "n = 2: k is constant" in gi.make_plan(asked).representation.reason


@pytest.mark.parametrize(
    "asked",
    [
        scene("chaplygin-sphere-reduced", [0.9, np.nextafter(0.9, 1.0), 0.9, 1.4]),
        scene("chaplygin-sphere-reduced", [0.9, 0.9, 1.2, 1.2]),
        scene("chaplygin-sphere-reduced", ALL, initial={"gamma": GAMMA, "p": [0.0] * 4}),
        scene(initial={"gamma": GAMMA, "k": [1.0, 0.4, -0.3, 0.8, 0.2, -0.6]}),
        scene(initial={"gamma": GAMMA, "k": wedge(GAMMA, P) + 1e-10 * np.eye(6)[0]}),
    ],
    ids=["an ulp apart", "pairs", "at rest", "momentum", "little momentum"],
)
def test_what_cannot_be_reduced(asked):
    """A group of two equal parameters spans a plane already; at rest there is none."""
    plan = gi.make_plan(asked)
    assert plan.route.name == plan.route.asked == next(iter(asked.model.problems))
    assert plan.solve(progress=False).success


@pytest.mark.parametrize("quantity", ["f-1-2", "r1", "measure"])
def test_a_quantity_that_needs_all_axes_keeps_them(quantity):
    """There is an r1 of the smaller problem as well: another one."""
    initial = {"gamma": [*GAMMA, 0.1], "p": [*P, 0.3]}
    a, quantities = [0.9, 0.9, 0.9, 1.2, 1.4], ["energy", quantity]
    with pytest.warns(gi.GeomintWarning):
        asked = scene(
            "chaplygin-sphere-reduced", a, initial=initial, observe={"quantities": quantities}
        )
    (r,) = (r for r in asked.model.reductions if r.of == "reduced")
    assert "r1" in r.problem.invariants
    plan = gi.make_plan(asked)
    assert plan.route.name == "reduced"
    assert f"{quantity} keeps it: else reduced, n = 4 would do" in plan.representation.reason
    assert quantity in plan.watched.chosen


def test_the_constraints_are_those_of_what_is_integrated():
    asked = scene(observe={"quantities": ["energy", "constraints"]})
    assert gi.make_plan(asked).watched.chosen == ("energy", "norm", "tangency")


def test_the_attitude_is_not_lost():
    asked = gi.Scene(**{**CONTENT, "system": {**CONTENT["system"], "attitude": True}})
    assert gi.make_plan(asked).route.name == "ball-attitude"
    assert gi.make_plan(asked, "drift").route.name == "reduced"


def test_the_default_step_is_that_of_what_is_asked_for():
    """Else states after so many steps would be at other times."""
    short, plain = both(scene(integrate={}))
    assert short.route.name != plain.route.name
    assert short.step == plain.step
    times = [p.solve(progress=False).t for p in (short, plain)]
    np.testing.assert_array_equal(*times)


ADAPTIVE = {"method": "dop853-adaptive", "rtol": 1e-12, "atol": 1e-14}


def test_steps_of_an_adaptive_method_are_its_own():
    assert gi.make_plan(scene(integrate=ADAPTIVE)).route.name == "ball"
    at_times = scene(integrate=ADAPTIVE, save={"t_eval": [3.0]})
    assert gi.make_plan(at_times).route.name == "reduced"


@night
def test_states_by_an_adaptive_method_are_those_of_the_whole():
    assert_equal_answers(scene(integrate=ADAPTIVE, save={"t_eval": [3.0]}), "reduced", 1e-9)


def test_what_a_failed_run_has_is_handed_out_as_asked():
    asked = scene(integrate={"step": 3.0, "max_iterations": 9, "iteration": "fixed-point"})
    with pytest.raises(gi.ConvergenceError) as raised:
        gi.make_plan(asked).solve(progress=False)
    assert raised.value.partial.y.shape[1] == asked.problem.rows


def test_a_drift_report_is_of_what_was_integrated():
    solution = gi.make_plan(scene(a=THREE), "drift").solve(progress=False)
    assert solution.y.shape == (1, 6)
    assert solution.route == ""


def test_reductions_travel():
    plan = gi.make_plan(scene(a=THREE))
    again = pickle.loads(pickle.dumps(plan))
    assert again == plan
    y = np.arange(12.0).reshape(2, 6)
    np.testing.assert_array_equal(again.route.lift(y), plan.route.lift(y))


def test_the_reductions_of_built_in_scenes_start_at_their_state():
    models = [gi.load_scene(name).model for name in gi.scene_names()]
    for model, r in [(m, r) for m in models for r in m.reductions]:
        lifted = r.lift(r.state[None, :])[0]
        np.testing.assert_allclose(lifted, model.states[r.of], rtol=0.0, atol=1e-14)
        assert r.problem.time == model.problems[r.of].time
