"""A member that fails is told with its error, and hurts no other; what is wrong with all is raised."""

from __future__ import annotations

import itertools
import os
import pickle
import subprocess
import sys
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


def with_some_that_fail(which: tuple[int, ...]) -> np.ndarray:
    states = GOOD.copy()
    states[list(which)] = ESCAPES
    return states


@pytest.mark.parametrize("which", [(0,), (18,), (3, 4, 11), tuple(range(19))])
@pytest.mark.parametrize("name", ["rk-4", "gauss-3"])
def test_members_that_fail(name: str, which: tuple[int, ...]) -> None:
    states = with_some_that_fail(which)
    asked = {"t_end": 5.0, "step": 0.1, "method": name, "save_every": 2}
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
        assert (type(told), str(told), told.step) == (
            type(alone.value),
            str(alone.value),
            alone.value.step,
        )
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


@pytest.mark.nightly
def test_without_compiler() -> None:
    """An ensemble in plain Python has the bits of the compiled one."""
    code = (
        "import numpy as np, geomint as gi\n"
        "from geomint.problems.testproblems import henon_heiles\n"
        "many = gi.solve_ensemble(henon_heiles.problem(), 0.1 * np.eye(4), t_end=0.35, step=0.1,"
        " method='rk-4')\n"
        "print(many.final.tobytes().hex())"
    )
    run = [sys.executable, "-c", code]
    runs = [
        subprocess.run(
            run, env={**os.environ, "NUMBA_DISABLE_JIT": off}, capture_output=True, check=True
        ).stdout
        for off in "01"
    ]
    assert runs[0] == runs[1] != b""


def test_a_failing_last_step_that_is_cut() -> None:
    """What fails in the last partial step of a vector has no states of its company."""
    states = with_some_that_fail((2,))
    with pytest.warns(gi.GeomintWarning, match="longer than the run"):
        many = gi.solve_ensemble(HENON, states, t_end=0.09, step=0.1, method="gauss-3")
    assert np.isfinite(many.final[[k for k in range(19) if k != 2]]).all()
    assert (many.status == "success").sum() == 19 - len(many.errors)


@gi.field
def singular(params, t, y, out, work):
    out[0] = 1.0 / y[0]


@pytest.mark.parametrize("method", ["rk-4", "dop853-adaptive"])
def test_members_without_a_step_of_their_own(method: str) -> None:
    """Where no default step can be had that is told of the member, not raised: first or last."""
    problem = gi.Problem("1/x", (("x", 1),), field=singular)
    for states in ([1.0, 0.0, 2.0], [0.0, 1.0, 2.0], [1.0, 2.0, 0.0], [0.0, 1.0, 2.0, 0.0]):
        begun = np.array(states)[:, None]
        many = gi.solve_ensemble(problem, begun, t_end=1.0, method=method)
        assert sorted(many.errors) == np.flatnonzero(begun == 0.0).tolist()
        assert (many.status == "success").sum() == 2
    with pytest.raises(gi.DomainError, match="finite derivative"):
        gi.solve_ensemble(problem, np.zeros((40, 1)), t_end=1.0, method="rk-4")


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


WRONG = {
    "no end": ({}, "exactly one"),
    "a method that does not fit": ({"t_end": 1.0, "method": "cf-4"}, "needs the form"),
    "no method": ({"t_end": 1.0, "method": "gaus-8"}, "gauss-8"),
    "an end in another time": ({"tau_end": 1.0}, "t_end"),
    "no step": ({"t_end": 1.0, "step": -0.1}, "step"),
    "no workers": ({"t_end": 1.0, "workers": 0}, "workers"),
    "workers that are no number": ({"t_end": 1.0, "workers": "two"}, "workers"),
    "no executor": ({"t_end": 1.0, "executor": 4}, "executor"),
    "saves of nothing": ({"t_end": 1.0, "save_every": 0}, "save_every"),
    "an event that is none": ({"t_end": 1.0, "events": "nothing"}, "nothing"),
    "something unknown to observe": ({"t_end": 1.0, "observe": ["entropy"]}, "entropy"),
    "observe_every alone": ({"t_end": 1.0, "observe_every": 2}, "observe_every"),
    "times outside": ({"t_end": 1.0, "t_eval": [2.0]}, "t_eval"),
    "an argument of other solvers": ({"t_end": 1.0, "dt": 0.1}, "step=…"),
    "a clock that is no switch": ({"t_end": 1.0, "clock": "yes"}, "clock"),
    "a clock that is several": ({"t_end": 1.0, "clock": np.array([1, 0])}, "clock"),
    "progress that is no switch": ({"t_end": 1.0, "progress": "yes"}, "progress"),
    "an estimate that is no switch": ({"t_end": 1.0, "estimate_error": 0}, "estimate_error"),
    "estimates that are several": ({"t_end": 1.0, "estimate_error": np.ones(2)}, "estimate_error"),
    "half a step": ({"t_end": 1.0, "observe_every": 1.0}, "observe_every"),
    "steps that are several": ({"t_end": 1.0, "observe_every": np.ones(2)}, "observe_every"),
    "a number to observe": ({"t_end": 1.0, "observe": 0}, "observe"),
    "more states than there is room for": (
        {"t_end": 1e9, "step": 1e-3, "save_every": 1, "method": "rk-4"},
        "saved states",
    ),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_wrong_with_all_is_raised(what: str) -> None:
    asked, text = WRONG[what]
    with pytest.raises(gi.GeomintError, match=text):
        gi.solve_ensemble(HENON, GOOD, **asked)


def test_calls_are_explained() -> None:
    for given in ((), (HENON,), (HENON, GOOD, 1.0), (lambda t, y: y, GOOD)):
        with pytest.raises(gi.ArgumentError, match=r"geomint.solve_ensemble.*(state|Problem)"):
            gi.solve_ensemble(*given, **({"t_end": 1.0} if len(given) != 3 else {}))


def test_states_are_checked() -> None:
    shape = "states of 4 numbers"
    for states, text in (
        (GOOD[:, :3], shape),
        (np.zeros((0, 4)), shape),
        (GOOD[None], shape),
        ("state", shape),
        (np.full((3, 4), np.nan), r"states\[0\].*finite"),
    ):
        with pytest.raises(gi.DomainError, match=text):
            gi.solve_ensemble(HENON, states, t_end=1.0)


def test_problems_are_checked() -> None:
    other = gi.load_scene("hamiltonized-n3").problem
    for problems in ([], [HENON, other], "henon", [HENON, 3]):
        with pytest.raises(gi.DomainError, match="problems"):
            gi.solve_ensemble(problems, GOOD, t_end=1.0)
    with pytest.raises(gi.DomainError, match="one for each problem"):
        gi.solve_ensemble([HENON] * 3, GOOD, t_end=1.0)


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


def test_an_error_travels() -> None:
    error = gi.EnsembleError("workers have ended")
    assert str(pickle.loads(pickle.dumps(error))) == "workers have ended"
