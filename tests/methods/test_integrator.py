"""An integrator in the hand: the bits of `solve`, whatever is done to it between steps."""

from __future__ import annotations

import copy
import math
import pickle
import threading
from typing import Any

import numpy as np
import pytest
from families import FAMILIES, PROBLEMS, families
from hypothesis import given, settings, strategies as st

import geomint as gi

H = 0.05
FIXED = [pair for pair in FAMILIES if "adaptive" not in pair[0]]


def made(name: str, problem: str, **options: Any) -> gi.Integrator:
    p, y0 = PROBLEMS[problem]
    return gi.Integrator(p, y0, name, **{"step": H, **options})


def same(one: gi.Integrator, other: gi.Integrator) -> None:
    np.testing.assert_array_equal(one.restart.memory, other.restart.memory)
    assert (one.time, one.steps, one.h) == (other.time, other.steps, other.h)
    assert one.iterations == other.iterations


@families
def test_steps_one_by_one_are_steps_at_once(name: str, problem: str) -> None:
    one, other = made(name, problem), made(name, problem)
    one.step(30)
    for n in (1, 0, 3, 7, 1, 18):
        other.step(n)
    same(one, other)
    assert one.steps == 30


@pytest.mark.parametrize(("name", "problem"), FIXED[:3] + FIXED[6:9] + FIXED[-4:])
def test_steps_are_those_of_solve(name: str, problem: str) -> None:
    p, y0 = PROBLEMS[problem]
    motion = made(name, problem)
    motion.step(64)
    end = {"tau_end": 64 * H, "clock": False} if p.time == "tau" else {"t_end": 64 * H}
    solution = gi.solve(p, y0, method=name, step=H, **end)
    assert (solution.steps, solution.tau[-1]) == (64, motion.time)
    np.testing.assert_array_equal(motion.state, solution.y[-1])


@families
def test_copies_and_pickles_go_on_by_themselves(name: str, problem: str) -> None:
    motion = made(name, problem)
    motion.step(11)
    others = [copy.copy(motion), copy.deepcopy(motion), pickle.loads(pickle.dumps(motion))]
    before = motion.state
    for other in others:
        other.step(9)
    np.testing.assert_array_equal(motion.state, before)
    motion.step(9)
    for other in others:
        same(motion, other)


@families
def test_there_and_back(name: str, problem: str) -> None:
    """A time is met exactly, whatever lies between; back again is near where it was."""
    _, y0 = PROBLEMS[problem]
    motion = made(name, problem, step=0.01)
    for end in (0.123, 0.123, 0.2, 0.20000000000000007, 0.5):
        motion.propagate_until(end)
        assert motion.time == end
    motion.propagate_for(-0.2)
    assert motion.time == 0.5 - 0.2
    motion.propagate_until(0.0)
    assert motion.time == 0.0
    np.testing.assert_allclose(motion.state, y0, atol=1e-4)
    motion.reset()
    np.testing.assert_array_equal(motion.state, y0)
    assert (motion.time, motion.steps, motion.iterations) == (0.0, 0, 0)


@families
def test_a_written_state_is_a_new_beginning(name: str, problem: str) -> None:
    """Nothing of the steps before is remembered: it is another integrator from there."""
    motion = made(name, problem)
    motion.step(5)
    state, time = motion.state, motion.time
    motion.state = state
    p, _ = PROBLEMS[problem]
    other = gi.Integrator(p, state, name, step=motion.h, time=time)
    motion.step(5)
    other.step(5)
    np.testing.assert_array_equal(motion.state, other.state)
    assert motion.time == pytest.approx(other.time, rel=1e-15)
    motion.time = 3.0
    assert motion.time == 3.0
    motion.h = 0.5 * H
    motion.step()
    assert motion.time == 3.0 + 0.5 * H


LOTKA, START = PROBLEMS["lotka-volterra"]


@settings(deadline=None, max_examples=25)
@given(st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=6))
def test_any_times_are_met(times: list[float]) -> None:
    """Forwards, backwards, hardly at all: the state is that of one run to the last of them."""
    motion = gi.Integrator(LOTKA, START, "gauss-3", step=0.02)
    for time in times:
        motion.propagate_until(time)
        assert motion.time == time
    there = gi.Integrator(LOTKA, START, "gauss-3", step=0.02)
    there.propagate_until(times[-1])
    np.testing.assert_allclose(motion.state, there.state, rtol=1e-6)


