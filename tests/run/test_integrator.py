"""An integrator in the hand: the bits of `solve`, whatever is done to it between steps."""

from __future__ import annotations

import copy
import math
import pickle
import threading
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

import geomint as gi
from geomint.run import driver
from geomint.run.wanted import Wanted
from tests.families import FAMILIES, PROBLEMS, families
from tests.rows import examples

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


@examples(25)
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
    with pytest.raises(gi.FormError, match="its own time is physical"):
        gi.Integrator(LOTKA, START, clock=True)


@pytest.mark.parametrize("method", ["gauss-3", "rk-4", "dop853-adaptive"])
def test_times_that_no_steps_lead_to(method: str) -> None:
    """Too many steps, or beyond all numbers: refused, or a step that fails, never a time of inf."""
    far = ({"time": -1.7e308}, 1.7e308), ({"step": 1e-300}, 1e300), ({}, -1e300)
    for options, end in far if "adaptive" not in method else ():
        motion = gi.Integrator(LOTKA, START, method, **{"step": 0.1, **options})
        with pytest.raises(gi.DomainError, match=r"2⁵³ steps|rounding of times"):
            motion.propagate_until(end)
        assert (motion.time, motion.steps) == (options.get("time", 0.0), 0)
        assert motion.h > 0.0
    motion = gi.Integrator(
        gi.Problem("still", (("y", 1),), field=standing), [1.0], method, step=1e308
    )
    with pytest.raises((gi.DomainError, gi.StepError)):
        motion.step(4000)
    assert math.isfinite(motion.time)


@pytest.mark.parametrize("method", ["gauss-3", "rk-4", "dop853-adaptive"])
@pytest.mark.parametrize("late", [1e17, -1e300])
def test_times_that_do_not_advance(method: str, late: float) -> None:
    """Steps of less than a rounding of the time would see a force at one time alone."""
    problem = gi.Problem("driven", (("y", 1),), field=driven)
    end = math.nextafter(late, 0.0)
    motion = gi.Integrator(problem, [0.0], method, step=0.1, time=late)
    refused = pytest.raises((gi.DomainError, gi.StepError), match=r"least|step size does not serve")
    for go in (motion.step, lambda: motion.propagate_until(end)):
        with refused:
            go()
        assert (motion.time, motion.steps) == (late, 0)
    with pytest.raises((gi.DomainError, gi.StepError)):
        gi.solve(problem, [0.0], t0=late, t_end=end, step=0.1, method=method)
    motion.step(0)


