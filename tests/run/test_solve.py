"""`solve`: where it ends, what it saves and watches, both times, and interruptions."""

from __future__ import annotations

import dataclasses
import itertools
import math
import signal
import warnings

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numba.core import config
from scipy.integrate import quad
from scipy.interpolate import BarycentricInterpolator

import chaplygin as ch
import geomint as gi
from geomint.methods.stepper import Stepper
from geomint.problems.testproblems import henon_heiles, pulsating_body, sphere_metric
from geomint.problems.time_scale import characteristic_time
from geomint.run import driver
from geomint.run.progress import Progress
from geomint.run.timeline import plan_timeline
from geomint.watch.observe import Observers
from tests.problems import lotka_volterra, spherical_pendulum

pytestmark = [
    pytest.mark.nojit,
    # Steps are as long as a test wants them.
    pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning"),
]
compiler = pytest.mark.skipif(config.DISABLE_JIT, reason="too many steps for plain Python")

LOTKA = lotka_volterra.problem()
START = lotka_volterra.INITIAL


def ball() -> tuple[gi.Problem, np.ndarray]:
    """A problem in τ with a clock."""
    problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
    gamma = np.array([1.0, 2.0, 3.0]) / math.sqrt(14.0)
    p = np.array([0.3, -0.5, 0.2])
    return problem, problem.state(gamma=gamma, p=p - gamma * (gamma @ p))


# --- ends -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("t_end", [1.0, 0.97, 0.05, -0.73, 3.1415])
@pytest.mark.parametrize("method", ["rk-4", "gauss-4"])
@pytest.mark.filterwarnings("ignore:step = 0.1 is longer than the run")
def test_the_end_is_met_exactly(method: str, t_end: float) -> None:
    """By a last partial step, forwards and backwards, also if there is no whole step."""
    sol = gi.solve(LOTKA, START, t_end=t_end, step=0.1, method=method)
    reference = gi.solve(LOTKA, START, t_end=t_end, step=abs(t_end) / 50, method="gauss-8")
    assert sol.t[-1] == t_end
    assert sol.steps == int(abs(t_end) / 0.1 + 1e-9)
    np.testing.assert_allclose(
        sol.y[-1], reference.y[-1], rtol=0, atol=1e-4 if method == "rk-4" else 1e-10
    )


def test_a_partial_step_is_a_step() -> None:
    """Ten steps and a half are what they are one by one."""
    long = gi.solve(LOTKA, START, t_end=1.05, step=0.1, method="rk-4", save_every=1)
    whole = gi.solve(LOTKA, START, t_end=1.0, step=0.1, method="rk-4", save_every=1)
    np.testing.assert_array_equal(long.y[:11], whole.y)
    assert list(long.t[-2:]) == [1.0, 1.05]


@given(st.floats(0.01, 1e3), st.integers(1, 3000))
def test_the_last_time_is_the_one_asked_for(end: float, count: int) -> None:
    """Whatever end/steps · steps rounds to."""
    timeline = plan_timeline(LOTKA, gi.RungeKutta("rk-4"), START, t_end=end, step=end / count)
    assert timeline.steps == count
    assert timeline.remainder == 0.0
    steps = np.arange(count + 1)
    times = timeline.met(timeline.h * steps, steps)
    assert times[0] == 0.0
    assert times[-1] == end
    assert (np.diff(times) > 0).all()


@given(st.floats(0.01, 1e3), st.floats(1e-3, 1e3))
def test_steps_and_remainder_make_the_end(end: float, step: float) -> None:
    """For any ratio."""
    timeline = plan_timeline(LOTKA, gi.RungeKutta("rk-4"), START, t_end=-end, step=step)
    assert timeline.steps is not None
    assert timeline.h < 0
    assert abs(timeline.h) == pytest.approx(step, rel=1e-8)
    assert timeline.h * timeline.steps + timeline.remainder == pytest.approx(-end, rel=1e-12)
    assert 0.0 <= -timeline.remainder <= step


def test_backwards_undoes_forwards() -> None:
    """For a symmetric method of an autonomous problem, to rounding."""
    problem, y0 = henon_heiles.problem(), henon_heiles.INITIAL
    there = gi.solve(problem, y0, t_end=20.0, step=0.1, method="gauss-4")
    back = gi.solve(problem, there.y[-1], t_end=-20.0, step=0.1, method="gauss-4")
    np.testing.assert_allclose(back.y[-1], y0, rtol=0, atol=1e-13)
    assert back.step == -0.1
    assert back.t[-1] == -20.0


