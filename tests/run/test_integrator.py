"""An integrator in the hand: the bits of `solve`, whatever is done to it between steps."""

from __future__ import annotations

import copy
import dataclasses
import math
import pickle
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.run import driver
from geomint.run.wanted import Wanted
from tests.families import KINDS, PROBLEMS, kinds, pairs
from tests.run.motions import TIMED, Integrator, first, solve

H = 0.05
LOTKA, START = PROBLEMS["lotka-volterra"]
ADAPTIVE = "dormand-prince-5-adaptive"
METHODS = pytest.mark.parametrize("method", ["gauss-3", "rk-4", ADAPTIVE])
FIXED = [pair for pair in KINDS if "adaptive" not in pair[0]]


def made(name: str, problem: str, **options: Any) -> gi.Integrator:
    p, y0 = PROBLEMS[problem]
    return Integrator(p, y0, name, step=H, compiled=name == "rk-4", **options)


def same(one: gi.Integrator, other: gi.Integrator) -> None:
    np.testing.assert_array_equal(one.restart.memory, other.restart.memory)
    assert (one.time, one.steps, one.h) == (other.time, other.steps, other.h)
    assert one.iterations == other.iterations


@kinds
def test_steps_one_by_one_are_steps_at_once(name: str, problem: str) -> None:
    """So are those of copies and pickles, which go on by themselves, and those of `solve`."""
    one, other = made(name, problem), made(name, problem)
    one.step(8)
    for n in (1, 0, 2):
        other.step(n)
    others = [copy.copy(other), copy.deepcopy(other), pickle.loads(pickle.dumps(other))]
    before = other.state
    for each in others:
        each.step(5)
    np.testing.assert_array_equal(other.state, before)
    other.step(1)
    other.step(4)
    for each in (*others, other):
        same(one, each)
    assert one.steps == 8
    if (name, problem) in FIXED:
        solution = solve(*PROBLEMS[problem], method=name, step=H, t_end=9 * H)
        one.propagate_until(9 * H)
        assert (solution.steps, solution.t[-1]) == (one.steps, one.time) == (9, 9 * H)
        np.testing.assert_array_equal(one.state, solution.y[-1])


@kinds
def test_there_and_back_and_from_there(name: str, problem: str) -> None:
    """A time is met exactly, whatever lies between; what is written is a new beginning."""
    p, y0 = PROBLEMS[problem]
    motion = made(name, problem)
    for end in (0.123, 0.123, 0.2, 0.20000000000000007, 0.4):
        motion.propagate_until(end)
        assert motion.time == end
    motion.propagate_for(-0.2)
    assert motion.time == 0.4 - 0.2
    motion.propagate_until(0.0)
    assert motion.time == 0.0
    np.testing.assert_allclose(motion.state, y0, atol=1e-4)
    motion.reset()
    np.testing.assert_array_equal(motion.state, y0)
    assert (motion.time, motion.steps, motion.iterations) == (0.0, 0, 0)
    motion.step(3)
    state, time = motion.state, motion.time
    motion.state = state
    other = Integrator(p, state, name, step=motion.h, time=time)
    for each in (motion, other):
        each.step(5)
    np.testing.assert_array_equal(motion.state, other.state)
    assert motion.time == pytest.approx(other.time, rel=1e-15)
    motion.time = 3.0
    assert motion.time == 3.0
    motion.h = 0.5 * H
    motion.step()
    assert motion.time == 3.0 + 0.5 * H


def test_parameters_are_read_and_written() -> None:
    motion = Integrator(LOTKA, START, "gauss-3", step=0.02)
    motion.step(3)
    params, state = motion.params, motion.state
    motion.params = 2.0 * params
    np.testing.assert_array_equal(motion.params, 2.0 * params)
    np.testing.assert_array_equal(motion.state, state)
    assert motion.steps == 3
    twice = dataclasses.replace(LOTKA, params=2.0 * params, parameters={})
    other = Integrator(twice, state, "gauss-3", step=0.02, time=motion.time)
    for each in (motion, other):
        each.step(10)
    np.testing.assert_array_equal(motion.state, other.state)
    np.testing.assert_array_equal(LOTKA.params, params)
    for bad in (params[:-1], [*params, 1.0], "no", [math.nan] * len(params)):
        with pytest.raises(gi.DomainError):
            motion.params = bad


