"""`breaks` and `longest`: steps end where a force switches, and all else of a run goes on as it did.

What is right is known from runs that are joined: one with the force before the switch up to it, and
one with the force behind it from there on, in the same steps.
"""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geomint as gi
from tests.run.motions import SWINGING, TURNING, first, pushed, second

NEVER = 1e9
SHORT = [math.sqrt(0.5) + 0.12 * k for k in range(11)]  # stretches of two steps
SWITCH, END, STEP = math.sqrt(0.5), 2.0, 0.1
STARTS = {"pendulum": SWINGING, "sphere": SWINGING, "body": TURNING}


def late(params: Any, t: Any) -> Any:
    """1 behind the time of the switch, 0 before it, and at it as the second parameter says."""
    return gi.select(t > params[0], 1.0, gi.select(t < params[0], 0.0, params[1]))


def problem(kind: str, switch: float = SWITCH, at_it: float = 1.0) -> gi.Problem:
    """Return a motion with a force from a time on."""
    return pushed(kind, late, switch, at_it)


def joined(kind: str, method: Any, sign: float, end: float = END) -> tuple[np.ndarray, int]:
    """Return the end of runs without and with the force, and how many steps they have taken."""
    y, steps = STARTS[kind], 0
    times = (0.0, SWITCH, end) if sign > 0.0 else (end, SWITCH, 0.0)
    for k, (begin, until) in enumerate(pairwise(times)):
        side = problem(kind, NEVER if (k == 0) == (sign > 0.0) else -NEVER)
        span = abs(until - begin)
        step = None if gi.find_method(method).adaptive else span / math.ceil(span / STEP)
        sol = gi.solve(side, y, t0=begin, t_end=until, method=method, step=step)
        y, steps = sol.y[-1], steps + sol.steps
    return y, steps


FEW = [("rk-4", "pendulum"), ("gauss-8", "pendulum"), ("verlet-2", "sphere"), ("cf-4", "body")]
FAST = [*FEW, ("rattle-2", "sphere"), ("dormand-prince-5-adaptive", "pendulum")]
families = pytest.mark.parametrize(("name", "kind"), FAST)
few = pytest.mark.parametrize(("name", "kind"), FEW)


def ended(kind: str, name: str, sign: float = 1.0, at_it: float = 1.0, **more: Any) -> gi.Solution:
    """Return a run over the switch, with a break there."""
    begin, end = (0.0, END) if sign > 0.0 else (END, 0.0)
    step = {} if gi.find_method(name).adaptive or "tolerance" in more else {"step": STEP}
    given = {"t0": begin, "t_end": end, "method": name, "breaks": [SWITCH], **step, **more}
    return gi.solve(problem(kind, at_it=at_it), STARTS[kind], **given)


def bound_of(name: str, *bounds: float) -> float:
    """Return a bound by the order of a method, the last one for high orders."""
    return bounds[min(gi.find_method(name).order, len(bounds)) - 1]


@families
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_run_is_two_runs_joined(name: str, kind: str, sign: float) -> None:
    """So no function has been evaluated on the wrong side, however the switch is written."""
    want, steps = joined(kind, name, sign)
    adaptive = gi.find_method(name).adaptive
    for at_it, breaks in ((0.0, [SWITCH]), (1.0, [SWITCH, SWITCH + 1e-16, SWITCH])):
        sol = ended(kind, name, sign, at_it, save_every=1, breaks=breaks)
        assert sol.success
        assert SWITCH in sol.t
        assert sol.steps == steps or adaptive
        assert len(sol.t) == sol.steps + 1
        np.testing.assert_allclose(sol.y[-1], want, rtol=0, atol=1e-6 if adaptive else 2e-14)
    without = ended(kind, name, sign, breaks=None)
    assert adaptive or np.abs(without.y[-1] - want).max() > 1e-6