def test_backwards_in_physical_time() -> None:
    """The clock runs back, too."""
    problem, y0 = ball()
    sol = gi.solve(problem, y0, t_end=-3.0, step=0.1, method="gauss-6", save_every=5)
    assert sol.t[0] == 0.0
    assert sol.t[-1] == -3.0
    assert (np.diff(sol.t) < 0).all()
    assert (np.diff(sol.tau) < 0).all()
    back = gi.solve(problem, sol.y[-1], t_end=3.0, step=0.1, method="gauss-6")
    np.testing.assert_allclose(back.y[-1], y0, rtol=0, atol=1e-13)


def test_the_default_step() -> None:
    """A stated fraction of the shortest time in which a piece of the state changes."""
    problem, y0 = pulsating_body.problem(), pulsating_body.INITIAL
    rates = (
        np.linalg.norm(_derivative(problem, y0)[:3]),
        np.linalg.norm(_derivative(problem, y0)[3:]),
    )
    times = np.linalg.norm(y0[:3]) / rates[0], np.linalg.norm(y0[3:]) / rates[1]
    assert characteristic_time(problem, y0) == pytest.approx(min(times))
    for method in (gi.Gauss(8), gi.RungeKutta("rk-4"), gi.CommutatorFree("cf-4")):
        expected = method.step_fraction * min(times)
        assert method.default_step(problem, y0, math.inf) == pytest.approx(expected)
        sol = gi.solve(problem, y0, t_end=10.0, method=method)
        assert 0.9 * expected <= sol.step <= expected * (1 + 1e-9) or sol.steps == int(
            10 / expected
        )
    only_action = dataclasses.replace(problem, field=None)
    assert characteristic_time(only_action, y0) == pytest.approx(min(times), rel=1e-5)
    at_rest = gi.Problem("rest", (("y", 1),), field=_nothing)
    assert characteristic_time(at_rest, np.ones(1)) == 1.0
    pendulum = dataclasses.replace(spherical_pendulum.problem(), field=None)
    assert 0.0 < characteristic_time(pendulum, spherical_pendulum.INITIAL) < 2.0


@gi.field
def _nothing(params, t, y, out, work):
    out[0] = 0.0 * y[0]


def _derivative(problem: gi.Problem, y: np.ndarray) -> np.ndarray:
    from geomint.problems.evaluate import derivative

    return derivative(problem, y)


# --- saving ---------------------------------------------------------------------------------------


def test_what_is_saved() -> None:
    """The last state; every k-th with the first and the last; the times asked for, in order."""
    whole = gi.solve(LOTKA, START, t_end=2.0, step=0.1, method="gauss-4", save_every=1)
    np.testing.assert_allclose(whole.t, 0.1 * np.arange(21), rtol=0, atol=1e-15)
    np.testing.assert_array_equal(whole.y[0], START)
    last = gi.solve(LOTKA, START, t_end=2.0, step=0.1, method="gauss-4")
    np.testing.assert_array_equal(last.t, [2.0])
    np.testing.assert_array_equal(last.y, whole.y[-1:])
    some = gi.solve(LOTKA, START, t_end=2.0, step=0.1, method="gauss-4", save_every=7)
    np.testing.assert_array_equal(some.y, whole.y[[0, 7, 14, 20]])
    rare = gi.solve(LOTKA, START, t_end=2.0, step=0.1, method="gauss-4", save_every=1000)
    np.testing.assert_array_equal(rare.y, whole.y[[0, 20]])
    both = gi.solve(
        LOTKA, START, t_end=2.0, step=0.1, method="gauss-4", save_every=5, t_eval=[0.05, 0.72, 1.95]
    )
    assert both.t == pytest.approx([0.0, 0.05, 0.5, 0.72, 1.0, 1.5, 1.95, 2.0])
    assert len(both.y) == 8
    np.testing.assert_array_equal(whole.piece("u")[:, 0], whole.y[:, 0])
    with pytest.raises(gi.DomainError, match="piece = 'w'"):
        whole.piece("w")
    np.testing.assert_array_equal(whole.tau, whole.t)


