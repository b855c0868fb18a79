"""Members have the bits of their single runs: whatever method, lanes, company, order and cores."""

from __future__ import annotations

import functools
import warnings
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import henon_heiles, pulsating_body
from geomint.run.ensemble import compiled

HENON = henon_heiles.problem()
STATES = np.random.default_rng(7).uniform(-0.2, 0.2, (21, 4))

LANES = ("rk-4", "dop853", "cf-4", "cg-3", "rkmk-4", "rkmk-cayley-4", "verlet-2", "verlet-6")
ALONE = ("gauss-2", "gauss-8", "rattle-2", "lobatto-4", "gauss-1-suzuki-4")
FAST = {  # most kinds of method once: others run at night; on groups see the times of members
    "hamiltonized-n3": ("rk-4", "rattle-2", "gauss-8"),
    "neumann-n3": ("verlet-2",),
}
SLOW = ("sphere-n3", "ball-poisson", "veselova-n4", "rolling-ball-n3", "neumann-n3", "ball-3d")
PAIRS = [
    *((scene, name) for scene, names in FAST.items() for name in names),
    pytest.param("hamiltonized-n3", "verlet-2", marks=pytest.mark.nightly),
    *(
        pytest.param(scene, name, marks=pytest.mark.nightly)
        for scene in SLOW
        for name in (*LANES, *ALONE)
        if gi.find_method(name).needs in gi.load_scene(scene).problem.forms
        and name not in FAST.get(scene, ())
    ),
]


@functools.cache
def members(scene: str, count: int) -> tuple[gi.Problem, np.ndarray]:
    """Return a scene's problem and states: random ones, one with small momenta, one at its end."""
    loaded = gi.load_scene(scene)
    problem = loaded.problem
    states = [problem.random_state(seed) for seed in range(count - 1)]
    return problem, np.array([*states, loaded.state])


def same(many: gi.Ensemble, k: int, alone: gi.Solution) -> bool:
    """Tell whether a member has the bits of its single run."""
    n = many.counts[k]
    pairs = [(many.tau[k, :n], alone.tau), (many.y[k, :n], alone.y)]
    if alone.physical is not None:
        pairs.append((many.found.physical[k, :n], alone.physical))
    assert np.isnan(many.tau[k, n:]).all()
    assert np.isnan(many.y[k, n:]).all()
    equal = all(np.array_equal(a, b) for a, b in pairs)
    return equal and many.steps[k] == alone.steps and many.status[k] == alone.status


def quiet(function: Any, *given: Any, **named: Any) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gi.GeomintWarning)
        return function(*given, **named)


@pytest.mark.parametrize(("scene", "name"), PAIRS)
def test_bits_are_those_of_single_runs(scene: str, name: str) -> None:
    problem, states = members(scene, 11)
    end = "tau_end" if problem.time == "tau" else "t_end"
    asked = {end: 1.03, "method": name, "step": 0.05, "save_every": 4}
    many = gi.solve_ensemble(problem, states, **asked)
    assert many.success
    assert all(same(many, k, gi.solve(problem, states[k], **asked)) for k in range(len(states)))


WAYS = {
    "a whole number of steps": {"t_end": 2.0, "step": 0.1},
    "a last step that is cut": {"t_end": 2.03, "step": 0.1},
    "nothing but a step that is cut": {"t_end": 0.1, "step": 0.25},
    "one step": {"t_end": 0.25, "step": 0.25, "save_every": 1},
    "own steps": {"t_end": 2.0},
    "own steps, saved": {"t_end": 2.0, "save_every": 7},
    "every step": {"t_end": 1.0, "step": 0.1, "save_every": 1},
    "fewer steps than between saves": {"t_end": 1.0, "step": 0.1, "save_every": 100},
    "backwards": {"t_end": -1.0, "step": 0.3, "save_every": 2},
    "from another time": {"t0": 5.0, "t_end": 6.55, "step": 0.1, "save_every": 3},
    "many saves": {"t_end": 500.0, "step": 0.1, "save_every": 5000},
}


