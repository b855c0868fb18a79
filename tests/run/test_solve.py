"""`solve`: where it ends, what it saves and watches, both times, and interruptions."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import signal
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import henon_heiles, pulsating_body, sphere_metric
from tests.problems import lotka_volterra, spherical_pendulum
from tests.run.motions import after_a_while, first, solve, swing

pytestmark = [
    pytest.mark.nojit,
    # Steps are as long as a test wants them.
    pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning"),
    pytest.mark.filterwarnings("ignore:step = .* is longer than the run"),
]

LOTKA, START = lotka_volterra.problem(), lotka_volterra.INITIAL
HENON = henon_heiles.problem(), henon_heiles.INITIAL
REDUCED = ch.ChaplyginSphere([0.5, 0.7, 0.9], 0.8).reduced()
BALL = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()  # in τ, with a clock
GAMMA = np.array([1.0, 2.0, 3.0]) / math.sqrt(14.0)
THROWN = np.array([0.3, -0.5, 0.2])
Y0 = BALL.state(gamma=GAMMA, p=THROWN - GAMMA * (GAMMA @ THROWN))


def lotka(t_end: float, method: str = "gauss-4", **more: Any) -> gi.Solution:
    return gi.solve(LOTKA, START, **{"t_end": t_end, "step": 0.1, "method": method, **more})


# --- ends -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("t_end", [1.0, 0.97, 0.05, -0.73, 3.1415])
def test_the_end_is_met_exactly(t_end: float) -> None:
    """By a last partial step, forwards and backwards, also if there is no whole step."""
    reference = lotka(t_end, "gauss-8", step=abs(t_end) / 50)
    for method, bound in (("rk-4", 1e-4), ("gauss-4", 1e-10)):
        sol = lotka(t_end, method, save_every=1)
        assert sol.t[-1] == t_end
        assert sol.steps == int(abs(t_end) / 0.1 + 1e-9)
        np.testing.assert_array_equal(sol.piece("u")[:, 0], sol.y[:, 0])
        np.testing.assert_allclose(sol.y[-1], reference.y[-1], rtol=0, atol=bound)
        whole = lotka(math.copysign(0.1 * max(sol.steps, 1), t_end), method, save_every=1)
        np.testing.assert_array_equal(sol.y[: sol.steps + 1], whole.y[: sol.steps + 1])


@given(st.floats(0.01, 1e3), st.integers(1, 3000), st.floats(0.4, 2000.0))
def test_steps_make_the_end(end: float, count: int, ratio: float) -> None:
    """For any ratio: the last time is the one asked for, whatever end/steps · steps rounds to."""
    given: dict[str, Any] = {"method": "rk-4", "save_every": 1, "progress": False}
    near = end * (1.0 + 5e-10) / count  # whole to 1e-9 is whole
    sol = gi.solve(swing(0.0), [0.0, 1.0], t_end=end, step=near, **given)
    assert sol.steps == count == len(sol.t) - 1
    assert (sol.t[0], sol.t[-1]) == (0.0, end)
    assert (np.diff(sol.t) > 0).all()
    sol = gi.solve(swing(0.0), [0.0, 1.0], t_end=-end, step=end / ratio, **given)
    assert sol.t[-1] == -end
    assert sol.step == pytest.approx(-end / ratio, rel=1e-8)
    assert sol.steps in {int(ratio), round(ratio)}
    steps = -np.diff(sol.t)
    assert 0 <= len(steps) - sol.steps <= 1
    np.testing.assert_allclose(steps[: sol.steps], -sol.step, rtol=1e-9)
    assert 0.0 < steps[-1] <= -sol.step * (1.0 + 1e-9)
    np.testing.assert_allclose(sol.y[:, 0], sol.t, rtol=1e-12)


def test_the_default_step() -> None:
    """A stated fraction of the shortest time in which a piece of the state changes."""
    problem, y0 = pulsating_body.problem(), pulsating_body.INITIAL
    rates = gi.derivative(problem, y0)
    time = min(np.linalg.norm(y0[p]) / np.linalg.norm(rates[p]) for p in problem.slices.values())

    def step(name: str, problem: gi.Problem, y: Any) -> float:
        method = gi.find_method(name)
        return method.default_step(problem, np.array(y), math.inf) / method.step_fraction

    for name in ("gauss-8", "rk-4", "cf-4"):
        assert step(name, problem, y0) == pytest.approx(time)
        expected = gi.find_method(name).step_fraction * time
        sol = gi.solve(problem, y0, t_end=10.0, method=name)
        near = 0.9 * expected <= sol.step <= expected * (1 + 1e-9)
        assert near or sol.steps == int(10 / expected)
    only_action = dataclasses.replace(problem, field=None)
    assert step("cf-4", only_action, y0) == pytest.approx(time, rel=1e-5)
    assert step("rk-4", first("rest", lambda p, t, y: 0.0 * y[0]), [1.0, 1.0]) == 1.0
    pendulum = dataclasses.replace(spherical_pendulum.problem(), field=None)
    assert 0.0 < step("rattle-2", pendulum, spherical_pendulum.INITIAL) < 2.0


@pytest.mark.filterwarnings("ignore:steps of .* more than is promised:geomint.GeomintWarning")
@pytest.mark.parametrize("method", ["gauss-2", "rk-4", "dormand-prince-5-adaptive"])
def test_default_steps_at_the_ends_of_numbers(method: str) -> None:
    """A number, whatever overflows on the way to it: a run, or an error that says where it was."""
    turn, hyperbola = swing(), first("hyperbola", lambda p, t, y: 1.0 / y[0])
    far_apart = [(turn, [1e300, 1e-300]), (turn, [-1e-200, 1e200])]
    for problem, y0 in [*far_apart, *((hyperbola, [y, 1.0]) for y in (5e-324, 1e-300, 1e300))]:
        for end in (1.0, 5e-324):
            try:
                found = gi.solve(problem, y0, t_end=end, method=method, compiled=False)
            except (gi.StepError, gi.DomainError) as error:
                found = error
            if isinstance(found, gi.DomainError):
                assert "give a step" in str(found)
            else:
                assert np.isfinite(found.t).all()
    exact = gi.solve(hyperbola, [1e300, 1.0], t_end=1.0, method=method, compiled=False)
    assert exact.y[-1, 0] == 1e300


# --- saving ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["rattle-2", "rattle-6", "gauss-2"])
def test_times_a_rounding_away_from_a_step(method: str) -> None:
    """No implicit step of 1e-16 is attempted."""
    problem = sphere_metric.problem()
    y0 = sphere_metric.initial(problem)
    grid = 0.1 * np.arange(31)
    beside = np.nextafter(grid[1:-1], 9), np.nextafter(grid[1:-1], -9)
    times = np.sort(np.concatenate([grid, *beside]))
    sol = gi.solve(problem, y0, t_end=3.0, step=0.1, method=method, t_eval=times)
    whole = gi.solve(problem, y0, t_end=3.0, step=0.1, method=method, save_every=1)
    nearest = np.rint(times / 0.1).astype(int)
    np.testing.assert_array_equal(sol.t, times)
    np.testing.assert_allclose(sol.y, whole.y[nearest], rtol=0, atol=1e-14)
    just_after = times >= whole.t[nearest]
    assert just_after.sum() > 50
    np.testing.assert_array_equal(sol.y[just_after], whole.y[nearest][just_after])


# --- two times ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("method", "tolerance"), [("gauss-8", 1e-12), ("rattle-6", 1e-7), ("dop853", 1e-9)]
)
def test_physical_times_are_met(method: str, tolerance: float) -> None:
    """On a problem in τ, for the end and for times in between, against a run in physical time."""
    times = np.array([0.0, 0.3, 1.0, 2.5, 4.0])
    run = {"step": 0.1, "method": method, "compiled": method != "dop853"}
    sol = gi.solve(BALL, Y0, t_end=4.0, **run, t_eval=times)
    np.testing.assert_array_equal(sol.t, times)
    assert sol.tau[0] == 0.0
    assert (np.diff(sol.tau) > 0).all()
    reduced = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).reduced()
    start = reduced.state(gamma=GAMMA, p=Y0[3:] * gi.value(BALL, BALL.clock, Y0))  # D√U p̃
    other = gi.solve(reduced, start, t_end=4.0, step=0.05, method="gauss-8", t_eval=times)
    for mine, theirs in zip(sol.y, other.y, strict=True):
        a, b = BALL.physical_state(mine), reduced.physical_state(theirs)
        for quantity, expected in b.items():
            np.testing.assert_allclose(a[quantity], expected, rtol=0, atol=tolerance)
    again = gi.solve(BALL, Y0, tau_end=float(sol.tau[-1]), **run)
    assert again.t[-1] == pytest.approx(4.0, rel=1e-14)


def test_what_lies_beyond_the_end_does_not_matter() -> None:
    """A failure after the end of a run is none."""
    steady = gi.observable(lambda params, t, y, work: 1.0 + 0.0 * y[0])
    falls: Any = {"clock": steady, "time": "tau"}
    clocked = first("clocked", lambda p, t, y: -0.5 / gi.sqrt(1.0 - t), **falls)
    sol = solve(clocked, [1.0, 1.0], t_end=0.9, step=0.05, method="rk-4")
    assert sol.success
    assert sol.y[-1, 0] == pytest.approx(math.sqrt(1 - 0.9), abs=1e-3)
    with pytest.raises(gi.NonFiniteError) as caught:
        solve(clocked, [1.0, 1.0], t_end=1.5, step=0.05, method="rk-4")
    assert caught.value.partial.t[-1] <= 1.01


def test_which_time_is_known() -> None:
    """A run without a clock has no physical times; a problem in t has no other."""
    run: dict[str, Any] = {"tau_end": 1.0, "step": 0.1}
    sol, timed = gi.solve(BALL, Y0, **run, clock=False), gi.solve(BALL, Y0, **run)
    with pytest.raises(gi.DomainError, match="physical time was not integrated"):
        sol.t
    assert sol.tau[-1] == 1.0
    np.testing.assert_allclose(timed.y, sol.y, rtol=0, atol=1e-14)
    with pytest.warns(gi.GeomintWarning, match="before 2 of the times in t_eval") as caught:
        sol = gi.solve(BALL, Y0, **run, t_eval=[0.5, 1e3, 1e4])
    assert caught[0].filename == __file__
    np.testing.assert_array_equal(sol.t, [0.5])  # where a run in τ ends in t is known afterwards


# --- watching -------------------------------------------------------------------------------------


def test_what_is_watched() -> None:
    """Groups, and functions of the user's own."""
    given: Any = {"t_end": 0.1, "step": 0.1, "method": "rk-4", "compiled": False}
    found = gi.solve(
        spherical_pendulum.problem(), spherical_pendulum.INITIAL, **given, observe="all"
    )
    assert list(found.drift) == ["energy", "angular-momentum", "norm", "tangency", "measure"]
    own = {"double": lambda params, t, y, work: 2.0 * y[1], "time": lambda params, t, y, work: t}
    drift = lotka(5.0, observe=own).drift
    assert drift["double"].initial == 2.0 * START[1]
    assert (drift["time"].final_error, drift["time"].max_abs_error) == (5.0, 5.0)
    assert drift["time"].slope == pytest.approx(1.0, rel=1e-12)


