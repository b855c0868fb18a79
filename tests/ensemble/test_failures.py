"""A member that fails is told with its error, and hurts no other; what is wrong with all is raised."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import henon_heiles
from geomint.run.ensemble import spread

HENON = henon_heiles.problem()
GOOD = np.random.default_rng(3).uniform(-0.2, 0.2, (19, 4))
ESCAPES = np.array([0.0, 40.0, 0.0, 60.0])  # to infinity, in a time of less than 1
GAUSS = gi.Gauss(3, iteration="fixed-point")  # what Newton's method does beyond is not asked here


@pytest.mark.parametrize("which", [(0,), (18,), (3, 4, 11), tuple(range(19))])
@pytest.mark.parametrize("method", ["rk-4", GAUSS])
def test_members_that_fail(method: Any, which: tuple[int, ...]) -> None:
    states = GOOD.copy()
    states[list(which)] = ESCAPES
    asked = {"t_end": 5.0, "step": 0.1, "method": method, "save_every": 2}
    many = gi.solve_ensemble(HENON, states, **asked)
    assert sorted(many.errors) == list(which)
    assert not many.success
    for k in range(len(states)):
        if k not in which:
            assert np.array_equal(many.final[k], gi.solve(HENON, states[k], **asked).y[-1])
            continue
        with pytest.raises(gi.StepError) as alone:
            gi.solve(HENON, states[k], **asked)
        told: Any = many.errors[k]
        assert type(told) is type(alone.value)
        assert (str(told), told.step) == (str(alone.value), alone.value.step)
        n = many.counts[k]
        assert many.status[k] == "failed"
        assert np.array_equal(many.y[k, :n], alone.value.partial.y)
        assert np.isnan(many.y[k, n:]).all()


ASKED: dict[str, dict[str, Any]] = {
    "in lanes": {"method": "rk-4", "step": 0.1},
    "one by one": {"method": "gauss-3", "step": 0.1, "workers": 2},
    "default steps": {"method": "rk-4", "save_every": 4},
    "adaptive": {"method": "dop853-adaptive"},
    "at times": {"method": "rk-4", "step": 0.1, "t_eval": [0.5, 2.0], "observe": ["energy"]},
    "read off": {"method": "rk-4", "step": 0.1, "readings": ["mean:q[0]", gi.Windows("energy", 2)]},
}


@pytest.mark.parametrize(
    ("how", "stored"), [*((how, False) for how in ASKED), ("in lanes", True), ("read off", True)]
)
def test_states_that_are_none_fail_alone(how: str, stored: bool, tmp_path: Path) -> None:
    """NaN and infinity, at both ends and between; in a whole block; others have their bits."""
    asked, which = {**ASKED[how], "t_end": 3.0}, [0, 5, 18, *range(64, 144)]
    states = np.vstack([GOOD] * 8)
    here = gi.solve_ensemble(HENON, states, **asked)
    states[which] = np.nan
    states[5] = [0.1, np.inf, 0.0, 0.0]
    if stored:
        asked["out"] = tmp_path / "many"
        gi.solve_ensemble(HENON, states, **asked)
    many = gi.solve_ensemble(HENON, states, **asked)
    assert sorted(many.errors) == which
    with pytest.raises(gi.DomainError) as alone:
        gi.solve(HENON, states[5], t_end=3.0)
    assert (type(many.errors[5]), str(many.errors[5])) == (type(alone.value), str(alone.value))
    assert (many.status[which] == "failed").all()
    assert np.isnan(many.final[which]).all()
    others = np.setdiff1d(np.arange(len(states)), which)
    assert np.array_equal(many.y[others], here.y[others], equal_nan=True)
    for name, read in here.readings.items():
        assert np.array_equal(many.readings[name][others], read[others])
        assert np.isnan(many.readings[name][which]).all()


def test_states_off_their_sphere_fail_alone() -> None:
    """Those next to it are put back, which one warning says."""
    problem = gi.load_scene("hamiltonized-n3").problem
    states = np.array([problem.random_state(k) for k in range(20)])
    asked = {"tau_end": 1.0, "method": "rk-4", "step": 0.1}
    whole = gi.solve_ensemble(problem, states, **asked)
    states[3] *= 2.0
    many = gi.solve_ensemble(problem, states, **asked)
    assert list(many.errors) == [3]
    assert np.array_equal(np.delete(many.y, 3, 0), np.delete(whole.y, 3, 0))
    states[3], states[5:8, :3] = states[2], states[5:8, :3] * (1.0 + 1e-9)
    with pytest.warns(gi.GeomintWarning, match=r"3 of 20 states were changed; states\[5\]") as told:
        many = gi.solve_ensemble(problem, states, **asked)
    assert len(told) == 1
    assert np.abs((many.states[:, :3] ** 2).sum(axis=1) - 1.0).max() < 1e-15


def test_a_failing_last_step_that_is_cut() -> None:
    """What fails in the last partial step of a vector has no states of its company."""
    states = GOOD.copy()
    states[2] = ESCAPES
    with pytest.warns(gi.GeomintWarning, match="longer than the run"):
        many = gi.solve_ensemble(HENON, states, t_end=0.09, step=0.1, method=GAUSS)
    assert np.isfinite(many.final[[k for k in range(19) if k != 2]]).all()
    assert (many.status == "success").sum() == 19 - len(many.errors)


@gi.field
def singular(params, t, y, out, work):
    out[0] = 1.0 / y[0]
    for i in range(1, 4):
        out[i] = 0.0 * y[i]


@pytest.mark.parametrize("method", ["rk-4", "dop853-adaptive"])
def test_members_without_a_step_of_their_own(method: str) -> None:
    """Where no default step can be had that is told of the member, not raised: first or last."""
    problem = gi.Problem("1/x", (("x", 4),), field=singular)
    for states in ([1.0, 0.0, 2.0], [0.0, 1.0, 2.0], [1.0, 2.0, 0.0], [0.0, 1.0, 2.0, 0.0]):
        begun = np.zeros((len(states), 4))
        begun[:, 0] = states
        many = gi.solve_ensemble(problem, begun, t_end=1.0, method=method)
        assert sorted(many.errors) == np.flatnonzero(begun[:, 0] == 0.0).tolist()
        assert (many.status == "success").sum() == 2
    with pytest.raises(gi.DomainError, match="finite derivative"):
        gi.solve_ensemble(problem, np.zeros((40, 4)), t_end=1.0, method="rk-4")


@gi.field
def out_of_bounds_beyond_10(params, t, y, out, work):
    if y[0] > 10.0:
        out[3] = 0.0
    out[0] = -y[0]


@pytest.mark.parametrize("which", [0, 64, 128])
def test_a_member_that_does_not_fit_hurts_no_other(which: int) -> None:
    """The first of a block, by which its code is prepared."""
    problem = gi.Problem("some fit", (("x", 1),), field=out_of_bounds_beyond_10)
    states = np.linspace(0.1, 1.0, 150)[:, None].copy()
    states[which] = 20.0
    many = gi.solve_ensemble(problem, states, t_end=1.0, step=0.1, method="rk-4", workers=1)
    assert list(many.errors) == [which]
    assert isinstance(many.errors[which], gi.DeclarationError)
    assert (many.status == "success").sum() == 149


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"t_end": None}, "exactly one"),
    ({"method": "cf-4"}, "needs the form"),
    ({"method": "gaus-8"}, "gauss-8"),
    ({"t_end": None, "tau_end": 1.0}, "t_end"),
    ({"step": -0.1}, "step"),
    ({"workers": 0}, "workers"),
    ({"workers": "two"}, "workers"),
    ({"executor": 4}, "executor"),
    ({"save_every": 0}, "save_every"),
    ({"events": "nothing"}, "nothing"),
    ({"observe": ["entropy"]}, "entropy"),
    ({"observe": 0}, "observe"),
    ({"observe_every": 2}, "observe_every"),
    ({"observe_every": 1.0}, "observe_every"),
    ({"observe_every": np.ones(2)}, "observe_every"),
    ({"t_eval": [2.0]}, "t_eval"),
    ({"dt": 0.1}, "step=…"),
    ({"clock": "yes"}, "clock"),
    ({"clock": np.array([1, 0])}, "clock"),
    ({"progress": "yes"}, "progress"),
    ({"estimate_error": 0}, "estimate_error"),
    ({"estimate_error": np.ones(2)}, "estimate_error"),
    # more states than there is room for
    ({"t_end": 1e9, "step": 1e-3, "save_every": 1, "method": "rk-4"}, "saved states"),
    ({"states": GOOD[:, :3]}, "states of 4 numbers"),
    ({"states": np.zeros((0, 4))}, "states of 4 numbers"),
    ({"states": GOOD[None]}, "states of 4 numbers"),
    ({"states": "state"}, "states of 4 numbers"),
    ({"states": np.full((3, 4), np.nan)}, r"states\[0\].*finite"),
    ({"problems": []}, "problems"),
    ({"problems": [HENON, gi.load_scene("hamiltonized-n3").problem]}, "problems"),
    ({"problems": "henon"}, "problems"),
    ({"problems": [HENON, 3]}, "problems"),
    ({"problems": [HENON] * 3}, "one for each problem"),
]


@pytest.mark.parametrize(("wrong", "said"), WRONG)
def test_what_is_wrong_with_all_is_raised(wrong: dict[str, Any], said: str) -> None:
    given = {"problems": HENON, "states": GOOD, "t_end": 1.0, **wrong}
    with pytest.raises(gi.GeomintError, match=said):
        gi.solve_ensemble(given.pop("problems"), given.pop("states"), **given)


def test_calls_are_explained() -> None:
    for given in ((), (HENON,), (HENON, GOOD, 1.0), (lambda t, y: y, GOOD)):
        with pytest.raises(gi.ArgumentError, match=r"geomint.solve_ensemble.*(state|Problem)"):
            gi.solve_ensemble(*given, **({"t_end": 1.0} if len(given) != 3 else {}))


@pytest.mark.parametrize("wanted", [{}, {"observe": ["energy"]}])
def test_ctrl_c_keeps_what_is_done(
    wanted: dict, monkeypatch: pytest.MonkeyPatch, ctrl_c: Any
) -> None:
    """What was computed is at rest; of a member that takes long and is watched nothing is kept."""
    states, calls, run_block = np.repeat(GOOD, 8, axis=0), itertools.count(), spread.run_block
    asked: dict[str, Any] = {"step": 0.01, "method": "rk-4", **wanted}
    gi.solve_ensemble(HENON, states[:2], t_end=1.0, **asked)  # compiled
    alone = gi.solve(HENON, states[0], t_end=4.0, step=0.01, method="rk-4")

    def endless(what: Any, given: Any, stop: Any = None) -> Any:
        if next(calls) == 3:
            ctrl_c()
            what = replace(what, shared={**what.shared, "t_end": 1e7})
        return run_block(what, given, stop)

    monkeypatch.setattr(spread, "run_block", endless)
    monkeypatch.setattr(spread, "LEAST", 1)
    monkeypatch.setattr(spread, "LOOK", 0.01)
    many = gi.solve_ensemble(HENON, states, t_end=4.0, **asked)
    done, left = many.status == "success", many.status == "not run"
    assert left.any()
    assert (done | left | (many.status == "interrupted")).all()
    assert np.isnan(many.y[left]).all()
    assert not many.counts[left].any()
    assert done[0]
    assert np.array_equal(many.final[0], alone.y[-1])


@pytest.mark.parametrize("begin", [0.0, 5.0])
def test_a_step_longer_than_the_run_is_told_once(begin: float) -> None:
    run: dict[str, Any] = {"method": "rk-4", "step": 100.0, "t0": begin, "t_end": begin + 0.5}
    with pytest.warns(gi.GeomintWarning, match="longer than the run") as told:
        gi.solve_ensemble(HENON, 0.1 * np.eye(4), **run)
    assert len(told) == 1