def test_parameters_are_read_and_written() -> None:
    motion = gi.Integrator(LOTKA, START, "gauss-3", step=0.02)
    motion.step(3)
    params, state = motion.params, motion.state
    motion.params = 2.0 * params
    np.testing.assert_array_equal(motion.params, 2.0 * params)
    np.testing.assert_array_equal(motion.state, state)
    assert motion.steps == 3
    motion.step(10)
    motion.params = params
    other = gi.Integrator(LOTKA, state, "gauss-3", step=0.02, time=0.06)
    other.step(10)
    assert not np.allclose(motion.state, other.state, rtol=1e-3)
    np.testing.assert_array_equal(LOTKA.params, params)
    for bad in (params[:-1], [*params, 1.0], "no", [math.nan] * len(params)):
        with pytest.raises(gi.DomainError):
            motion.params = bad


def test_physical_time_beside_tau() -> None:
    import chaplygin as ch

    problem = ch.ChaplyginSphere([0.5, 0.7, 0.9], 0.8).hamiltonized()
    y0 = problem.random_state(0)
    motion = gi.Integrator(problem, y0, step=0.1, clock=True)
    motion.step(20)
    solution = gi.solve(problem, y0, step=0.1, tau_end=2.0, clock=True)
    assert (motion.t, motion.time) == (solution.t[-1], solution.tau[-1])
    state, t = motion.state, motion.t
    motion.state = state
    assert motion.t == t
    np.testing.assert_array_equal(motion["gamma"], state[:3])
    without = gi.Integrator(problem, y0, step=0.1)
    with pytest.raises(gi.DomainError, match="clock"):
        _ = without.t
    with pytest.raises(gi.DomainError, match="gamma"):
        _ = without["gama"]