@pytest.mark.parametrize("name", ["rk-4", "gauss-3"])
@pytest.mark.parametrize("way", WAYS)
def test_ends_and_saves(name: str, way: str) -> None:
    many = quiet(gi.solve_ensemble, HENON, STATES, method=name, **WAYS[way])
    for k in range(0, len(STATES), 4):
        assert same(many, k, quiet(gi.solve, HENON, STATES[k], method=name, **WAYS[way]))


@pytest.mark.parametrize("workers", [1, 3])
def test_company_and_order_do_not_matter(workers: int) -> None:
    asked = {"t_end": 20.0, "method": "rk-4", "workers": workers}
    rng = np.random.default_rng(workers)
    states = rng.uniform(-0.25, 0.25, (300, 4))
    order = rng.permutation(len(states))
    all_of_them = gi.solve_ensemble(HENON, states, **asked)
    assert np.array_equal(
        all_of_them.final[order], gi.solve_ensemble(HENON, states[order], **asked).final
    )
    few = gi.solve_ensemble(HENON, states[order[:3]], **asked)
    assert np.array_equal(all_of_them.final[order[:3]], few.final)


def test_time_is_that_of_each_member() -> None:
    """A field that depends on time, members whose steps differ; one state for several problems."""
    problem, y0 = pulsating_body.problem(), np.asarray(pulsating_body.INITIAL)
    asked = {"t0": 0.3, "t_end": 2.0, "method": "cf-4"}
    for problems, states in ((problem, np.array([y0] * 3)), ([problem] * 3, y0)):
        many = gi.solve_ensemble(problems, states, **asked)
        assert same(many, 1, gi.solve(problem, y0, **asked))
        assert np.array_equal(many.final[0], many.final[2])


def spheres(count: int) -> tuple[list[gi.Problem], np.ndarray]:
    chosen = [
        ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=3.0 + 0.25 * k).hamiltonized() for k in range(count)
    ]
    return chosen, np.array([problem.random_state(k) for k, problem in enumerate(chosen)])


@pytest.mark.parametrize("name", ["rk-4", "gauss-8"])
def test_parameters_of_each_member(name: str) -> None:
    chosen, states = spheres(10)
    many = gi.solve_ensemble(chosen, states, tau_end=3.1, step=0.1, method=name)
    for k, problem in enumerate(chosen):
        alone = gi.solve(problem, states[k], tau_end=3.1, step=0.1, method=name)
        assert same(many, k, alone)
    assert len({float(y) for y in many.final[:, 0]}) == 10


@gi.field
def counts_with_it(params, t, y, out, work):
    for i in range(int(params[0])):
        out[i] = -params[1] * y[i]


@gi.field
def branches(params, t, y, out, work):
    out[0], out[1] = (-y[0] if y[0] > 0.5 else -2.0 * y[0]), 0.0


def test_fields_that_take_one_number_at_a_time() -> None:
    """Whole numbers among parameters, branches: compiled code, but no lanes."""
    states = np.linspace(0.1, 1.0, 18).reshape(9, 2)
    run = {"t_end": 1.0, "method": "rk-4", "step": 0.1}
    for field in (counts_with_it, branches):
        chosen = [gi.Problem("c", (("x", 2),), params=[2.0, k], field=field) for k in range(9)]
        many = gi.solve_ensemble(chosen, states, **run)
        assert all(same(many, k, gi.solve(chosen[k], states[k], **run)) for k in range(9))


def test_lanes_are_used(monkeypatch: pytest.MonkeyPatch) -> None:
    """What these tests are about: the vector's own code, not that of single numbers."""
    call_of, seen = compiled._call_of, []
    chosen, states = spheres(3)

    def noted(*given: Any) -> Any:
        call = call_of(*given)
        seen.append(type(call.given("memory")).__name__)
        return call

    monkeypatch.setattr(compiled, "_call_of", noted)
    gi.solve_ensemble(HENON, STATES, t_end=1.0, method="rk-4")
    gi.solve_ensemble(chosen, states, tau_end=1.0, method="rk-4")
    gi.solve_ensemble(HENON, STATES, t_end=1.0, method="gauss-3")
    assert [*dict.fromkeys(seen)] == ["LaneBlock", "Block"]