def dense(problem: gi.Problem, y0: np.ndarray, t_end: float) -> BarycentricInterpolator:
    """The solution as a polynomial through Chebyshev points, itself integrated piece by piece."""
    nodes = 0.5 * t_end * (1.0 - np.cos(np.pi * np.arange(41) / 40))
    return BarycentricInterpolator(
        nodes,
        gi.solve(problem, y0, t_end=t_end, step=t_end / 40, method="gauss-12", t_eval=nodes).y,
    )


@pytest.mark.parametrize("method", ["gauss-6", "dop853"])
def test_times_asked_for(method: str) -> None:
    """Met by partial steps, with the accuracy of the method and no trace in the run."""
    times = np.array([0.0, 1e-9, 0.03, 0.1, 0.15, 0.15, 1.234, 1.999999, 2.0])
    sol = gi.solve(LOTKA, START, t_end=2.0, step=0.05, method=method, t_eval=times)
    np.testing.assert_array_equal(sol.t, times)
    np.testing.assert_array_equal(sol.y[0], START)
    np.testing.assert_allclose(sol.y, dense(LOTKA, START, 2.0)(times), rtol=0, atol=2e-13)
    undisturbed = gi.solve(LOTKA, START, t_end=2.0, step=0.05, method=method)
    np.testing.assert_array_equal(sol.y[-1], undisturbed.y[-1])
    assert sol.iterations == undisturbed.iterations


def test_times_asked_for_without_end_in_sight() -> None:
    """Any increasing times within the run; a scalar; none."""
    one = gi.solve(LOTKA, START, t_end=2.0, step=0.1, method="rk-4", t_eval=1.05)
    np.testing.assert_array_equal(one.t, [1.05])
    back = gi.solve(LOTKA, START, t_end=-2.0, step=0.1, method="gauss-4", t_eval=[-0.5, -1.5])
    np.testing.assert_array_equal(back.t, [-0.5, -1.5])
    direct = gi.solve(LOTKA, START, t_end=-1.5, step=0.1, method="gauss-4")
    np.testing.assert_allclose(back.y[-1], direct.y[-1], rtol=0, atol=1e-10)


@pytest.mark.parametrize("method", ["rattle-2", "rattle-6", "gauss-2"])
def test_times_a_rounding_away_from_a_step(method: str) -> None:
    """No implicit step of 1e-16 is attempted."""
    problem = sphere_metric.problem()
    y0 = sphere_metric.initial(problem)
    grid = 0.1 * np.arange(31)
    times = np.sort(
        np.concatenate([grid, np.nextafter(grid[1:-1], 9), np.nextafter(grid[1:-1], -9)])
    )
    sol = gi.solve(problem, y0, t_end=3.0, step=0.1, method=method, t_eval=times)
    whole = gi.solve(problem, y0, t_end=3.0, step=0.1, method=method, save_every=1)
    nearest = np.rint(times / 0.1).astype(int)
    np.testing.assert_array_equal(sol.t, times)
    np.testing.assert_allclose(sol.y, whole.y[nearest], rtol=0, atol=1e-14)
    just_after = times >= whole.t[nearest]
    assert just_after.sum() > 50
    np.testing.assert_array_equal(sol.y[just_after], whole.y[nearest][just_after])


# --- two times ------------------------------------------------------------------------------------


@compiler
def test_the_clock_is_the_integral_of_its_rate() -> None:
    """t(τ) = ∫ dt/dτ along the flow, by adaptive quadrature of a dense solution in τ."""
    from geomint.problems.evaluate import value

    problem, y0 = ball()
    sol = gi.solve(problem, y0, tau_end=3.0, step=0.05, method="gauss-8")
    nodes = 1.5 * (1.0 - np.cos(np.pi * np.arange(61) / 60))
    states = [y0]
    for a, b in itertools.pairwise(nodes):
        states.append(
            gi.solve(problem, states[-1], tau_end=b - a, step=(b - a) / 2, method="gauss-12").y[-1]
        )
    flow = BarycentricInterpolator(nodes, np.array(states))
    integral, _ = quad(
        lambda tau: value(problem, problem.clock, flow(tau)), 0.0, 3.0, epsabs=1e-13, epsrel=1e-13
    )
    assert sol.tau[-1] == 3.0
    assert sol.t[-1] == pytest.approx(integral, rel=1e-12)
    rattle = gi.solve(problem, y0, tau_end=3.0, step=0.02, method="rattle-6")
    assert rattle.t[-1] == pytest.approx(integral, rel=1e-8)