def test_physical_time_beside_tau() -> None:
    """It is kept when a state is written, and goes on in a solution."""
    motion = Integrator(TIMED, START, "gauss-3", step=0.1, clock=True)
    motion.step(5)
    run = {"step": 0.1, "method": "gauss-3"}
    solution = solve(TIMED, START, tau_end=0.5, clock=True, **run)
    assert (motion.t, motion.time) == (solution.t[-1], solution.tau[-1])
    state, t = motion.state, motion.t
    motion.state = state
    assert motion.t == t
    np.testing.assert_array_equal(motion["v"], state[1:])
    motion.reset()
    assert motion.t == motion.time == 0.0
    without = Integrator(TIMED, START, "gauss-3", step=0.1)
    for ask, said in ((lambda: without.t, "clock"), (lambda: without["vv"], "v")):
        with pytest.raises(gi.DomainError, match=said):
            ask()
    whole, half = (solve(TIMED, START, t_end=end, **run) for end in (1.6, 0.8))
    rest = solve(pickle.loads(pickle.dumps(half)), t_end=1.6, t_eval=[1.2, 1.6])
    np.testing.assert_array_equal(rest.y[-1], whole.y[-1])
    np.testing.assert_array_equal(rest.t, [1.2, 1.6])
    with pytest.raises(gi.DomainError):
        solve(half, t_end=4.0, step=0.2)


@METHODS
def test_after_an_error_it_is_where_it_was(method: str) -> None:
    """y = 1/(1 − t) ends at 1: before the step that fails all is as it was, and goes on from there."""
    problem = first("runaway", lambda p, t, y: y[0] * y[0])
    motion = Integrator(problem, [1.0, 1.0], method, step=0.02)
    with pytest.raises(gi.StepError) as raised:
        motion.propagate_until(1e6) if "adaptive" in method else motion.step(10**6)
    assert np.isfinite(motion.state).all()
    assert raised.value.step == motion.steps > 10
    assert raised.value.t == pytest.approx(motion.time)
    motion.state = [1.0, 1.0]
    motion.time = 0.0
    motion.propagate_until(0.5)
    np.testing.assert_allclose(motion.state, [2.0, 1.0], rtol=1e-6)


@gi.field
def row_of_state(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0], out[1] = y[int(params[0] * y[1])], 1.0


def test_rows_that_are_not_there() -> None:
    """By parameters that would lead to them."""
    problem = gi.Problem("rows", (("y", 2),), [1.0], field=row_of_state)
    motion = Integrator(problem, [1.0, 0.0], "rk-4", step=0.01)
    motion.step()
    state = motion.state
    with pytest.raises(gi.DeclarationError, match=r"reads row \d+"):
        motion.params = [700.0]
    np.testing.assert_array_equal(motion.params, [1.0])
    np.testing.assert_array_equal(motion.state, state)


DRIVEN = first("driven", lambda p, t, y: gi.cos(t))