@gi.field
def runaway(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = y[0] * y[0]


@pytest.mark.parametrize("method", ["gauss-3", "rk-4", "dop853-adaptive"])
def test_after_an_error_it_is_where_it_was(method: str) -> None:
    """y = 1/(1 − t) ends at 1: before the step that fails all is as it was, and goes on from there."""
    problem = gi.Problem("runaway", (("y", 1),), field=runaway)
    motion = gi.Integrator(problem, [1.0], method, step=0.01)
    with pytest.raises(gi.StepError) as raised:
        motion.propagate_until(1e6) if "adaptive" in method else motion.step(10**6)
    assert np.isfinite(motion.state).all()
    assert raised.value.step == motion.steps > 10
    assert raised.value.t == pytest.approx(motion.time)
    motion.state = [1.0]
    motion.time = 0.0
    motion.propagate_until(0.5)
    np.testing.assert_allclose(motion.state, 2.0, rtol=1e-6)


def test_what_is_refused() -> None:
    motion = gi.Integrator(LOTKA, START, "gauss-3", step=0.02)
    for n in (-1, 1.5, "3", True, None):
        with pytest.raises(gi.DomainError):
            motion.step(n)
    for time in (math.inf, math.nan, "soon", None):
        with pytest.raises(gi.DomainError):
            motion.propagate_until(time)
        with pytest.raises(gi.DomainError):
            motion.time = time
    for state in ([math.nan] * LOTKA.rows, [1.0], "x"):
        with pytest.raises(gi.DomainError):
            motion.state = state
    for h in (0.0, math.nan):
        with pytest.raises(gi.DomainError):
            motion.h = h
    assert (motion.time, motion.steps) == (0.0, 0)
    for arguments in ((lambda t, y: y, START), (LOTKA, START, "no-such-method")):
        with pytest.raises(gi.GeomintError):
            gi.Integrator(*arguments)
    with pytest.raises(gi.DomainError):
        gi.Integrator(LOTKA, START, step=-0.1)


def test_two_threads_have_an_integrator_each() -> None:
    """Calls give the interpreter up while they run: nothing is shared."""
    alone = gi.Integrator(LOTKA, START, "gauss-3", step=0.001)
    alone.step(200_000)
    motions = [gi.Integrator(LOTKA, START, "gauss-3", step=0.001) for _ in range(4)]
    threads = [
        threading.Thread(target=lambda m=m: [m.step(2000) for _ in range(100)]) for m in motions
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for motion in motions:
        same(motion, alone)


# --- runs that go on ------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "problem"), FIXED[:3] + FIXED[6:9] + FIXED[-4:])
def test_a_solution_goes_on_to_the_same_bits(name: str, problem: str) -> None:
    """Ends on a step and between two: what is saved further on is that of one run."""
    p, y0 = PROBLEMS[problem]
    key = "tau_end" if p.time == "tau" else "t_end"
    options: dict[str, Any] = {"method": name, "step": H, "save_every": 1}
    whole = gi.solve(p, y0, **{key: 40 * H}, **options)
    for end in (20 * H, 19.3 * H):
        first = gi.solve(p, y0, **{key: end}, **options)
        second = gi.solve(first, **{key: 40 * H}, save_every=1)
        assert first.steps + second.steps == whole.steps == 40
        np.testing.assert_array_equal(second.y[-15:], whole.y[-15:])
        np.testing.assert_array_equal(second.tau[-15:], whole.tau[-15:])


def test_a_solution_goes_on_in_physical_time() -> None:
    import chaplygin as ch

    problem = ch.ChaplyginSphere([0.5, 0.7, 0.9], 0.8).hamiltonized()
    y0 = problem.random_state(0)
    whole = gi.solve(problem, y0, step=0.1, t_end=8.0)
    half = gi.solve(problem, y0, step=0.1, t_end=4.0)
    rest = gi.solve(pickle.loads(pickle.dumps(half)), t_end=8.0, t_eval=[5.0, 8.0])
    np.testing.assert_array_equal(rest.y[-1], whole.y[-1])
    np.testing.assert_array_equal(rest.t, [5.0, 8.0])
    for wrong in ({"t_end": 2.0}, {"t_end": 8.0, "step": 0.2}, {"t_end": 8.0, "method": "rk-4"}):
        with pytest.raises((gi.DomainError, gi.ClockError)):
            gi.solve(half, **wrong)


@gi.field
def driven(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = gi.cos(t)


@pytest.mark.parametrize("method", ["gauss-3", "rk-4", "dop853-adaptive"])
@pytest.mark.parametrize(("begin", "end"), [(5.0, 9.0), (-3.0, 1.0), (2.0, -2.0)])
def test_a_run_may_begin_at_another_time(method: str, begin: float, end: float) -> None:
    """ẏ = cos t, whose solution is sin t: forwards and backwards, states and drifts at their times."""
    problem = gi.Problem("driven", (("y", 1),), field=driven)
    times = np.linspace(begin, end, 5)
    solution = gi.solve(
        problem, [math.sin(begin)], t0=begin, t_end=end, step=0.05, method=method, t_eval=times,
        observe={"y": gi.observable(lambda params, t, y, work: y[0] - gi.sin(t))},
    )  # fmt: skip
    np.testing.assert_array_equal(solution.t, times)
    np.testing.assert_allclose(solution.y[:, 0], np.sin(times), atol=1e-6)
    assert solution.drift["y"].max_abs_error < 1e-6
    assert solution.drift["y"].windows.last_time == end
    longer = gi.solve(solution, t_end=end + (end - begin))
    np.testing.assert_allclose(longer.y[-1], np.sin(2 * end - begin), atol=1e-5)


def test_the_beginning_is_no_time_of_the_run() -> None:
    problem = gi.Problem("driven", (("y", 1),), field=driven)
    for wrong in ({"t_end": 5.0}, {"t_end": 9.0, "t_eval": [4.0]}, {"t_end": 9.0, "t_eval": [9.5]}):
        with pytest.raises(gi.DomainError):
            gi.solve(problem, [0.0], t0=5.0, step=0.1, **wrong)
    with pytest.raises(gi.DomainError):
        gi.solve(problem, [0.0], t0=math.nan, t_end=1.0)