@pytest.mark.parametrize(
    ("method", "tolerance"), [("gauss-8", 1e-12), ("rattle-6", 1e-7), ("dop853", 1e-9)]
)
def test_physical_times_are_met(method: str, tolerance: float) -> None:
    """On a problem in τ, for the end and for times in between, against a run in physical time."""
    problem, y0 = ball()
    times = np.array([0.0, 0.3, 1.0, 2.5, 4.0])
    sol = gi.solve(problem, y0, t_end=4.0, step=0.1, method=method, t_eval=times)
    np.testing.assert_array_equal(sol.t, times)
    assert sol.tau[0] == 0.0
    assert (np.diff(sol.tau) > 0).all()
    reduced = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).reduced()
    physical = problem.physical_state(y0)
    start = reduced.state(gamma=physical["gamma"], p=_p_of(problem, y0))
    other = gi.solve(reduced, start, t_end=4.0, step=0.05, method="gauss-8", t_eval=times)
    for mine, theirs in zip(sol.y, other.y, strict=True):
        a, b = problem.physical_state(mine), reduced.physical_state(theirs)
        for quantity, expected in b.items():
            np.testing.assert_allclose(a[quantity], expected, rtol=0, atol=tolerance)


def _p_of(problem: gi.Problem, y: np.ndarray) -> np.ndarray:
    """p = D√U p̃, read off k = γ∧p."""
    from geomint.problems.evaluate import value

    return y[3:] * value(problem, problem.clock, y)


def test_an_end_in_physical_time() -> None:
    """Is met by a partial step; costs and states do not depend on what was computed beyond it."""
    problem, y0 = ball()
    sol = gi.solve(problem, y0, t_end=4.0, step=0.1, method="gauss-8", save_every=1, observe="all")
    assert sol.t[-1] == 4.0
    assert (np.diff(sol.t) > 0).all()
    assert sol.steps == len(sol.t) - 2
    assert sol.tau[-2] == pytest.approx(0.1 * sol.steps)
    assert sol.tau[-2] < sol.tau[-1] <= sol.tau[-2] + 0.1
    again = gi.solve(problem, y0, tau_end=float(sol.tau[-1]), step=0.1, method="gauss-8")
    np.testing.assert_allclose(again.y[-1], sol.y[-1], rtol=0, atol=1e-13)
    assert again.t[-1] == pytest.approx(4.0, rel=1e-14)
    assert again.iterations == sol.iterations


