"""Samples of a run for pictures: near the motion where lines join them, and said where not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.run import stretch as module
from geomint.run.stretch import MOST, NEAR, stretch_of, with_times


@gi.field
def turning(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = -params[0] * y[1]
    out[1] = params[0] * y[0]
    out[2] = 0.0 * y[0]


@gi.observable
def rate(params: Any, t: Any, y: Any, work: Any) -> Any:
    return 2.0 + y[0]


def circle(omega: float = 1.0, tau: bool = False) -> gi.Problem:
    more: dict[str, Any] = {"time": "tau", "clock": rate} if tau else {}
    return gi.Problem("circle", (("y", 3),), [omega], field=turning, **more)


def run(end: float, **given: Any) -> gi.Solution:
    problem = given.pop("problem", circle())
    ends = {"tau_end": end} if problem.time == "tau" else {"t_end": end}
    more = {"method": "gauss-4", "step": 0.25, **ends, **given}
    return gi.solve(problem, [1.0, 0.0, 0.7], progress=False, **more)


def off(stretch: Any) -> float:
    """How far lines are from the circle, at their middles."""
    middles = 0.5 * (stretch.states[1:, :2] + stretch.states[:-1, :2])
    return float(np.max(1.0 - np.hypot(*middles.T)))


@pytest.mark.parametrize("end", [3.0, 80.0, -30.0, 400.0 * 2.0 * np.pi / 8.0])
def test_lines_between_samples_are_near_the_motion(end: float) -> None:
    """For the last end equal times are whole turns apart, where states are all alike."""
    stretch = stretch_of(run(end, dense=True))
    assert stretch.joined
    assert off(stretch) < 2.0 * NEAR
    assert stretch.note == ""
    assert (stretch.times[0], stretch.times[-1]) == (0.0, pytest.approx(end, rel=1e-15))
    truth = np.stack([np.cos(stretch.times), np.sin(stretch.times)], axis=1)
    np.testing.assert_allclose(stretch.states[:, :2], truth, atol=1e-6)


def test_whole_turns_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where samples of the coarsest grid are whole turns apart."""
    monkeypatch.setattr(module, "FEW_STEPS", 0)
    stretch = stretch_of(run(module.COARSE * 2.0 * np.pi, dense=True, step=0.5))
    assert off(stretch) < 2.0 * NEAR


def test_of_a_long_run_the_beginning_is_shown() -> None:
    solution = run(3000.0, dense=True, step=0.5)
    stretch = stretch_of(solution)
    assert len(stretch.times) <= MOST + 1
    assert stretch.times[-1] < 3000.0
    assert stretch.note.startswith("the first 0.")
    assert off(stretch) < 2.0 * NEAR
    part = stretch_of(solution, (2990.0, 3000.0))
    assert part.times[[0, -1]].tolist() == [2990.0, 3000.0]
    assert part.note == ""


def test_saved_states_are_joined_where_they_are_dense() -> None:
    fine = stretch_of(run(10.0, save_every=1, step=0.02))
    assert fine.joined
    assert off(fine) < 2.0 * NEAR
    coarse = stretch_of(run(40.0, save_every=8))
    assert not coarse.joined
    assert "too far apart" in coarse.note


def test_many_saved_states_are_thinned() -> None:
    """As long as lines are near the motion, and the last one is kept."""
    stretch = stretch_of(run(40.0, save_every=1, step=0.002))
    assert len(stretch.times) < 5000
    assert stretch.times[-1] == 40.0
    assert off(stretch) < 8.0 * NEAR
    assert stretch.joined


@pytest.mark.parametrize("dense", [True, False])
def test_a_state_that_does_not_move(dense: bool) -> None:
    at_rest = gi.solve(
        circle(), [0.0, 0.0, 0.7], t_end=4.0, step=0.5, method="gauss-1", dense=dense,
        save_every=1, progress=False,
    )  # fmt: skip
    stretch = stretch_of(at_rest)
    assert stretch.joined
    assert np.ptp(stretch.states) == 0.7


def test_what_moves_by_roundings_alone_is_constant() -> None:
    """Else no step would be short enough for it."""
    stretch = stretch_of(run(80.0, dense=True, problem=circle(1e-15)))
    assert stretch.joined
    assert len(stretch.times) < 500


def test_roundings_beside_a_motion_are_constant() -> None:
    times = np.linspace(0.0, 6.0, 400)
    noise = 1.0 + 4e-16 * np.random.default_rng(1).integers(-2, 3, len(times))
    assert module._joined(times, np.stack([np.cos(times), noise], axis=1))
    assert not module._joined(times, np.stack([np.cos(times), 1e9 * (noise - 1.0)], axis=1))


def test_physical_times_of_a_problem_in_tau() -> None:
    solution = run(8.0, problem=circle(tau=True), dense=True, clock=True)
    stretch = stretch_of(solution, (2.0, 9.0))
    assert stretch.time == "t"
    assert stretch.times[[0, -1]].tolist() == [2.0, 9.0]
    clock = 2.0 * stretch.own + np.sin(stretch.own)  # ∫ 2 + cos τ
    np.testing.assert_allclose(clock, stretch.times, atol=1e-6)
    plain = stretch_of(run(8.0, problem=circle(tau=True), dense=True, clock=False))
    assert plain.time == "tau"


@pytest.mark.parametrize(
    ("given", "span", "told"),
    [
        ({}, None, "dense=True"),
        ({"save_every": 1}, (0.1, 0.2), "dense=True"),
        ({"dense": True}, (0.0, 11.0), "within the run"),
        ({"dense": True}, (2.0, 2.0), "within the run"),
        ({"dense": True}, (np.nan, 2.0), "span"),
        ({"dense": True}, 3.0, "within the run"),
        ({"dense": True}, "ab", "within the run"),
    ],
)
def test_what_cannot_be_shown(given: dict[str, Any], span: Any, told: str) -> None:
    with pytest.raises(gi.DomainError, match=told):
        stretch_of(run(10.0, **given), span)


def test_a_span_may_be_given_the_other_way_round() -> None:
    one, other = (stretch_of(run(-10.0, dense=True), s) for s in ((-2.0, -6.0), (-6.0, -2.0)))
    assert one.times.tolist() == other.times.tolist()
    assert one.times[0] == -2.0


@pytest.mark.parametrize("end", [10.0, -10.0])
@pytest.mark.parametrize("given", [{"dense": True}, {"save_every": 1, "step": 0.02}])
def test_further_times(end: float, given: dict[str, Any]) -> None:
    solution = run(end, **given)
    stretch = stretch_of(solution)
    times = end * np.linspace(0.0, 1.0, 24)
    every, rows = with_times(solution, stretch, times)
    assert np.all(np.diff(np.abs(every.times)) > 0.0)
    np.testing.assert_allclose(every.times[rows], times, atol=1e-12 if "dense" in given else 0.03)
    assert (rows[0], rows[-1]) == (0, len(every.times) - 1)