@pytest.mark.parametrize(("name", "kind", "sign"), [(*x, (-1.0) ** k) for k, x in enumerate(FEW)])
def test_states_asked_for_lie_on_the_same_motion(name: str, kind: str, sign: float) -> None:
    """States at times, dense output, events, and what is saved: before, at and behind the break."""
    near = [SWITCH - 1e-3, math.nextafter(SWITCH, 0.0), SWITCH, math.nextafter(SWITCH, 1.0)]
    times = np.array([0.013, 0.4, *near, SWITCH + 1e-3, 1.41, 1.987])[:: int(sign)]
    given: dict[str, Any] = {"dense": True, "events": ["m[1]" if kind == "body" else "q[2]"]}
    sol = ended(kind, name, sign, t_eval=times, **given)
    fine = ended(kind, name, sign, step=STEP / 32, t_eval=times, **given)
    bound = bound_of(name, 1e-2, 1e-2, 1e-3, 1e-3, 1e-12)
    np.testing.assert_array_equal(sol.t, times)
    np.testing.assert_allclose(sol.y, fine.y, rtol=0, atol=bound)
    np.testing.assert_allclose(sol.sol(times), sol.y, rtol=0, atol=1e-14)
    at = sol.y[np.abs(times - SWITCH) < 1e-6]
    np.testing.assert_allclose(at, np.tile(at[0], (3, 1)), rtol=0, atol=2e-15)
    np.testing.assert_allclose(sol.t_events[0], fine.t_events[0], rtol=0, atol=bound)
    every, some = (ended(kind, name, sign, save_every=k) for k in (1, 3))
    which = [*range(0, every.steps, 3), every.steps]  # counted on
    np.testing.assert_array_equal(some.y, every.y[which])
    np.testing.assert_array_equal(some.t, every.t[which])


SINCE = gi.observable(lambda params, t, y, work: t - params[0] + 0.0 * y[0])


@families
def test_an_event_ends_the_run_in_a_later_stretch(name: str, kind: str) -> None:
    """At the break it counts once; what is left behind goes on as a run with the same breaks would."""
    given = {"breaks": [SWITCH - 0.33, SWITCH - 0.18], "save_every": 1}
    whole = ended(kind, name, **given)
    sol = ended(kind, name, **given, events={"now": gi.Event(SINCE, terminal=True)}, dense=True)
    assert sol.message == "ended by the event 'now'"
    assert sol.t[-1] == pytest.approx(SWITCH, abs=1e-12)
    count = np.searchsorted(whole.t, SWITCH)
    if not gi.find_method(name).adaptive:
        assert sol.steps == count - 1
        np.testing.assert_array_equal(sol.y[:-1], whole.y[:count])
        on = gi.solve(sol, t_end=whole.t[-1])
        np.testing.assert_allclose(on.y[-1], whole.y[-1], rtol=0, atol=1e-13)
    once = ended(kind, name, events={"now": gi.Event(SINCE)})
    np.testing.assert_allclose(once.t_events[0], [SWITCH], rtol=0, atol=1e-15)


@few
@pytest.mark.parametrize("more", [[], [0.12 * k + 0.1 * (k % 2 > 0) for k in range(1, 16)]])
def test_an_estimate_is_that_of_all_stretches(name: str, kind: str, more: list[float]) -> None:
    """Also of those that are one step, of whatever length; of states before a break, too."""
    given: dict[str, Any] = {"t_eval": [0.35, 0.55, END]} if not more else {}
    sol = ended(kind, name, estimate_error=True, breaks=[SWITCH, *more], **given)
    error = sol.y - ended(kind, name, step=STEP / 64, **given).y
    bound = max(0.1 * np.abs(error).max(), 1e-13)
    np.testing.assert_allclose(sol.error_estimate, error, rtol=0, atol=bound)


@few
def test_local_errors_know_of_no_switch(name: str, kind: str) -> None:
    """They are those of a motion without one, also where stretches are shorter than a window."""
    still = gi.solve(problem(kind, -NEVER), STARTS[kind], t_end=END, method=name, step=STEP)
    more: Any = [[], [0.11, 0.2, 0.22, 1.1, 1.14], [SWITCH - 0.12, *SHORT[1:], 1.99]]
    for breaks in more:
        error = ended(kind, name, breaks=[SWITCH, *breaks]).local_error
        known = still.local_error
        assert 0.02 * known.largest < error.largest < 10.0 * known.largest + 1e-14
        assert 0.1 * known.total < error.total < 10.0 * known.total + 1e-13
        assert error.step == pytest.approx(STEP, rel=0.3)