@compiler
def test_the_end_does_not_depend_on_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither do the numbers of steps and iterations, though the run goes past it."""
    problem, y0 = ball()
    found = []
    for chunk in (1, 3, 1000):
        monkeypatch.setattr(driver, "FIRST_CHUNK", chunk)
        sol = gi.solve(
            problem, y0, t_end=4.0, step=0.1, method="gauss-4", observe="K", t_eval=[1, 4]
        )
        found.append(
            (sol.steps, sol.iterations, tuple(sol.y.ravel()), sol.drift["K"].max_abs_error)
        )
    assert len(set(found)) == 1


def test_what_lies_beyond_the_end_does_not_matter() -> None:
    """A failure after the end of a run is none."""
    clocked = gi.Problem("clocked", (("y", 1),), field=_falling, clock=_steady, time="tau")
    sol = gi.solve(clocked, [1.0], t_end=0.9, step=0.05, method="rk-4")
    assert sol.success
    assert sol.y[-1, 0] == pytest.approx(math.sqrt(1 - 0.9), abs=1e-3)
    with pytest.raises(gi.NonFiniteError) as caught:
        gi.solve(clocked, [1.0], t_end=1.5, step=0.05, method="rk-4")
    assert caught.value.partial.t[-1] <= 1.01


@gi.field
def _falling(params, t, y, out, work):
    out[0] = -0.5 / gi.sqrt(1.0 - t)


@gi.field
def _steady(params, t, y, work):
    return 1.0 + 0.0 * y[0]


def test_which_time_is_known() -> None:
    """A run without a clock has no physical times; a problem in t has no other."""
    problem, y0 = ball()
    sol = gi.solve(problem, y0, tau_end=1.0, step=0.1, clock=False)
    with pytest.raises(gi.DomainError, match="physical time was not integrated"):
        sol.t
    assert sol.tau[-1] == 1.0
    timed = gi.solve(problem, y0, tau_end=1.0, step=0.1)
    np.testing.assert_allclose(timed.y, sol.y, rtol=0, atol=1e-14)
    with pytest.raises(gi.DomainError, match="clock = False"):
        gi.solve(problem, y0, t_end=1.0, step=0.1, clock=False)
    with pytest.raises(gi.DomainError, match="is in physical time"):
        gi.solve(LOTKA, START, tau_end=1.0)


def test_times_after_the_end_in_tau() -> None:
    """Are reported: where a run in τ ends in t is only known afterwards."""
    problem, y0 = ball()
    with pytest.warns(gi.GeomintWarning, match="before 2 of the times in t_eval") as caught:
        sol = gi.solve(problem, y0, tau_end=1.0, step=0.1, t_eval=[0.5, 1e3, 1e4])
    assert caught[0].filename == __file__
    np.testing.assert_array_equal(sol.t, [0.5])
    with pytest.raises(gi.DomainError, match="t_eval"):
        gi.solve(problem, y0, tau_end=1.0, step=0.1, t_eval=[-0.5])


# --- watching -------------------------------------------------------------------------------------


def doubled_energy(params, t, y, work):
    return 2.0 * (0.5 * (y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3]))


@gi.field
def time_itself(params, t, y, work):
    return t + 0.0 * y[0]


def test_what_is_watched() -> None:
    """Names, groups, several of them, and functions of the user's own."""
    problem, y0 = spherical_pendulum.problem(), spherical_pendulum.INITIAL
    options = {"t_end": 5.0, "step": 0.1, "method": "gauss-4"}
    expected = {
        "energy": ["energy"],
        "invariants": ["energy", "angular-momentum"],
        "constraints": ["norm", "tangency"],
        "all": ["energy", "angular-momentum", "norm", "tangency", "measure"],
    }
    for wanted, names in expected.items():
        assert list(gi.solve(problem, y0, observe=wanted, **options).drift) == names
    mixed = gi.solve(problem, y0, observe=("norm", "invariants"), **options)
    assert list(mixed.drift) == ["norm", "energy", "angular-momentum"]
    own = gi.solve(
        henon_heiles.problem(),
        henon_heiles.INITIAL,
        observe={"quadratic": doubled_energy, "time": time_itself},
        **options,
    )
    start = float(np.sum(henon_heiles.INITIAL**2))
    assert own.drift["quadratic"].initial == pytest.approx(start, rel=1e-15)
    assert own.drift["time"].final_error == 5.0
    assert own.drift["time"].max_abs_error == 5.0
    assert own.drift["time"].slope == pytest.approx(1.0, rel=1e-12)


def test_watching_is_evaluating_the_saved_states() -> None:
    """The largest deviation, at every step or every third, and that of the end; it disturbs nothing."""
    from geomint.problems.evaluate import value

    problem, y0 = henon_heiles.problem(), henon_heiles.INITIAL
    energy = problem.invariants["energy"]
    options = {"t_end": 20.0, "step": 0.1, "method": "rk-4", "save_every": 1}
    plain = gi.solve(problem, y0, **options)
    deviations = np.array([value(problem, energy, y) for y in plain.y]) - value(problem, energy, y0)
    for every in (1, 3):
        sol = gi.solve(problem, y0, observe="energy", observe_every=every, **options)
        np.testing.assert_array_equal(sol.y, plain.y)
        drift = sol.drift["energy"]
        watched = np.append(deviations[::every], deviations[-1])
        assert drift.max_abs_error == np.max(np.abs(watched))
        assert drift.final_error == deviations[-1]
    partial = gi.solve(problem, y0, t_end=0.55, step=0.1, method="rk-4", observe="energy")
    end = value(problem, energy, partial.y[-1]) - value(problem, energy, y0)
    assert partial.drift["energy"].final_error == end


# --- interruptions and progress -------------------------------------------------------------------


def interrupted_run(**options: object) -> gi.Solution:
    return gi.solve(
        henon_heiles.problem(), henon_heiles.INITIAL, step=0.1, method="rk-4", **options
    )


