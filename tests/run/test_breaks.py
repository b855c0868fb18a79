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

NEVER = 1e9
SHORT = [math.sqrt(0.5) + 0.12 * k for k in range(11)]  # stretches of two steps
SWITCH, END, STEP = math.sqrt(0.5), 2.0, 0.1


@gi.helper
def late(params: Any, t: Any) -> Any:
    """1 behind the time of the switch, 0 before it, and at it as the second parameter says."""
    return gi.select(t > params[0], 1.0, gi.select(t < params[0], 0.0, params[1]))


@gi.field
def gravity(params: Any, t: Any, q: Any, out: Any, work: Any) -> None:
    out[0] = 0.0 * q[0] + 1.5 * late(params, t)
    out[1] = 0.0 * q[1] - 0.5 * late(params, t)
    out[2] = 0.0 * q[2] + 1.0


@gi.field
def gradients(params: Any, t: Any, q: Any, p: Any, dq: Any, dp: Any, work: Any) -> None:
    dq[0] = 0.0 * q[0] + 1.5 * late(params, t)
    dq[1] = 0.0 * q[1] - 0.5 * late(params, t)
    dq[2] = 0.0 * q[2] + 1.0
    for i in range(3):
        dp[i] = 1.0 * p[i]


@gi.field
def pendulum(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    x, z = 1.5 * late(params, t), -0.5 * late(params, t)
    p2 = y[3] * y[3] + y[4] * y[4] + y[5] * y[5]
    push = (p2 - x * y[0] - z * y[1] - y[2]) / (y[0] * y[0] + y[1] * y[1] + y[2] * y[2])
    for i in range(3):
        out[i] = 1.0 * y[3 + i]
        out[3 + i] = -push * y[i]
    out[3], out[4], out[5] = out[3] - x, out[4] - z, out[5] - 1.0


@gi.field
def turning(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    for i in range(3):
        out[i] = -y[i] / (1.0 + 0.6 * i) - late(params, t) * y[3 + (i + 1) % 3]


@gi.observable
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    push = late(params, t) * (1.5 * y[0] - 0.5 * y[1])
    return 0.5 * (y[3] * y[3] + y[4] * y[4] + y[5] * y[5]) + y[2] + push


@gi.observable
def since(params: Any, t: Any, y: Any, work: Any) -> Any:
    return t - params[0] + 0.0 * y[0]


SPACE = gi.TangentSphere(3, ("q", "p"))
STARTS = {
    "pendulum": np.array([0.6, 0.0, -0.8, 0.4, 0.9, 0.3]),
    "sphere": np.array([0.6, 0.0, -0.8, 0.4, 0.9, 0.3]),
    "body": np.array([0.7, -0.4, 1.1, 0.48, 0.6, -0.64]),
}


def problem(kind: str, switch: float = SWITCH, at_it: float = 1.0) -> gi.Problem:
    """Return a motion with a force from a time on."""
    params = [switch, at_it]
    if kind == "body":
        action = gi.GroupAction(turning, gi.so3(2))
        return gi.Problem("body", (("m", 3), ("gamma", 3)), params=params, action=action)
    if kind == "pendulum":
        return gi.Problem("pendulum", (("q", 3), ("p", 3)), params=params, field=pendulum)
    return gi.Problem(
        name="sphere",
        space=SPACE,
        params=params,
        field=pendulum,
        hamiltonian=SPACE.hamiltonian(gradients, separable=True),
        splitting=gi.natural_on_sphere(gravity),
    )


def joined(kind: str, method: Any, sign: float, end: float = END) -> tuple[np.ndarray, int]:
    """Return the end of runs without and with the force, and how many steps they have taken."""
    y, steps = STARTS[kind], 0
    times = (0.0, SWITCH, end) if sign > 0.0 else (end, SWITCH, 0.0)
    for k, (begin, until) in enumerate(pairwise(times)):
        switch = NEVER if (k == 0) == (sign > 0.0) else -NEVER
        count = math.ceil(abs(until - begin) / STEP)
        sol = gi.solve(
            problem(kind, switch),
            y,
            t0=begin,
            t_end=until,
            method=method,
            step=None if gi.find_method(method).adaptive else abs(until - begin) / count,
        )
        y, steps = sol.y[-1], steps + sol.steps
    return y, steps


FAMILIES = [
    *(("rk-4", "pendulum"), ("dop853", "pendulum"), ("gauss-3", "pendulum")),
    *(("gauss-8", "pendulum"), ("gauss-1-suzuki-4", "pendulum"), ("rattle-2", "sphere")),
    *(("rattle-4", "sphere"), ("lobatto-3", "sphere"), ("verlet-2", "sphere")),
    *(("verlet-6", "sphere"), ("dormand-prince-5-adaptive", "pendulum"), ("cf-4", "body")),
    *(("rkmk-4", "body"), ("rkmk-dormand-prince-5-adaptive", "body")),
]
families = pytest.mark.parametrize(("name", "kind"), FAMILIES)
few = pytest.mark.parametrize(
    ("name", "kind"), [f for f in FAMILIES if f[0] in ("rk-4", "gauss-8", "verlet-2", "cf-4")]
)


def ended(kind: str, name: str, sign: float = 1.0, at_it: float = 1.0, **more: Any) -> gi.Solution:
    """Return a run over the switch, with a break there."""
    begin, end = (0.0, END) if sign > 0.0 else (END, 0.0)
    step = {} if gi.find_method(name).adaptive or "tolerance" in more else {"step": STEP}
    given = {"t0": begin, "t_end": end, "method": name, "breaks": [SWITCH], **step, **more}
    return gi.solve(problem(kind, at_it=at_it), STARTS[kind], **given)


@families
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_run_is_two_runs_joined(name: str, kind: str, sign: float) -> None:
    """So no function has been evaluated on the wrong side, however the switch is written."""
    want, steps = joined(kind, name, sign)
    tolerance = 1e-6 if gi.find_method(name).adaptive else 2e-14
    for at_it in (0.0, 1.0):
        sol = ended(kind, name, sign, at_it, save_every=1)
        assert sol.success
        assert SWITCH in sol.t
        assert sol.steps == steps or gi.find_method(name).adaptive
        assert len(sol.t) == sol.steps + 1
        np.testing.assert_allclose(sol.y[-1], want, rtol=0, atol=tolerance)
    without = ended(kind, name, sign, breaks=None)
    if not gi.find_method(name).adaptive:
        assert np.abs(without.y[-1] - want).max() > 1e-6


@families
def test_breaks_where_nothing_switches_move_nothing(name: str, kind: str) -> None:
    """In any order, and some twice: the run ends where the motion does."""
    given = {"t_end": END, "method": name}
    step = {} if gi.find_method(name).adaptive else {"step": 0.02}
    still = problem(kind, NEVER)
    want = gi.solve(still, STARTS[kind], tolerance=1e-9, t_end=END, method=name)
    breaks = [1.3, 0.4, 0.4, 1.3 + 1e-16, 1.9999]
    sol = gi.solve(still, STARTS[kind], **given, **step, breaks=breaks, save_every=1)
    assert {0.4, 1.3, 1.9999} <= {*sol.t.tolist()}
    assert np.all(np.diff(sol.t) > 0.0)
    bound = {1: 1e-1, 2: 1e-3, 3: 1e-4, 4: 1e-5}.get(gi.find_method(name).order, 1e-6)
    np.testing.assert_allclose(sol.y[-1], want.y[-1], rtol=0, atol=bound)


@few
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_states_asked_for_lie_on_the_same_motion(name: str, kind: str, sign: float) -> None:
    """States at times, dense output, events, and what is saved: before, at and behind the break."""
    near = [SWITCH - 1e-3, math.nextafter(SWITCH, 0.0), SWITCH, math.nextafter(SWITCH, 1.0)]
    times = np.array([0.013, 0.4, *near, SWITCH + 1e-3, 1.41, 1.987])[:: int(sign)]
    given: dict[str, Any] = {"dense": True, "events": ["m[1]" if kind == "body" else "q[2]"]}
    sol = ended(kind, name, sign, t_eval=times, **given)
    fine = ended(kind, name, sign, step=STEP / 32, t_eval=times, **given)
    bound = {2: 1e-2, 4: 1e-3}.get(gi.find_method(name).order, 1e-12)
    np.testing.assert_array_equal(sol.t, times)
    np.testing.assert_allclose(sol.y, fine.y, rtol=0, atol=bound)
    np.testing.assert_allclose(sol.sol(times), sol.y, rtol=0, atol=1e-14)
    at = sol.y[np.abs(times - SWITCH) < 1e-6]
    np.testing.assert_allclose(at, np.tile(at[0], (3, 1)), rtol=0, atol=2e-15)
    (found,), (known,) = sol.t_events, fine.t_events
    np.testing.assert_allclose(found, known, rtol=0, atol=bound)


@families
def test_an_event_ends_the_run_in_a_later_stretch(name: str, kind: str) -> None:
    """What is left behind goes on as a run with the same breaks would have."""
    breaks = [SWITCH - 0.33, SWITCH - 0.18]
    given = {"breaks": breaks, "save_every": 1}
    whole = ended(kind, name, **given)
    sol = ended(kind, name, **given, events={"now": gi.Event(since, terminal=True)}, dense=True)
    assert sol.message == "ended by the event 'now'"
    assert sol.t[-1] == pytest.approx(SWITCH, abs=1e-12)
    count = np.searchsorted(whole.t, SWITCH)
    assert sol.steps == count - 1 or gi.find_method(name).adaptive
    if not gi.find_method(name).adaptive:
        np.testing.assert_array_equal(sol.y[:-1], whole.y[:count])
        on = gi.solve(sol, t_end=whole.t[-1])
        np.testing.assert_allclose(on.y[-1], whole.y[-1], rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", ["rk-4", "gauss-8", "dop853-adaptive"])
def test_an_event_at_the_break_counts_once(name: str) -> None:
    sol = ended("pendulum", name, events={"now": gi.Event(since)})
    np.testing.assert_allclose(sol.t_events[0], [SWITCH], rtol=0, atol=1e-15)


@gi.field
def dipping(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    now = gi.select(t > 3.0, gi.select(t < 3.25, 1.0, 0.0), 0.0)
    turns = 8.0 * math.pi
    out[0] = 1.0 * y[1]
    out[1] = -0.01 * turns * turns * gi.cos(turns * (t - 3.0)) * now


@pytest.mark.parametrize("name", ["dop853", "gauss-8"])
def test_events_in_the_first_step_behind_a_break(name: str) -> None:
    """Steps before it, in which nothing moves, say nothing of it."""
    dip = gi.Problem("dip", (("q", 1), ("p", 1)), field=dipping)
    given = {"t_end": 5.0, "step": 0.25, "breaks": [3.0, 3.25], "events": "q[0]"}
    sol = gi.solve(dip, [0.01, 0.0], method=name, **given)
    np.testing.assert_allclose(sol.t_events[0], [3.0625, 3.1875], rtol=0, atol=1e-3)


@few
@pytest.mark.parametrize("more", [[], [0.12 * k + 0.1 * (k % 2 > 0) for k in range(1, 16)]])
def test_an_estimate_is_that_of_all_stretches(name: str, kind: str, more: list[float]) -> None:
    """Also of those that are one step, of whatever length."""
    sol = ended(kind, name, estimate_error=True, breaks=[SWITCH, *more])
    fine = ended(kind, name, step=STEP / 64)
    error = sol.y[-1] - fine.y[-1]
    assert sol.error_estimate is not None
    size = np.abs(error).max()
    np.testing.assert_allclose(sol.error_estimate[-1], error, rtol=0, atol=max(0.1 * size, 1e-13))


@few
@pytest.mark.parametrize(
    "breaks", [[SWITCH], [SWITCH, 0.11, 0.2, 0.22, 1.1, 1.14], [SWITCH - 0.12, *SHORT, 1.99]]
)
def test_local_errors_know_of_no_switch(name: str, kind: str, breaks: list[float]) -> None:
    """They are those of a motion without one, also where stretches are shorter than a window."""
    sol = ended(kind, name, breaks=breaks)
    still = gi.solve(problem(kind, -NEVER), STARTS[kind], t_end=END, method=name, step=STEP)
    error, known = sol.local_error, still.local_error
    assert error is not None
    assert known is not None
    assert error.largest < 10.0 * known.largest + 1e-14
    assert error.total < 10.0 * known.total + 1e-13
    assert error.largest > 0.02 * known.largest
    assert error.total > 0.1 * known.total
    assert error.step == pytest.approx(STEP, rel=0.3)


@gi.field
def rising(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = gi.select(t > params[0], -50.0, 9.0 * t * t * t * t * t * t * t * t) + 0.0 * y[0]


def test_the_worst_steps_may_end_at_a_break() -> None:
    given: dict[str, Any] = {"method": "rk-4", "step": 0.02}
    rise = gi.Problem("rise", (("y", 1),), params=[1.0], field=rising)
    sol = gi.solve(rise, [1.0], t_end=2.0, breaks=[1.0], **given)
    still = gi.Problem("rise", (("y", 1),), params=[NEVER], field=rising)
    known = gi.solve(still, [1.0], t_end=1.0, **given)
    assert sol.local_error is not None
    assert known.local_error is not None
    assert 0.8 < sol.local_error.time < 1.0
    assert 0.3 < sol.local_error.largest / known.local_error.largest < 3.0


@pytest.mark.parametrize("tolerance", [1e-5, 1e-9])
@pytest.mark.parametrize("name", [None, "rk-4", "verlet-4", "dop853-adaptive", "auto"])
@pytest.mark.parametrize("early", [[], [1e-3]])
def test_tolerances_hold(name: str | None, tolerance: float, early: list[float]) -> None:
    given = {"t_end": 12.0, "breaks": [SWITCH, 3.3, *early]}
    sol = gi.solve(problem("sphere"), STARTS["sphere"], method=name, tolerance=tolerance, **given)
    fine = gi.solve(problem("sphere"), STARTS["sphere"], method="gauss-8", step=0.03, **given)
    assert np.abs(sol.y[-1] - fine.y[-1]).max() < 10.0 * tolerance
    assert sol.steps < {"verlet-4": 40000, "rk-4": 10000}.get(name or "", 200)


@gi.field
def chirp(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    w = 1.0 + 0.3 * t
    out[0] = 1.0 * y[1]
    out[1] = -w * w * y[0]


@pytest.mark.parametrize("apart", [0.3, 0.5, 0.8])
def test_a_second_run_has_longer_steps_in_every_stretch(apart: float) -> None:
    """Also where stretches are no longer than steps would be."""
    fast = gi.Problem("chirp", (("q", 1), ("p", 1)), field=chirp)
    given = {"t_end": 20.0, "breaks": np.arange(apart, 19.9, apart)}
    sol = gi.solve(fast, [0.7, 0.3], tolerance=1e-9, **given)
    fine = gi.solve(fast, [0.7, 0.3], t_end=20.0, step=0.01)
    error = np.abs((sol.y[-1] - fine.y[-1]) / [0.7, 4.0]).max()
    assert error < 1e-9
    assert sol.end_error is not None
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
    sol = ended("pendulum", "gauss-8", observe={"energy": energy}, observe_every=5)
    drift = sol.drift["energy"]
    start = 0.5 * (STARTS["pendulum"][3:] ** 2).sum() + STARTS["pendulum"][2]
    assert drift.initial == pytest.approx(start, abs=1e-15)
    assert drift.windows.samples == sol.steps // 5 + (sol.steps % 5 > 0)
    assert drift.windows.last_time == END
    q, p = sol.y[-1, :3], sol.y[-1, 3:]
    want = 0.5 * p @ p + q @ [1.5, -0.5, 1.0] - drift.initial
    assert drift.final_error == pytest.approx(want, abs=1e-14)


def test_an_estimate_of_states_before_a_break() -> None:
    given: dict[str, Any] = {"t_eval": [0.35, 0.55]}
    sol = ended("pendulum", "rk-4", estimate_error=True, **given)
    error = sol.y - ended("pendulum", "rk-4", step=STEP / 64, **given).y
    size = np.abs(error).max()
    np.testing.assert_allclose(sol.error_estimate, error, rtol=0, atol=0.1 * size)


@gi.field
def creeping(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = 1e-16 + 0.0 * y[0]


@pytest.mark.parametrize("name", ["rk-4", "gauss-3", "dop853-adaptive"])
def test_what_is_less_than_a_rounding_adds_up_over_breaks(name: str) -> None:
    creep = gi.Problem("creep", (("y", 1),), field=creeping)
    breaks = np.arange(0.5, 100.0, 0.5)
    sol = gi.solve(creep, [1.0], t_end=100.0, method=name, step=0.25, breaks=breaks)
    assert sol.y[-1, 0] - 1.0 == pytest.approx(1e-14, rel=0.05, abs=0.0)


@few
def test_saved_states_are_counted_on(name: str, kind: str) -> None:
    every, some = ended(kind, name, save_every=1), ended(kind, name, save_every=3)
    which = [*range(0, every.steps, 3), every.steps]
    np.testing.assert_array_equal(some.y, every.y[which])
    np.testing.assert_array_equal(some.t, every.t[which])


@families
def test_a_solution_goes_on(name: str, kind: str, tmp_path: Path) -> None:
    """To a break, from one that had a break, and from a file."""
    whole = ended(kind, name)
    half = ended(kind, name, breaks=None, t_end=0.5)
    on = gi.solve(half, t_end=END, breaks=[SWITCH])
    bound = {2: 1e-2, 3: 1e-3, 4: 1e-3}.get(gi.find_method(name).order, 1e-5)
    np.testing.assert_allclose(on.y[-1], whole.y[-1], rtol=0, atol=bound)
    once = ended(kind, name, t_end=1.5)
    once.save(tmp_path / "run.nc")
    for former in (once, gi.load(tmp_path / "run.nc", once.problem)):
        on = gi.solve(former, t_end=END)
        np.testing.assert_allclose(on.y[-1], whole.y[-1], rtol=0, atol=bound)


def test_a_callback_ends_a_run_in_any_stretch() -> None:
    asked: list[float] = []

    def wait(reached: Any) -> bool:
        asked.append(reached.tau)
        return reached.tau > 1.0

    breaks = [0.1 * k for k in range(1, 20)]
    for name in ("rk-4", "dop853-adaptive"):
        sol = ended("pendulum", name, breaks=breaks, callback=wait)
        assert sol.message == "ended by the callback"
        assert 1.0 < sol.t[-1] < 1.21
        on = gi.solve(sol, t_end=END)
        assert on.t[-1] == END


def test_what_fails_has_its_part() -> None:
    @gi.field
    def lost(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = gi.select(t < params[0], 1.0, 1.0 / (t - t))

    bad = gi.Problem("lost", (("y", 1),), params=[SWITCH], field=lost)
    with pytest.raises(gi.NonFiniteError) as caught:
        gi.solve(bad, [0.0], t_end=END, method="rk-4", step=STEP, breaks=[SWITCH, 1.5])
    partial = caught.value.partial
    assert caught.value.step == partial.steps == math.ceil(SWITCH / STEP)
    assert partial.y[-1, 0] == pytest.approx(SWITCH, abs=1e-15)


def test_compiled_and_plain_have_the_same_bits() -> None:
    for name in ("rk-4", "gauss-3", "dormand-prince-5-adaptive"):
        one, other = (ended("pendulum", name, save_every=1, compiled=c) for c in (True, False))
        np.testing.assert_array_equal(one.y, other.y)
        np.testing.assert_array_equal(one.t, other.t)


@gi.field
def turned(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = -y[1] * (1.0 + late(params, t))
    out[1] = y[0] * (1.0 + late(params, t))


@gi.observable
def pace(params: Any, t: Any, y: Any, work: Any) -> Any:
    return 1.0 + 0.5 * late(params, t) + 0.0 * y[0]


TURNED = gi.Problem(
    "turned", (("y", 2),), params=[SWITCH, 1.0], field=turned, time="tau", clock=pace
)


def test_a_problem_in_tau_has_breaks_in_tau() -> None:
    given: dict[str, Any] = {"method": "gauss-8", "step": STEP, "breaks": [SWITCH]}
    times = [0.5, SWITCH, SWITCH + 0.75, SWITCH + 1.5]
    sol = gi.solve(TURNED, [1.0, 0.0], tau_end=END, t_eval=times, **given)
    own = np.array([0.5, SWITCH, SWITCH + 0.5, SWITCH + 1.0])
    angle = np.where(own > SWITCH, 2.0 * own - SWITCH, own)
    want = np.column_stack((np.cos(angle), np.sin(angle)))
    np.testing.assert_allclose(sol.tau, own, rtol=0, atol=1e-14)
    np.testing.assert_allclose(sol.y, want, rtol=0, atol=1e-14)
    with pytest.raises(gi.DomainError, match="give tau_end"):
        gi.solve(TURNED, [1.0, 0.0], t_end=END, **given)


@pytest.mark.parametrize(
    ("more", "match"),
    [
        ({"breaks": [0.0]}, "times between 0 and 2"),
        ({"breaks": [END]}, "times between 0 and 2"),
        ({"breaks": [0.3, 2.5]}, "times between 0 and 2"),
        ({"breaks": [-0.3]}, "times between 0 and 2"),
        ({"breaks": [math.nan]}, "times between 0 and 2"),
        ({"breaks": "soon"}, "times"),
        ({"longest": 0.05}, "at least the step, 0.1"),
        ({"longest": 0.0}, "a positive number"),
        ({"method": gi.Compose(gi.Verlet(), "triple-jump-4")}, "such as 'suzuki-4'"),
    ],
)
def test_what_makes_no_sense_is_refused(more: dict[str, Any], match: str) -> None:
    given = {"t_end": END, "method": "verlet-2", "step": STEP, "breaks": [SWITCH], **more}
    with pytest.raises(gi.GeomintError, match=match):
        gi.solve(problem("sphere"), STARTS["sphere"], **given)


@gi.field
def pulsed(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    s = (t - 80.0) / params[1]
    out[0] = 1.0 * y[1]
    out[1] = -(1.0 + params[0] / (1.0 + s * s)) * y[0]


@pytest.mark.parametrize("more", [{"longest": 0.1}, {"breaks": [76.0, 80.0, 84.0]}])
def test_a_pulse_in_the_middle_is_seen(more: dict[str, Any]) -> None:
    pulse = gi.Problem("pulse", (("q", 1), ("p", 1)), params=[100.0, 0.7], field=pulsed)
    given = {"t_end": 120.0, "method": "gauss-8"}
    want = gi.solve(pulse, [0.7, 0.3], step=0.01, **given)
    sol = gi.solve(pulse, [0.7, 0.3], t_end=120.0, tolerance=1e-8, **more)
    assert np.abs(sol.y[-1] - want.y[-1]).max() < 1e-7 * np.abs(want.y[-1]).max()


@pytest.mark.parametrize("more", [{}, {"method": "rk-4"}, {"method": "dop853-adaptive"}])
@pytest.mark.parametrize("tolerance", [None, 1e-6])
def test_no_step_is_longer(more: dict[str, Any], tolerance: float | None) -> None:
    given = {"t_end": 5.0, "tolerance": tolerance, "longest": 0.03, **more}
    sol = gi.solve(problem("pendulum", NEVER), STARTS["pendulum"], **given)
    assert sol.step_sizes.max <= 0.03 * (1.0 + 1e-9)
    assert gi.solve(sol, t_end=6.0).step_sizes.max <= 0.03 * (1.0 + 1e-9)