@pytest.mark.parametrize("name", [None, "dop853-adaptive"])
@pytest.mark.parametrize("early", [[], [1e-3]])
def test_tolerances_hold(name: str | None, early: list[float]) -> None:
    given = {"t_end": 12.0, "breaks": [SWITCH, 3.3, *early]}
    sphere = problem("sphere"), STARTS["sphere"]
    fine = gi.solve(*sphere, method="gauss-8", step=0.03, **given).y[-1]
    for tolerance in (1e-5, 1e-9):
        sol = gi.solve(*sphere, method=name, tolerance=tolerance, **given)
        assert np.abs(sol.y[-1] - fine).max() < 10.0 * tolerance
        assert sol.steps < 200


def chirp(p: Any, t: Any, y: Any) -> Any:
    w = 1.0 + 0.3 * t
    return -w * w * y[0]


@pytest.mark.parametrize("apart", [0.3, 0.5, 0.8])
def test_a_second_run_has_longer_steps_in_every_stretch(apart: float) -> None:
    """Also where stretches are no longer than steps would be."""
    fast = second("chirp", chirp)
    given = {"t_end": 20.0, "breaks": np.arange(apart, 19.9, apart)}
    sol = gi.solve(fast, [0.7, 0.3], tolerance=1e-9, **given)
    fine = gi.solve(fast, [0.7, 0.3], t_end=20.0, step=0.01)
    error = np.abs((sol.y[-1] - fine.y[-1]) / [0.7, 4.0]).max()
    assert error < 1e-9
    assert sol.end_error.error > error / 30.0


@pytest.mark.parametrize("name", [None, "rk-4", "gauss-8", "cf-4"])
def test_default_steps_are_those_of_the_motion(name: str | None) -> None:
    kind = "body" if name == "cf-4" else "pendulum"
    given = {"t_end": 12.0, "method": name}
    sol = gi.solve(problem(kind, 0.03), STARTS[kind], breaks=[0.03], **given)
    still = gi.solve(problem(kind, NEVER), STARTS[kind], **given)
    assert sol.steps < 2.5 * still.steps
    assert name is not None or sol.end_error is not None


def test_drifts_are_measured_at_ends() -> None:
    sol = ended("sphere", "gauss-8", observe=["energy"], observe_every=5)
    drift, q, p = sol.drift["energy"], sol.y[-1, :3], sol.y[-1, 3:]
    start = 0.5 * np.square(SWINGING[3:]).sum() + SWINGING[2]
    assert drift.initial == pytest.approx(start, abs=1e-15)
    assert drift.windows.samples == sol.steps // 5 + (sol.steps % 5 > 0)
    assert drift.windows.last_time == END
    want = 0.5 * p @ p + q @ [1.5, -0.5, 1.0] - drift.initial
    assert drift.final_error == pytest.approx(want, abs=1e-14)


@pytest.mark.parametrize("name", ["rk-4", "gauss-3", "dop853-adaptive"])
def test_what_is_less_than_a_rounding_adds_up_over_breaks(name: str) -> None:
    creep = first("creep", lambda p, t, y: 1e-16 + 0.0 * y[0])
    given = {"step": 0.25, "breaks": np.arange(0.5, 100.0, 0.5), "compiled": name == "rk-4"}
    sol = gi.solve(creep, [1.0, 1.0], t_end=100.0, method=name, **given)
    assert sol.y[-1, 0] - 1.0 == pytest.approx(1e-14, rel=0.05, abs=0.0)


@families
def test_a_solution_goes_on(name: str, kind: str, tmp_path: Path) -> None:
    """To a break, from one that had a break, and from a file."""
    whole, half = ended(kind, name), ended(kind, name, breaks=None, t_end=0.5)
    on = gi.solve(half, t_end=END, breaks=[SWITCH])
    bound = bound_of(name, 1e-2, 1e-2, 1e-3, 1e-3, 1e-5)
    np.testing.assert_allclose(on.y[-1], whole.y[-1], rtol=0, atol=bound)
    once = ended(kind, name, t_end=1.5)
    once.save(tmp_path / "run.nc")
    for former in (once, gi.load(tmp_path / "run.nc", once.problem)):
        on = gi.solve(former, t_end=END)
        np.testing.assert_allclose(on.y[-1], whole.y[-1], rtol=0, atol=bound)


