"""The planner's rule for representations: what it chooses, says, and that it changes no answer."""

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.plan.cost import Cost, cost_of
from tests.problems import toda

FREE = {  # no SO(n−1)-momentum: the ball has a reduction to T*S^(n−1)
    "system": {"name": "chaplygin-ball", "a": [0.7, 0.9, 1.2, 1.4], "D": 4.0, "attitude": True},
    "initial": {"gamma": [0.5, 0.5, -0.5, 0.5], "p": [1.0, -0.5, 0.25, -0.25]},
    "time": {"t_end": 20.0},
    "integrate": {"method": "gauss-8", "step": 0.25},
    "observe": {"quantities": ["energy", "K"]},
}
SPINNING = {
    **FREE,
    "initial": {"gamma": [0.5, 0.5, -0.5, 0.5], "k": [1.0, 0.4, -0.3, 0.8, 0.2, -0.6]},
}


def choice(scene, purpose="drift"):
    return gi.make_plan(scene, purpose).representation


def changed(content, **sections):
    return gi.Scene(**{**content, **sections})


def test_no_momentum_leads_to_the_sphere():
    chosen = choice(gi.Scene(**FREE))
    assert chosen.chosen.name == "reduced"
    assert chosen.reason.startswith(
        "ball-attitude → reduced: no SO(n−1)-momentum, nothing observed"
    )
    assert "needs k or g: 8 numbers instead of 26" in chosen.reason


def test_the_attitude_is_left_out():
    chosen = choice(gi.Scene(**SPINNING))
    assert chosen.chosen.name == "ball"
    assert "nothing observed needs g: 10 numbers instead of 26" in chosen.reason
    assert "momentum," not in chosen.reason
    group = changed(FREE, integrate={"method": "cf-4", "step": 0.25})
    assert choice(group).chosen.name == "reduced"  # SO(n) acts on T*S^(n−1) too


@pytest.mark.parametrize("quantity", ["spatial-momentum", "orthogonality", "momentum", "measure"])
def test_what_is_observed_keeps_what_it_needs(quantity):
    scene = changed(FREE, observe={"quantities": ["energy", quantity]})
    chosen = choice(scene)
    assert chosen.chosen.name == ("ball" if quantity == "momentum" else "ball-attitude")
    assert f"{quantity} keeps it: else" in chosen.reason or quantity == "momentum"
    assert quantity in gi.make_plan(scene, "drift").watched.chosen


def test_a_quantity_of_a_larger_representation_is_a_reason_for_it():
    scene = changed(
        SPINNING,
        system={**SPINNING["system"], "attitude": False},
        observe={"quantities": ["energy", "orthogonality"]},
    )
    for purpose in ("run", "drift"):
        chosen = choice(scene, purpose)
        assert chosen.chosen.name == "ball-attitude"
        assert "ball: has no orthogonality" in chosen.reason


def test_the_group_of_constraints_is_that_of_what_is_integrated():
    scene = changed(FREE, observe={"quantities": ["energy", "constraints"]})
    plan = gi.make_plan(scene, "drift")
    assert plan.route.name == "reduced"
    assert plan.watched.chosen == ("energy", "norm", "tangency")
    # Invariants are none of a representation, but of the motion: none may get lost.
    assert choice(changed(FREE, observe={"quantities": ["invariants"]})).chosen.name == "ball"


def test_a_run_keeps_the_representation_in_which_its_states_are_wanted():
    plan = gi.make_plan(gi.Scene(**FREE), "run")
    assert plan.route.name == "ball-attitude"
    assert plan.problem.rows == 26


def test_the_time_is_never_changed():
    """The Hamiltonised sphere is the cheapest of all, but another flow: symplectic in τ."""
    scenes = [gi.load_scene(name) for name in ("hamiltonized-n3", "sphere-n5")]
    for scene in (*scenes, gi.Scene(**FREE)):
        plan = gi.make_plan(scene.changed(observe={"quantities": ["energy"]}), "drift")
        assert plan.problem.time == scene.problem.time


def test_forcing_a_representation():
    scene = gi.Scene(**FREE)
    own = scene.changed_integration(representation="own")
    assert choice(own).chosen.name == "ball-attitude"
    assert choice(own).reason == "[integrate] representation = 'own'"
    assert choice(scene.changed_integration(representation="hamiltonized"), "run").chosen.name == (
        "hamiltonized"
    )
    assert scene.hash != own.hash
    with pytest.raises(gi.FormError, match=r"'reduced'.*no form 'hamiltonian'.*gauss-8"):
        choice(scene.changed_integration("rattle-4", representation="reduced"))
    with pytest.raises(gi.SceneError, match="Did you mean 'reduced'"):
        scene.changed_integration(representation="redused")
    missing = changed(FREE, observe={"quantities": ["momentum"]})
    with pytest.raises(gi.FormError, match="has no momentum"):
        choice(missing.changed_integration(representation="reduced"), "run")


def test_a_drift_report_does_without_what_no_representation_has():
    scene = changed(
        FREE,
        observe={"quantities": ["energy", "momentum", "spatial-momentum"]},
        integrate={"method": "rattle-4", "step": 0.05},
    )
    with pytest.raises(gi.FormError, match="has no momentum"):
        gi.make_plan(scene, "run")
    plan = gi.make_plan(scene, "drift")
    assert plan.route.name == "hamiltonized"
    assert plan.missing.chosen == ("momentum", "spatial-momentum")
    assert plan.missing.reason.endswith("; only in ball-attitude")
    assert plan.watched.chosen == ("energy",)