# --- interruptions and progress -------------------------------------------------------------------


def henon(**options: Any) -> gi.Solution:
    return gi.solve(*HENON, step=0.1, method="rk-4", **options)


def test_an_interrupted_run() -> None:
    """Leaves a state of the run at the time that it says, whenever Ctrl-C comes."""
    given: dict[str, Any] = {"save_every": 700, "observe": "energy"}
    henon(t_end=10.0, **given)
    with after_a_while(lambda *_: signal.raise_signal(signal.SIGINT)):
        sol = henon(t_end=1e8, **given)
    assert (sol.status, sol.success) == ("interrupted", False)
    assert 0 < sol.steps < 10**8
    assert sol.t[-1] == pytest.approx(0.1 * sol.steps)
    assert sol.iterations == sol.steps
    motion = gi.Integrator(*HENON, "rk-4", step=0.1)
    motion.step(sol.steps)
    np.testing.assert_array_equal(sol.y[-1], motion.state)


@pytest.mark.parametrize(("presses", "error"), [(2, KeyboardInterrupt), (1, TypeError)])
def test_an_interruption_that_numba_makes_an_error_of_is_one(presses: int, error: Any) -> None:
    """A second Ctrl-C while it reads the types of functions; other errors stay what they are."""

    def happens(*_: Any) -> None:
        with contextlib.suppress(KeyboardInterrupt):
            for _ in range(presses):
                signal.raise_signal(signal.SIGINT)
        raise TypeError("_get_wrapper_address() missing 1 required positional argument: 'sig'")

    henon(t_end=10.0)
    with pytest.raises(error) as raised, after_a_while(happens):
        henon(t_end=1e8)
    assert isinstance(raised.value if error is TypeError else raised.value.__context__, TypeError)


