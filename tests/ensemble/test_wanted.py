"""What is wanted beside states after steps: as of single runs, with an axis of members."""

from __future__ import annotations

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi

SCENE = gi.load_scene("hamiltonized-n3")
PROBLEM = SCENE.problem
STATES = np.array([PROBLEM.random_state(seed) for seed in range(5)])

ASKED = {
    "states at physical times": {"t_end": 4.0, "t_eval": [0.0, 1.0, 4.0]},
    "states at times of its own": {"tau_end": 4.0, "tau_eval": np.linspace(0.5, 4.0, 4)},
    "an end in physical time": {"t_end": 4.0, "save_every": 3},
    "events": {"tau_end": 8.0, "events": {"up": gi.Event("gamma[2]", direction=1)}},
    "quantities": {"tau_end": 8.0, "observe": ["energy", "K"], "observe_every": 2},
    "adaptive steps": {"tau_end": 4.0, "method": "dop853-adaptive", "save_every": 1},
    "the exact flow": {"tau_end": 4.0, "tau_eval": [1.0, 3.0], "method": "exact"},
    "errors": {"tau_end": 4.0, "method": "rk-4", "estimate_error": True},
    "no clock": {"tau_end": 4.0, "method": "rk-4", "clock": False},
}


@pytest.mark.parametrize("what", ASKED)
def test_as_of_single_runs(what: str) -> None:
    asked = ASKED[what]
    many = gi.solve_ensemble(PROBLEM, STATES, **asked)
    for k, state in enumerate(STATES):
        alone = gi.solve(PROBLEM, state, **asked)
        n = len(alone.tau)
        assert many.counts[k] == n
        assert np.array_equal(many.tau[k, :n], alone.tau)
        assert np.array_equal(many.y[k, :n], alone.y)
        if alone.physical is not None:
            assert np.array_equal(many.t[k, :n], alone.t)
        for name, drift in alone.drift.items():
            assert many.drift[name]["max_abs_error"][k] == drift.max_abs_error
            assert many.drift[name]["class"][k] == drift.drift_class
        for name, met in alone.events.items():
            assert np.array_equal(many.events[name][k].y, met.y)
        if alone.error_estimate is not None:
            assert many.error_estimate is not None
            assert np.array_equal(many.error_estimate[k, :n], alone.error_estimate)


def test_pieces_names_and_one_member_alone() -> None:
    run = {"tau_end": 1.0, "method": "rk-4", "step": 0.1, "save_every": 5, "clock": False}
    many = gi.solve_ensemble(PROBLEM, STATES, **run)
    alone = many.single(3, dense=True)
    assert np.array_equal(alone.y[-1], many.final[3])
    assert np.array_equal(alone.sol(tau=1.0), many.final[3])
    assert many.piece("gamma").shape == (5, 3, 3)
    assert len(many) == 5
    assert "ensemble of 5" in repr(many)
    for ask, said in (
        (lambda: many.single(5), "member"),
        (lambda: many.piece("nothing"), "piece"),
        (lambda: many.t, "clock"),
    ):
        with pytest.raises(gi.DomainError, match=said):
            ask()


def test_as_a_dataset() -> None:
    chosen = [ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=d).hamiltonized() for d in (3.0, 4.0)]
    many = gi.solve_ensemble(chosen, STATES[0], tau_end=2.0, step=0.1, save_every=7, observe=["K"])
    data = many.to_xarray()
    assert dict(data.sizes) == {"member": 2, "sample": 4, "gamma_0": 3, "p_tilde_0": 3}
    assert np.array_equal(data.gamma.values, many.piece("gamma"))
    assert list(data.D.values) == [3.0, 4.0]
    assert data.K_max_abs_error.dims == ("member",)
    assert set(data.coords) == {"tau", "t"}


@gi.field
def turning(params, t, y, out, work):
    out[0], out[1] = -y[1], y[0]


@pytest.mark.parametrize("name", ["steps", "status", "member", "sample", "tau", "t", "x_0"])
def test_names_of_a_dataset_are_not_those_of_others(name: str) -> None:
    problem = gi.Problem("turning", (("x", 1), (name, 1)), field=turning)
    many = gi.solve_ensemble(problem, np.ones((3, 2)), t_end=1.0, step=0.1, method="rk-4")
    data = many.to_xarray()
    assert np.array_equal(data[f"{name}_"].values.ravel(), many.piece(name).ravel())
    assert {"x", f"{name}_", "steps", "status", "warnings"} >= set(data.data_vars)
    assert list(data.steps.values) == [10] * 3
    assert list(data.status.values) == ["success"] * 3


def test_names_that_can_be_read_once() -> None:
    many = gi.solve_ensemble(PROBLEM, STATES, tau_end=1.0, observe=iter(["energy"]))
    assert np.isfinite(many.drift["energy"]["max_abs_error"]).all()
    names = np.array(["energy", "K"])
    many = gi.solve_ensemble(PROBLEM, STATES, tau_end=1.0, observe=names)
    assert set(many.drift) == {"energy", "K"}
