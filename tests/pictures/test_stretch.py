"""Samples of a run that pictures show: near the motion where lines join them, and said where not."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest

import geomint as gi

NEAR = 1e-3  # of what is seen: as far as a line may be from the motion


@gi.field
def turning(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = -params[0] * y[1]
    out[1] = params[0] * y[0]
    out[2] = 0.0 * y[0]


rate = gi.observable(lambda params, t, y, work: 2.0 + y[0])


def circle(omega: float = 1.0, tau: bool = False) -> gi.Problem:
    more: dict[str, Any] = {"time": "tau", "clock": rate} if tau else {}
    return gi.Problem("circle", (("y", 3),), [omega], field=turning, **more)


def run(end: float, **given: Any) -> gi.Solution:
    problem = given.pop("problem", circle())
    ends = {"tau_end": end} if problem.time == "tau" else {"t_end": end}
    more = {"method": "gauss-4", "step": 0.25, "y0": [1.0, 0.0, 0.7], **ends, **given}
    return gi.solve(problem, progress=False, **more)


class Shown(NamedTuple):
    """What a plot shows: the samples, whether lines join them, and what is written above."""

    times: Any
    states: Any
    joined: bool
    words: str
    label: str

    @property
    def off(self) -> float:
        """How far lines are from the circle, at their middles."""
        middles = 0.5 * (self.states[1:, :2] + self.states[:-1, :2])
        return float(np.max(1.0 - np.hypot(*middles.T)))


def shown(solution: gi.Solution, span: Any = None) -> Shown:
    (axes,) = solution.plot(span=span).axes
    states = np.stack([line.get_ydata() for line in axes.lines], axis=1)
    joined = {line.get_linestyle() != "None" for line in axes.lines}
    assert len(joined) == 1
    title, label = axes.get_title(loc="left"), axes.get_xlabel()
    return Shown(axes.lines[0].get_xdata(), states, joined.pop(), title, label)


@pytest.mark.parametrize("end", [3.0, 80.0, -30.0, 400.0 * 2.0 * np.pi / 8.0])
def test_lines_between_samples_are_near_the_motion(end: float) -> None:
    """For the last end equal times are whole turns apart, where states are all alike."""
    found = shown(run(end, dense=True))
    assert found.joined
    assert found.off < 2.0 * NEAR
    assert "\n" not in found.words
    assert (found.times[0], found.times[-1]) == (0.0, pytest.approx(end, rel=1e-15))
    truth = np.stack([np.cos(found.times), np.sin(found.times)], axis=1)
    np.testing.assert_allclose(found.states[:, :2], truth, atol=1e-6)


def test_of_a_long_run_the_beginning_is_shown() -> None:
    """Samples of the coarsest grid are whole turns apart: these are seen."""
    solution = run(4000.0 * np.pi, dense=True, step=0.5)
    found = shown(solution)
    assert len(found.times) <= 8001
    assert found.times[-1] < 4000.0
    assert "\nthe first 0." in found.words
    assert found.off < 2.0 * NEAR
    part = shown(solution, (2990.0, 3000.0))
    assert part.times[[0, -1]].tolist() == [2990.0, 3000.0]
    assert "\n" not in part.words
    turns = shown(run(800.0 * np.pi, dense=True, step=0.015))  # more steps than are looked at
    assert turns.off < 2.0 * NEAR


def test_saved_states_are_joined_where_they_are_dense() -> None:
    """As many as lines need, the last one too."""
    many = shown(run(40.0, save_every=1, step=0.002))
    assert many.joined
    assert len(many.times) < 5000
    assert many.times[-1] == 40.0
    assert many.off < 8.0 * NEAR
    coarse = shown(run(40.0, save_every=8))
    assert not coarse.joined
    assert "21 saved states, too far apart" in coarse.words


@pytest.mark.parametrize("dense", [True, False])
def test_a_state_that_does_not_move(dense: bool) -> None:
    found = shown(run(4.0, y0=[0.0, 0.0, 0.7], dense=dense, save_every=1, step=0.5))
    assert found.joined
    assert (found.states == [0.0, 0.0, 0.7]).all()


def test_what_moves_by_roundings_alone_is_constant() -> None:
    """Else no step would be short enough for it, and nothing beside it be joined."""
    found = shown(run(80.0, dense=True, problem=circle(1e-15)))
    assert found.joined
    assert len(found.times) < 500
    noisy = gi.Problem("noisy", (("y", 3),), [1.0], field=turning)
    solution = run(6.0, problem=noisy, save_every=1, step=0.02)
    noise = np.random.default_rng(1).integers(-2, 3, len(solution.t))
    for size, joined in ((4e-16, True), (4e-7, False)):
        solution.y[:, 2] = 1.0 + size * noise
        assert shown(solution).joined is joined


def test_physical_times_of_a_problem_in_tau() -> None:
    given = {"method": "rk-4", "step": 0.05, "compiled": False, "dense": True}
    solution = run(8.0, problem=circle(tau=True), clock=True, **given)
    found = shown(solution, (2.0, 9.0))
    assert found.label == "t (dimensionless)"
    assert found.times[[0, -1]].tolist() == [2.0, 9.0]
    tau = np.unwrap(np.arctan2(found.states[:, 1], found.states[:, 0]))
    np.testing.assert_allclose(2.0 * tau + np.sin(tau), found.times, atol=1e-6)  # ∫ 2 + cos τ
    plain = shown(run(8.0, problem=circle(tau=True), clock=False, **given))
    assert plain.label == "τ (dimensionless)"


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
        shown(run(10.0, **given), span)


def test_a_span_may_be_given_the_other_way_round() -> None:
    solution = run(-10.0, dense=True)
    one, other = (shown(solution, span) for span in ((-2.0, -6.0), (-6.0, -2.0)))
    assert one.times.tolist() == other.times.tolist()
    assert one.times[0] == -2.0