@gi.field
def standing(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = 0.0 * y[0]


@gi.field
def chosen_row(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = y[int(params[0])]


def test_written_parameters_are_held_to_the_declaration() -> None:
    """A row that they lead to and that is not there would be memory of somebody else."""
    problem = gi.Problem("chosen", (("y", 1),), params=[0.0], field=chosen_row)
    motion = gi.Integrator(problem, [1.0], "rk-4", step=0.01)
    motion.step()
    state = motion.state
    with pytest.raises(gi.DeclarationError, match="reads row 7"):
        motion.params = [7.0]
    np.testing.assert_array_equal((motion.params, motion.state), ([0.0], state))


@gi.field
def row_of_state(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = y[int(y[1])]
    out[1] = 1.0


@pytest.mark.parametrize("method", ["gauss-3", "rk-4", "dop853-adaptive"])
def test_after_a_row_that_is_not_there_it_is_where_it_was(method: str) -> None:
    """In plain Python, which looks at rows: state, time and steps belong together."""
    problem = gi.Problem("rows", (("y", 2),), field=row_of_state)
    motion = gi.Integrator(problem, [1.0, 0.0], method, step=0.1, compiled=False)
    with pytest.raises(IndexError):
        motion.step(1000)
    assert motion.state[1] == pytest.approx(motion.time, abs=1e-12)
    assert (motion.time == 0.0) == (motion.steps == 0)


def test_other_names_are_not_written_to() -> None:
    """What would change nothing, such as the name of an argument."""
    motion = gi.Integrator(LOTKA, START, "rk-4", step=0.01)
    for name in ("step", "y", "t", "problem", "method"):
        with pytest.raises(AttributeError):
            setattr(motion, name, 0.02)
    motion.step()
    assert motion.time == 0.01


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


@pytest.mark.parametrize("call", [1, 2, 5])
def test_no_state_is_lost_where_ctrl_c_comes(call: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """While states at wanted times are made: the run goes on before the next of them."""
    times = np.linspace(0.013, 9.97, 40)
    options: dict[str, Any] = {"method": "rk-4", "step": H, "t_end": 10.0}
    whole = gi.solve(LOTKA, START, t_eval=times, **options)
    original, calls = Wanted.at, []

    def interrupted(*args: Any, **given: Any) -> Any:
        calls.append(1)
        if len(calls) == call:
            raise KeyboardInterrupt
        return original(*args, **given)

    with monkeypatch.context() as patch:
        patch.setattr(Wanted, "at", interrupted)
        patch.setattr(driver, "FIRST_CHUNK", 3)
        patch.setattr(driver, "CHUNK_SECONDS", 0.0)
        first = gi.solve(LOTKA, START, t_eval=times, **options)
    assert first.status == "interrupted"
    assert (len(first.t) > 0) == (call > 1)
    rest = gi.solve(first, t_end=10.0, t_eval=times[len(first.t) :])
    np.testing.assert_array_equal(np.append(first.t, rest.t), times)
    np.testing.assert_array_equal(np.vstack((first.y, rest.y)), whole.y)


def test_the_limit_of_steps_is_that_of_a_run() -> None:
    """What it has left goes on, with as many steps again."""
    method = gi.Adaptive(gi.RungeKutta("dormand-prince-5"), max_steps=50)
    with pytest.raises(gi.StepLimitError) as raised:
        gi.solve(LOTKA, START, t_end=1e3, method=method)
    for _ in range(2):
        former = raised.value.partial
        with pytest.raises(gi.StepLimitError) as raised:
            gi.solve(former, t_end=1e3)
        assert raised.value.step == raised.value.partial.steps == 50
        assert raised.value.t > former.t[-1] + 1.0


def test_the_beginning_is_no_time_of_the_run() -> None:
    problem = gi.Problem("driven", (("y", 1),), field=driven)
    for wrong in (
        {"t_end": math.inf},
        {"t_end": 9.0, "t_eval": [4.0]},
        {"t_end": 9.0, "t_eval": [9.5]},
    ):
        with pytest.raises(gi.DomainError):
            gi.solve(problem, [0.0], t0=5.0, step=0.1, **wrong)
    for wrong in (math.nan, math.inf, "now", None):
        with pytest.raises(gi.DomainError, match="t0"):
            gi.solve(problem, [0.0], t0=wrong, t_end=1.0)
    first = gi.solve(problem, [0.0], t_end=1.0, step=0.1, method="rk-4")
    with pytest.raises(gi.DomainError, match="t0"):
        gi.solve(first, t0=1.0, t_end=2.0)


class Failing(gi.Watcher):
    """What fails, after some seconds, with the first chunk that has gone so far."""

    def begin(self, run: Any) -> float:
        return 0.0

    def values(self, times: Any, states: Any, lengths: Any) -> Any:
        if abs(times[-1]) > 0.5:
            raise ValueError("no more")
        return np.zeros(len(times))


@pytest.mark.parametrize("method", ["gauss-8", "dop853-adaptive"])
@pytest.mark.parametrize("key", ["t_end", "tau_end"])
@pytest.mark.parametrize("end", [3.0, -3.0])
def test_what_a_failed_watcher_leaves_goes_on(method: str, key: str, end: float) -> None:
    """From its last state, which is within the run; and every step before is saved."""
    import chaplygin as ch

    problem = ch.ChaplyginSphere([0.5, 0.7, 0.9], 0.8).hamiltonized()
    y0 = problem.random_state(0)
    options: dict[str, Any] = {key: end, "method": method, "step": 0.1, "save_every": 1}
    whole = gi.solve(problem, y0, **options)
    with pytest.raises(gi.WatcherError) as raised:
        gi.solve(problem, y0, observe={"it": Failing()}, **options)
    partial = raised.value.partial
    assert len(partial.y) == partial.steps + 1 > 2
    np.testing.assert_array_equal(partial.y[-1], partial.restart.memory[: problem.rows])
    if partial.tau[-1] == whole.tau[-1]:
        return
    rest = gi.solve(partial, save_every=1, **{key: end})
    np.testing.assert_array_equal(np.vstack((partial.y, rest.y[1:])), whole.y)
    np.testing.assert_array_equal(np.append(partial.tau, rest.tau[1:]), whole.tau)