@pytest.mark.parametrize(
    ("content", "method"),
    [
        (FREE, "gauss-8"),
        (SPINNING, "cf-4"),
        pytest.param(SPINNING, "gauss-8", marks=pytest.mark.nightly),
        pytest.param(FREE, "cf-4", marks=pytest.mark.nightly),
    ],
)
def test_the_plain_way_gives_the_same(content, method):
    step = 0.25 if method == "gauss-8" else 0.01
    scene = changed(content, integrate={"method": method, "step": step})
    short = gi.make_plan(scene, "drift")
    plain = gi.make_plan(scene.changed_integration(representation="own"), "drift")
    assert short.problem.rows < plain.problem.rows
    one, other = short.solve(progress=False), plain.solve(progress=False)
    states = [s.problem.physical_state(s.y[-1]) for s in (one, other)]
    for name in ("gamma", "k"):
        np.testing.assert_allclose(states[0][name], states[1][name], atol=1e-12)
    for name, drift in one.drift.items():
        same = other.drift[name]
        assert drift.initial == pytest.approx(same.initial, rel=1e-14)
        assert abs(drift.final_error - same.final_error) <= 1e-13 * drift.scale
        if not drift.within_roundoff:  # other roundings, another random walk
            assert drift.drift_class == same.drift_class
        assert same.within_roundoff == drift.within_roundoff


def test_leaving_the_attitude_out_changes_no_bit_of_the_rest():
    scene = changed(SPINNING, integrate={"method": "cf-4", "step": 0.25})
    short = gi.make_plan(scene, "drift").solve(progress=False)
    own = scene.changed_integration(representation="own")
    plain = gi.make_plan(own, "drift").solve(progress=False)
    np.testing.assert_array_equal(short.y[-1], plain.y[-1][: short.problem.rows])
    assert short.drift["energy"].max_abs_error == plain.drift["energy"].max_abs_error


@pytest.mark.parametrize("name", gi.scene_names())
def test_forms_of_built_in_scenes(name):
    """Quantities of a name are the same number in all, where constraints vanish.

    Each scene observes what its own representation is for, and so keeps it.
    """
    scene = gi.load_scene(name)
    model = scene.model
    assert choice(scene.for_drift()).chosen.name == next(iter(model.problems))
    first: dict[str, float] = {}
    for key, problem in model.problems.items():
        y = model.states[key]
        for quantity, f in problem.invariants.items():
            found = gi.value(problem, f, y)
            expected = first.setdefault(quantity, found)
            assert found == pytest.approx(expected, rel=1e-12, abs=1e-13), (key, quantity)
        for quantity, f in problem.constraints.items():
            assert abs(gi.value(problem, f, y)) < 1e-12, (key, quantity)


def test_costs_are_counted():
    @gi.field
    def oscillator(params, t, y, out, work):
        out[0] = 2.0 * y[1] + 1.0
        out[1] = -params[0] * gi.sin(y[0]) / y[1]

    problem = gi.Problem(name="some", pieces=(("q", 1), ("v", 1)), params=[3.0], field=oscillator)
    assert cost_of(problem, "field", np.array([0.5, 2.0])) == Cost(2, 5)
    assert cost_of(problem, "field", np.zeros(2)) == Cost(2, 5)
    lattice = toda.problem(3)  # a difference, a product and exp a spring; differences of forces
    assert cost_of(lattice, "field", toda.initial(3)) == Cost(6, 3 + 4 * 3 + 3)


def test_costs_do_not_depend_on_the_state_and_grow_with_the_dimension():
    def cost(n, form):
        rng = np.random.default_rng(n)
        gamma, p = rng.normal(size=(2, n))
        gamma /= np.linalg.norm(gamma)
        p -= gamma * (gamma @ p)
        scene = gi.Scene(
            system={"name": "chaplygin-ball", "a": list(rng.uniform(0.5, 1.5, n)), "D": 4.0},
            initial={"gamma": gamma, "p": p},
            time={"t_end": 1.0},
        )
        name = "reduced" if form == "field" else "ball"
        return cost_of(scene.model.problems[name], form, scene.model.states[name])

    fields = [cost(n, "field").operations for n in (4, 5, 6, 7)]
    assert len(set(np.diff(fields))) == 1  # O(n)
    assert cost(6, "action").operations > cost(5, "action").operations


def test_a_small_gain_is_not_worth_another_formulation():
    assert Cost(8, 100).below(Cost(10, 100))
    assert not Cost(9, 100).below(Cost(10, 100))
    assert not Cost(8, 101).below(Cost(10, 100))


def test_what_overflows_has_a_cost():
    """Operations are counted where numbers are not finite too: a run says what that means."""
    sphere = ch.ChaplyginSphere.from_moments([1.0, 1.5, 2.0], 1.2, 1.0)
    problem, common = sphere.poisson(), {"gamma": [0.48, 0.6, 0.64]}
    large, usual = (problem.state(**common, k=[1.0, -0.5, k]) for k in (8e208, 0.5))
    least = cost_of(problem, "action", usual).operations
    assert cost_of(problem, "action", large).operations >= least > 0