@METHODS
def test_what_is_refused(method: str) -> None:
    """Numbers that are none, and other names; all stays as it was."""
    motion = Integrator(LOTKA, START, method, step=0.02)
    for call, values in (
        (motion.step, (-1, 1.5, "3", True, None)),
        (motion.propagate_until, (math.inf, math.nan, "soon", None)),
        (lambda x: setattr(motion, "time", x), (math.inf, math.nan, "soon", None)),
        (lambda x: setattr(motion, "state", x), ([math.nan] * LOTKA.rows, [1.0], "x")),
        (lambda x: setattr(motion, "h", x), (0.0, math.nan)),
    ):
        for value in values:
            with pytest.raises(gi.DomainError):
                call(value)
    for name in ("step", "y", "t", "problem", "method"):
        with pytest.raises(AttributeError):
            setattr(motion, name, 0.02)
    assert (motion.time, motion.steps, motion.h) == (0.0, 0, 0.02)
    for arguments in ((lambda t, y: y, START), (LOTKA, START, "no-such-method")):
        with pytest.raises(gi.GeomintError):
            Integrator(*arguments)
    with pytest.raises(gi.DomainError):
        Integrator(LOTKA, START, step=-0.1)
    with pytest.raises(gi.FormError, match="its own time is physical"):
        Integrator(LOTKA, START, clock=True)


@METHODS
def test_times_that_no_steps_lead_to(method: str) -> None:
    """Too many steps, or beyond all numbers: refused, or a step that fails, never a time of inf."""
    far = ({"time": -1.7e308}, 1.7e308), ({"step": 1e-300}, 1e300), ({}, -1e300)
    for options, end in far if "adaptive" not in method else ():
        motion = Integrator(LOTKA, START, method, **{"step": 0.1, **options})
        with pytest.raises(gi.DomainError, match=r"2⁵³ steps|rounding of times"):
            motion.propagate_until(end)
        assert (motion.time, motion.steps) == (options.get("time", 0.0), 0)
        assert motion.h > 0.0
    motion = Integrator(DRIVEN, [0.0, 0.0], method, step=1e308)
    with pytest.raises((gi.DomainError, gi.StepError)):
        motion.step(4000)
    assert math.isfinite(motion.time)
    for late in (1e17, -1e300):  # steps of less than a rounding would see a force at one time alone
        end = math.nextafter(late, 0.0)
        motion = Integrator(DRIVEN, [0.0, 0.0], method, step=0.1, time=late)
        said = r"least|step size does not serve"
        for go in (motion.step, lambda end=end, motion=motion: motion.propagate_until(end)):
            with pytest.raises((gi.DomainError, gi.StepError), match=said):
                go()
            assert (motion.time, motion.steps) == (late, 0)
        with pytest.raises((gi.DomainError, gi.StepError)):
            solve(DRIVEN, [0.0, 0.0], t0=late, t_end=end, step=0.1, method=method)
        motion.step(0)


# --- runs that go on ------------------------------------------------------------------------------


@pairs(FIXED, [pair for pair in KINDS if pair[0] in ("rk-4", "cf-4", "gauss-8", "rattle-2")])
def test_a_solution_goes_on_to_the_same_bits(name: str, problem: str) -> None:
    """Ends on a step and between two: what is saved further on is that of one run."""
    options: dict[str, Any] = {"method": name, "step": H, "save_every": 1}
    whole = solve(*PROBLEMS[problem], t_end=16 * H, **options)
    for end in (8 * H, 7.3 * H):
        first = solve(*PROBLEMS[problem], t_end=end, **options)
        second = solve(first, t_end=16 * H, save_every=1)
        assert first.steps + second.steps == whole.steps == 16
        np.testing.assert_array_equal(second.y[-7:], whole.y[-7:])
        np.testing.assert_array_equal(second.t[-7:], whole.t[-7:])


@METHODS
@pytest.mark.parametrize(("begin", "end"), [(5.0, 9.0), (-3.0, 1.0), (2.0, -2.0)])
def test_a_run_may_begin_at_another_time(method: str, begin: float, end: float) -> None:
    """ẏ = cos t, whose solution is sin t: forwards and backwards, states and drifts at their times."""
    times, known = np.linspace(begin, end, 5), gi.observable(lambda p, t, y, w: y[0] - gi.sin(t))
    run = {"t0": begin, "t_end": end, "step": {"gauss-3": 0.25}.get(method, 0.05), "method": method}
    found = solve(DRIVEN, [math.sin(begin), 0.0], **run, t_eval=times, observe={"y": known})
    np.testing.assert_array_equal(found.t, times)
    np.testing.assert_allclose(found.y[:, 0], np.sin(times), atol=1e-6)
    assert found.drift["y"].max_abs_error < 1e-6
    assert found.drift["y"].windows.last_time == end
    longer = solve(found, t_end=end + (end - begin))
    np.testing.assert_allclose(longer.y[-1, 0], np.sin(2 * end - begin), atol=1e-5)