@pytest.mark.parametrize("where", ["kernel", "observers", "progress"])
@pytest.mark.parametrize("save_every", [None, 1, 7])
def test_an_interrupted_run(
    where: str, save_every: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Leaves a state of the run at the time that it says, whenever Ctrl-C comes."""
    monkeypatch.setattr(driver, "FIRST_CHUNK", 10)
    monkeypatch.setattr(driver, "CHUNK_SECONDS", 0.0)
    calls = {"n": 0}

    def interrupt_after(original):
        def wrapped(*args, **kwargs):
            result = original(*args, **kwargs)
            calls["n"] += 1
            if calls["n"] == 4:
                raise KeyboardInterrupt
            return result

        return wrapped

    target, name = {
        "kernel": (Stepper, "advance"),
        "observers": (Observers, "add"),
        "progress": (Progress, "update"),
    }[where]
    with monkeypatch.context() as patch:
        patch.setattr(target, name, interrupt_after(getattr(target, name)))
        watched = "energy" if where == "observers" else ()
        sol = interrupted_run(t_end=1e6, save_every=save_every, observe=watched)
    assert sol.status == "interrupted"
    assert not sol.success
    assert 0 < sol.steps < 100
    assert sol.t[-1] == pytest.approx(0.1 * sol.steps)
    same = interrupted_run(t_end=100.0, save_every=1)
    np.testing.assert_array_equal(sol.y[-1], same.y[sol.steps])
    assert sol.iterations == sol.steps


@compiler
def test_a_run_without_saving_is_interruptible(monkeypatch: pytest.MonkeyPatch) -> None:
    """It goes by chunks, too, however many states it hands out."""
    sizes = []
    original = Stepper.advance

    def counting(self, first, count, *others):
        sizes.append(count)
        return original(self, first, count, *others)

    monkeypatch.setattr(Stepper, "advance", counting)
    interrupted_run(t_end=1e5)
    assert len(sizes) > 3
    assert max(sizes) < 10**6
    sizes.clear()
    interrupted_run(t_end=1e5, save_every=700_000)
    assert len(sizes) > 3


@compiler
def test_progress(capsys: pytest.CaptureFixture[str]) -> None:
    """Goes to standard error, is off where that is no terminal, and does not change the result."""
    quiet = interrupted_run(t_end=10.0)
    assert capsys.readouterr() == ("", "")
    shown = interrupted_run(t_end=10.0, progress=True)
    assert capsys.readouterr().out == ""
    np.testing.assert_array_equal(shown.y, quiet.y)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("geomint.run.progress._DELAY", 0.0)
        interrupted_run(t_end=1e4, progress=True)
    assert capsys.readouterr().out == ""


def test_costs_are_told() -> None:
    """Steps, iterations, evaluations, and the time apart from compilation."""
    sol = interrupted_run(t_end=10.0)
    assert (sol.steps, sol.iterations, sol.evaluations) == (100, 100, 400)
    assert 0.0 < sol.run_seconds < 5.0
    assert sol.compile_seconds >= 0.0


# --- states ---------------------------------------------------------------------------------------


def test_states_by_name() -> None:
    """Pieces in the documented order; errors that name what was wrong."""
    problem = spherical_pendulum.problem()
    y = problem.state(q=[0.6, 0.0, -0.8], p=[0.0, 1.0, 0.0])
    np.testing.assert_array_equal(y, [0.6, 0.0, -0.8, 0.0, 1.0, 0.0])
    assert problem.slices == {"q": slice(0, 3), "p": slice(3, 6)}
    assert problem.forms == ("field", "hamiltonian", "splitting")
    for wrong, says in (
        ({"q": [1, 2, 3]}, "p is missing: expected 3 numbers"),
        ({"q": [1, 2, 3], "pp": [1, 2, 3]}, "Did you mean 'p'"),
        ({"q": [1, 2], "p": [1, 2, 3]}, "q = .*expected 3 numbers"),
        ({"q": [1, 2, math.nan], "p": [1, 2, 3]}, "finite"),
        ({"q": "abc", "p": [1, 2, 3]}, "q = 'abc'"),
    ):
        with pytest.raises(gi.DomainError, match=says):
            problem.state(**wrong)


def test_parameters_are_kept() -> None:
    """A problem's arrays are its own, and read-only."""
    params = np.array([1.5, 2.5])
    problem = gi.Problem("p", (("y", 1),), params, field=_nothing)
    with pytest.raises(ValueError, match="read-only"):
        problem.params[0] = 2.0
    y0 = np.array([1.0])
    sol = gi.solve(problem, y0, t_end=1.0, step=0.1, save_every=1)
    sol.y[0] = 7.0
    assert y0[0] == 1.0
    params[0] = 9.0
    assert problem.params[0] == 1.5
    told = {"a": np.array([1.0, 2.0]), "b": [[1.0], [2.0]]}
    problem = gi.Problem("p", (("y", 1),), field=_nothing, parameters=told)
    told["a"][0] = told["b"][0][0] = 9.0
    assert (problem.parameters["a"][0], problem.parameters["b"][0][0]) == (1.0, 1.0)


@pytest.mark.parametrize("name", [1, None, ("a", "b"), b"a", "a\ud800"])
def test_names_are_texts_that_files_can_have(name: object) -> None:
    with pytest.raises(gi.DomainError, match="parameters"):
        gi.Problem("p", (("y", 1),), field=_nothing, parameters={name: 1.0})
    with pytest.raises(gi.DomainError, match="name"):
        gi.Problem(name, (("y", 1),), field=_nothing)


def test_nothing_is_warned_of() -> None:
    """By a run of each family."""
    problem, y0 = ball()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gi.solve(problem, y0, t_end=1.0, step=0.1)
        gi.solve(problem, y0, t_end=1.0, step=0.1, method="rattle-4")
        gi.solve(
            pulsating_body.problem(), pulsating_body.INITIAL, t_end=1.0, step=0.1, method="cf-4"
        )


def test_a_fast_piece_that_is_let_go_beside_a_slow_one() -> None:
    """A spring at its turning point, ω = 10, and something that grows by a thousandth: the spring's."""

    @gi.field
    def both(params, t, y, out, work):
        out[0] = 1e-3 * y[0]
        out[1] = y[2]
        out[2] = -100.0 * y[1]

    problem = gi.Problem("spring", (("slow", 1), ("q", 1), ("v", 1)), field=both)
    assert 0.05 < characteristic_time(problem, np.array([1.0, 1.0, 0.0])) < 0.2


def test_an_interruption_that_numba_makes_an_error_of_is_one() -> None:
    """A second Ctrl-C while it reads the types of functions; other errors stay what they are."""

    def run(presses: int) -> None:
        with Progress(False, 1.0, "run") as bar:
            bar.begin()
            try:
                for _ in range(presses):
                    signal.raise_signal(signal.SIGINT)
            except KeyboardInterrupt:
                pass
            raise TypeError("_get_wrapper_address() missing 1 required positional argument: 'sig'")

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt) as raised:
            run(2)
        assert isinstance(raised.value.__context__, TypeError)
        for presses in (0, 1):
            with pytest.raises(TypeError, match="_get_wrapper_address"):
                run(presses)
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.filterwarnings("ignore:steps of .* more than is promised:geomint.GeomintWarning")
@pytest.mark.parametrize("method", ["gauss-2", "rk-4", "dormand-prince-5-adaptive"])
def test_default_steps_at_the_ends_of_numbers(method: str) -> None:
    """A number, whatever overflows on the way to it: a run, or an error that says where it was."""

    @gi.field
    def turning(params, t, y, out, work):
        out[0] = y[1]
        out[1] = -y[0]

    @gi.field
    def inverse(params, t, y, out, work):
        out[0] = 1.0 / y[0]

    turn = gi.Problem("turn", (("q", 1), ("p", 1)), field=turning)
    hyperbola = gi.Problem("hyperbola", (("y", 1),), field=inverse)
    far_apart = [(turn, [1e300, 1e-300]), (turn, [1e-200, 1e200])]
    for problem, y0 in [*far_apart, *((hyperbola, [y]) for y in (5e-324, 1e-300, 1e300))]:
        for end in (1.0, 5e-324):
            try:
                found = gi.solve(problem, y0, t_end=end, method=method, compiled=False)
            except (gi.StepError, gi.DomainError) as error:
                found = error
            if isinstance(found, gi.DomainError):
                assert "give a step" in str(found)
            else:
                assert np.isfinite(found.t).all()
    exact = gi.solve(hyperbola, [1e300], t_end=1.0, method=method, compiled=False)
    assert exact.y[-1] == 1e300