@pytest.mark.parametrize("asked", [{}, {"observe": "all"}, {"t_end": 0.2}])
def test_an_interrupted_run_is_whole_or_raises(asked: dict[str, Any]) -> None:
    """However short: functions in Python are not broken off, nor runs of unknown length."""
    end, found = {} if "t_end" in asked else {"tau_end": 0.2}, []
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        run: dict[str, Any] = {**asked, **end, "progress": False, "compiled": False}
        look = lambda told: found.append(signal.getsignal(signal.SIGINT))  # noqa: E731
        gi.solve(BALL, Y0, step=0.05, callback=look, **run)
    finally:
        signal.signal(signal.SIGINT, before)
    assert found
    assert signal.default_int_handler not in found


def test_progress_and_costs(capsys: pytest.CaptureFixture[str]) -> None:
    """Progress is off where there is no terminal, and changes nothing; steps and time are told."""
    quiet = henon(t_end=10.0)
    assert capsys.readouterr() == ("", "")
    assert henon(t_end=10.0, progress=True) == quiet
    assert capsys.readouterr().out == ""
    assert (quiet.steps, quiet.iterations, quiet.evaluations) == (100, 100, 400)
    assert quiet.run_seconds > 0.0
    assert quiet.compile_seconds >= 0.0


# --- runs of no length ------------------------------------------------------------------------------