def test_the_beginning_is_no_time_of_the_run() -> None:
    run = {"step": 0.1, "method": "rk-4"}
    for wrong in ({"t_end": math.inf}, *({"t_end": 9.0, "t_eval": [t]} for t in (4.0, 9.5))):
        with pytest.raises(gi.DomainError):
            solve(DRIVEN, [0.0, 0.0], t0=5.0, **run, **wrong)
    with pytest.raises(gi.DomainError, match="at a finite distance"):
        solve(DRIVEN, [0.0, 0.0], t0=-1.7e308, t_end=1.7e308, **run)
    for wrong in (math.nan, math.inf, "now", None):
        with pytest.raises(gi.DomainError, match="t0"):
            solve(DRIVEN, [0.0, 0.0], t0=wrong, t_end=1.0)
    first = solve(DRIVEN, [0.0, 0.0], t_end=1.0, **run)
    with pytest.raises(gi.DomainError, match="t0"):
        solve(first, t0=1.0, t_end=2.0)


@pytest.mark.parametrize("call", [1, 2, 5])
def test_no_state_is_lost_where_ctrl_c_comes(call: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """While states at wanted times are made: the run goes on before the next of them."""
    times = np.linspace(0.013, 9.97, 40)
    options: dict[str, Any] = {"method": "rk-4", "step": H, "t_end": 10.0}
    whole = solve(LOTKA, START, t_eval=times, **options)
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
        first = solve(LOTKA, START, t_eval=times, **options)
    assert first.status == "interrupted"
    assert (len(first.t) > 0) == (call > 1)
    rest = solve(first, t_end=10.0, t_eval=times[len(first.t) :])
    np.testing.assert_array_equal(np.append(first.t, rest.t), times)
    np.testing.assert_array_equal(np.vstack((first.y, rest.y)), whole.y)


class Failing(gi.Watcher):
    """What fails, after some seconds, with the first chunk that has gone so far."""

    def begin(self, run: Any) -> float:
        return 0.0

    def values(self, times: Any, states: Any, lengths: Any) -> Any:
        if abs(times[-1]) > 0.5:
            raise ValueError("no more")
        return np.zeros(len(times))


@pytest.mark.parametrize("method", ["gauss-3", ADAPTIVE])
@pytest.mark.parametrize("key", ["t_end", "tau_end"])
@pytest.mark.parametrize("end", [3.0, -3.0])
def test_what_a_failed_watcher_leaves_goes_on(
    method: str, key: str, end: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From its last state, which is within the run; and every step before is saved."""
    monkeypatch.setattr(driver, "FIRST_CHUNK", 3)
    options: dict[str, Any] = {key: end, "method": method, "step": 0.1, "save_every": 1}
    whole = solve(TIMED, START, **options)
    with pytest.raises(gi.WatcherError) as raised:
        solve(TIMED, START, observe={"it": Failing()}, **options)
    partial = raised.value.partial
    assert 2 < len(partial.y) == partial.steps + 1 < len(whole.y)
    np.testing.assert_array_equal(partial.y[-1], partial.restart.memory[: TIMED.rows])
    rest = solve(partial, save_every=1, **{key: end})
    np.testing.assert_array_equal(np.vstack((partial.y, rest.y[1:])), whole.y)
    np.testing.assert_array_equal(np.append(partial.tau, rest.tau[1:]), whole.tau)