@pytest.mark.parametrize("asked", [{}, {"observe": "all"}, {"t_end": 0.2}])
def test_an_interrupted_run_is_whole_or_raises(asked):
    """However short: functions in Python are not broken off, nor runs of unknown length."""
    problem = ch.ChaplyginSphere(a=(0.8, 1.1, 1.5), D=4.0).hamiltonized()
    end = {} if "t_end" in asked else {"tau_end": 0.2}
    found = []

    def look(told):
        found.append(signal.getsignal(signal.SIGINT))

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        y0 = problem.random_state(1)
        gi.solve(problem, y0, step=0.05, callback=look, **asked, **end, progress=False)
    finally:
        signal.signal(signal.SIGINT, before)
    assert found
    assert signal.default_int_handler not in found


def test_compiling_for_a_default_step_is_told():
    new = float(np.random.default_rng().random())  # no cache on the disk knows it

    @gi.field
    def own(params, t, y, out, work):
        out[0] = -new * y[0]

    asked = gi.Problem("own", (("x", 1),), field=own)
    sol = gi.solve(asked, [1.0], t_end=1.0, method="rk-4", progress=False)
    rates_alone = gi.Problem("own", (("x", 1),), field=own)
    again = gi.solve(rates_alone, [1.0], t_end=1.0, method="rk-4", progress=False)
    assert (sol.compile_seconds > 0.0) != config.DISABLE_JIT
    assert again.compile_seconds == 0.0