@pytest.mark.parametrize("name", ["rk-4", "dop853-adaptive"])
def test_a_callback_ends_a_run_in_any_stretch(name: str) -> None:
    breaks = [0.1 * k for k in range(1, 20)]
    sol = ended("pendulum", name, breaks=breaks, callback=lambda reached: reached.tau > 1.0)
    assert sol.message == "ended by the callback"
    assert 1.0 < sol.t[-1] < 1.21
    assert gi.solve(sol, t_end=END).t[-1] == END


def test_what_fails_has_its_part() -> None:
    bad = first("lost", lambda p, t, y: gi.select(t < p[0], 1.0, 1.0 / (t - t)), SWITCH)
    with pytest.raises(gi.NonFiniteError) as caught:
        gi.solve(bad, [0.0, 1.0], t_end=END, method="rk-4", step=STEP, breaks=[SWITCH, 1.5])
    partial = caught.value.partial
    assert caught.value.step == partial.steps == math.ceil(SWITCH / STEP)
    assert partial.y[-1, 0] == pytest.approx(SWITCH, abs=1e-15)


def test_a_problem_in_tau_has_breaks_in_tau() -> None:
    rate = gi.helper(late)

    @gi.observable
    def pace(params: Any, t: Any, y: Any, work: Any) -> Any:
        return 1.0 + 0.5 * rate(params, t) + 0.0 * y[0]

    force = lambda p, t, y: -(1.0 + 3.0 * rate(p, t)) * y[0]  # noqa: E731
    timed = second("turned", force, SWITCH, 1.0, time="tau", clock=pace)
    given: dict[str, Any] = {"method": "gauss-8", "step": STEP, "breaks": [SWITCH]}
    given["compiled"] = False
    times = [0.5, SWITCH, SWITCH + 0.75, SWITCH + 1.5]
    sol = gi.solve(timed, [1.0, 0.0], tau_end=END, t_eval=times, **given)
    own = np.array([0.5, SWITCH, SWITCH + 0.5, SWITCH + 1.0])
    on, x, v = 2.0 * (own - SWITCH), math.cos(SWITCH), -math.sin(SWITCH)
    want = np.where(own > SWITCH, x * np.cos(on) + 0.5 * v * np.sin(on), np.cos(own))
    np.testing.assert_allclose(sol.tau, own, rtol=0, atol=1e-14)
    np.testing.assert_allclose(sol.y[:, 0], want, rtol=0, atol=1e-14)
    with pytest.raises(gi.DomainError, match="give tau_end"):
        gi.solve(timed, [1.0, 0.0], t_end=END, **given)


def test_what_makes_no_sense_is_refused() -> None:
    for more, match in (
        *(({"breaks": x}, "times between 0 and 2") for x in ([0.0], [END], [0.3, 2.5], [math.nan])),
        ({"breaks": "soon"}, "times"),
        ({"longest": 0.05}, "at least the step, 0.1"),
        ({"longest": 0.0}, "a positive number"),
        ({"method": gi.Compose(gi.Verlet(), "triple-jump-4")}, "such as 'suzuki-4'"),
    ):
        given = {"t_end": END, "method": "verlet-2", "step": STEP, "breaks": [SWITCH], **more}
        with pytest.raises(gi.GeomintError, match=match):
            gi.solve(problem("sphere"), STARTS["sphere"], **given)


@pytest.mark.parametrize("more", [{}, {"method": "rk-4"}, {"method": "dop853-adaptive"}])
@pytest.mark.parametrize("tolerance", [None, 1e-6])
def test_no_step_is_longer(more: dict[str, Any], tolerance: float | None) -> None:
    given = {"t_end": 5.0, "tolerance": tolerance, "longest": 0.03, **more}
    sol = gi.solve(problem("pendulum", NEVER), STARTS["pendulum"], **given)
    assert sol.step_sizes.max <= 0.03 * (1.0 + 1e-9)
    assert gi.solve(sol, t_end=6.0).step_sizes.max <= 0.03 * (1.0 + 1e-9)