NO_STEPS = ["gauss-8", "rk-4", "dop853-adaptive", "auto"]
NO_STEPS += [pytest.param("exact", marks=pytest.mark.nightly)]


@pytest.mark.parametrize("method", NO_STEPS)
def test_a_run_of_no_length(method: str) -> None:
    """The initial state, watched once; and a run that goes on from there is one from the beginning."""
    y0 = REDUCED.random_state(3)
    run: dict[str, Any] = {"t0": 2.5, "t_end": 2.5, "method": method}
    run |= {"tolerance": 1e-8} if method == "auto" else {}
    sol = solve(REDUCED, y0, **run, dense=True, events=["gamma[0]"], observe=["energy"])
    assert (sol.success, sol.steps, len(sol.t_events[0])) == (True, 0, 0)
    assert sol.t.tolist() == [2.5]
    np.testing.assert_allclose(sol.y, [y0], rtol=0, atol=1e-14 * (method == "exact"))
    np.testing.assert_array_equal(sol.sol(2.5), sol.y[0])
    assert sol.drift["energy"].windows.max_abs == 0.0
    asked = solve(REDUCED, y0, **run, t_eval=[2.5, 2.5])
    np.testing.assert_array_equal(asked.y, [sol.y[0]] * 2)
    with pytest.raises(gi.DomainError, match="t_eval"):
        solve(REDUCED, y0, **run, t_eval=[3.5])
    if method == "rk-4":
        members = gi.solve_ensemble(HENON[0], [HENON[1]] * 2, **run)
        np.testing.assert_array_equal(members.final, [HENON[1]] * 2)
    for far in (0.0, 1e17, -1e300) if method != "exact" else ():  # to which no step leads
        for options in ({}, {"step": 0.1}) if method != "auto" else ({},):
            sol = solve(REDUCED, y0, **{**run, "t0": far, "t_end": far}, **options)
            assert (sol.t.tolist(), sol.steps) == ([far], 0)


def test_a_run_of_no_length_goes_on() -> None:
    y0, run = REDUCED.random_state(3), {"t0": 2.5, "t_end": 2.5, "method": "rk-4"}
    more = solve(solve(REDUCED, y0, **run), t_end=3.5)
    whole = solve(REDUCED, y0, **{**run, "t_end": 3.5, "step": abs(more.step)})
    np.testing.assert_array_equal(more.y[-1], whole.y[-1])
    kept = solve(REDUCED, y0, **run, step=0.1, save_every=1, estimate_error=True)
    np.testing.assert_array_equal(kept.error_estimate, np.zeros_like(kept.error_estimate))
    for end in ({"t_end": 0.0}, {"tau_end": 0.0}):  # in τ, by either end
        sol = solve(BALL, Y0, **end, method="gauss-8")
        assert (sol.t.tolist(), sol.tau.tolist(), sol.y.tolist()) == ([0.0], [0.0], [Y0.tolist()])
    flow = gi.tangent_flow(swing(), [0.3, 0.4], t_end=0.0, method="rk-4")
    np.testing.assert_array_equal(flow.slopes, np.eye(2))