@pytest.mark.parametrize("method", ["gauss-8", "rk-4", "dop853-adaptive", "auto", "exact"])
@pytest.mark.parametrize("begin", [0.0, 2.5])
def test_a_run_of_no_length(method: str, begin: float) -> None:
    """The initial state, watched once; and a run that goes on from there is one from the beginning."""
    import chaplygin as ch

    problem = ch.ChaplyginSphere([0.5, 0.7, 0.9], 0.8).reduced()
    y0 = problem.random_state(3)
    run = {"t0": begin, "t_end": begin, "method": method}
    if method == "auto":
        run["tolerance"] = 1e-8
    sol = gi.solve(problem, y0, **run, dense=True, events=["gamma[0]"], observe=["energy"])
    assert (sol.success, sol.steps, len(sol.t_events[0])) == (True, 0, 0)
    assert sol.t.tolist() == [begin]
    np.testing.assert_allclose(sol.y, [y0], rtol=0, atol=1e-14 * (method == "exact"))
    np.testing.assert_array_equal(sol.sol(begin), sol.y[0])
    assert sol.drift["energy"].windows.max_abs == 0.0
    asked = gi.solve(problem, y0, **run, t_eval=[begin, begin])
    np.testing.assert_array_equal(asked.y, [sol.y[0]] * 2)
    with pytest.raises(gi.DomainError, match="t_eval"):
        gi.solve(problem, y0, **run, t_eval=[begin + 1.0])
    if method != "auto":
        members = gi.solve_ensemble(problem, [y0, y0], **run)
        np.testing.assert_array_equal(members.final, [sol.y[0]] * 2)
    if method == "rk-4":
        more = gi.solve(sol, t_end=begin + 1.0)
        step = abs(more.step)
        whole = gi.solve(problem, y0, t0=begin, t_end=begin + 1.0, method=method, step=step)
        np.testing.assert_array_equal(more.y[-1], whole.y[-1])
        kept = gi.solve(problem, y0, **run, step=0.1, save_every=1, estimate_error=True)
        np.testing.assert_array_equal(kept.error_estimate, np.zeros_like(kept.error_estimate))


@pytest.mark.parametrize("method", ["gauss-8", "rk-4", "dop853-adaptive", "auto"])
def test_a_run_of_no_length_far_away(method: str) -> None:
    """Nothing is less than a rounding of a time to which no step leads."""
    import chaplygin as ch

    problem = ch.ChaplyginSphere([0.5, 0.7, 0.9], 0.8).reduced()
    for far in (1e17, -1e300):
        run = {"t0": far, "t_end": far, "method": method}
        for options in ({"tolerance": 1e-8},) if method == "auto" else ({}, {"step": 0.1}):
            sol = gi.solve(problem, problem.random_state(3), **run, **options)
            assert (sol.t.tolist(), sol.steps) == ([far], 0)


def test_a_run_of_no_length_in_another_time() -> None:
    """Of a problem in τ, by either end; and the derivative of its flow."""
    import chaplygin as ch

    problem = ch.ChaplyginSphere([0.5, 0.7, 0.9], 0.8).hamiltonized()
    y0 = problem.random_state(3)
    for end in ({"t_end": 0.0}, {"tau_end": 0.0}):
        for method in ("gauss-8", "dop853-adaptive"):
            sol = gi.solve(problem, y0, **end, method=method)
            assert (sol.t.tolist(), sol.tau.tolist(), sol.y.tolist()) == (
                [0.0],
                [0.0],
                [y0.tolist()],
            )
    flow = gi.tangent_flow(problem, y0, tau_end=0.0)
    np.testing.assert_array_equal(flow.slopes, np.eye(6))
