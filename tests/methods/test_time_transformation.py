"""The same motions in another time: orbits, structure, cost, and what else runs with them."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import henon_heiles
from geomint.testing import check_problem
from tests.problems import so_n_flow

SHARP = ch.ellipsoid_problem([1.0, 900.0, 900.0])  # semi-axes 1, 30, 30
FLAT = ch.ellipsoid_problem([1.0, 25.0, 900.0])
GAUSS = gi.Gauss(8)
END = 300.0


def state(problem: gi.Problem, seed: int = 0) -> np.ndarray:
    y = problem.random_state(seed)
    y[3:] /= np.linalg.norm(y[3:])
    return y


@functools.cache
def uneven(problem: gi.Problem, clock: str) -> gi.Problem:
    return gi.time_transformed(problem, clock, state(problem))


@functools.cache
def known(problem: gi.Problem) -> np.ndarray:
    """Return the end of a motion, by steps that are not even in any time."""
    method = gi.find_method("dop853-adaptive").with_options(rtol=1e-15, atol=0.0)
    return gi.solve(problem, state(problem), t_end=END, method=method).y[-1]


def off(problem: gi.Problem, y: np.ndarray, right: np.ndarray) -> float:
    """The largest error of a piece, relative to its largest row."""
    pieces = problem.slices.values()
    return max(np.abs(y[p] - right[p]).max() / np.abs(right[p]).max() for p in pieces)


@gi.field
def pendulum(params, t, y, out, work):
    out[0], out[1] = y[1], -params[0] * gi.sin(y[0])


@gi.field
def driven(params, t, y, out, work):
    out[0], out[1] = y[1], -params[0] * gi.sin(y[0]) + gi.sin(t)


@gi.observable
def twice(params, t, y, work):
    return 2.0 + 0.0 * y[0]


@gi.observable
def second_number(params, t, y, work):
    return params[1] + 0.0 * y[0]


@gi.observable
def angle(params, t, y, work):
    return 1.0 * y[0]


PIECES = (("angle", 1), ("momentum", 1))
PENDULUM = gi.Problem(name="pendulum", pieces=PIECES, params=[1.0, 2.0], field=pendulum)
# Steps of τ with errors of some 1e-10 at the end.
CLOCKS = (("normal_squared", 10.0), ("speed", 0.4))
each_clock = pytest.mark.parametrize(
    ("clock", "step"), [CLOCKS[0], pytest.param(*CLOCKS[1], marks=pytest.mark.nightly)]
)


def test_the_speed_is_weighed_by_pieces() -> None:
    """σ = (ε + Σ w |ẏ|²)^(−5/16), 1 where the motion began, by an independent formula."""
    y, other = np.array([50.0, 20.0]), np.array([-30.0, 2.0])
    problem = gi.time_transformed(PENDULUM, y0=y)
    parts = [np.array([x[1], np.sin(x[0])]) / y for x in (y, other)]
    for at, share in ((y, 1.0), (other, (parts[1] @ parts[1]) / (parts[0] @ parts[0]))):
        found = gi.value(problem, problem.clock, at)
        known = (2.0**-40 + (1.0 - 2.0**-40) * share) ** (-5.0 / 16.0)
        assert found == pytest.approx(known, rel=1e-14)
    rest = gi.time_transformed(PENDULUM, y0=[0.0, 0.0])
    assert gi.value(rest, rest.clock, [0.0, 0.0]) == 1.0


@each_clock
def test_the_motion_is_the_same(clock: str, step: float) -> None:
    sol = gi.solve(uneven(SHARP, clock), state(SHARP), t_end=END, method=GAUSS, step=step)
    assert sol.t[-1] == pytest.approx(END, rel=1e-14)
    assert off(SHARP, sol.y[-1], known(SHARP)) < 1e-8


@each_clock
def test_the_order_is_that_of_the_method(clock: str, step: float) -> None:
    """Of states and of physical time."""
    problem, y, span = uneven(SHARP, clock), state(SHARP), 40 * step
    right = gi.solve(problem, y, tau_end=span, method=GAUSS, step=span / 160)
    errors, late = [], []
    for steps in (320, 640):
        sol = gi.solve(problem, y, tau_end=span, method=gi.Gauss(2), step=span / steps)
        errors.append(off(SHARP, sol.y[-1], right.y[-1]))
        late.append(abs(sol.t[-1] - right.t[-1]))
    assert 3.7 < np.log2(errors[0] / errors[1]) < 4.3
    assert 3.7 < np.log2(late[0] / late[1]) < 4.3


@pytest.mark.parametrize(
    ("clock", "step"),
    [("normal_squared", 4.0), pytest.param("speed", 0.5, marks=pytest.mark.nightly)],
)
def test_nothing_drifts(clock: str, step: float) -> None:
    """But the density of another flow, that of t watched in τ: what μ/σ is for."""
    kept = ("energy", "joachimsthal", "ellipsoid", "tangency", "measure")
    problem, y = uneven(FLAT, clock), state(FLAT)
    run = {"method": GAUSS, "step": step, "clock": False}
    drift = gi.solve(problem, y, tau_end=5000 * step, observe=kept, **run).drift
    for name in kept[:-1]:
        assert drift[name].max_abs_error < 2e-14, name
    assert drift["measure"].drift_class in ("roundoff", "bounded", "sqrt", "undetermined")
    assert drift["measure"].max_abs_error < 1e-9
    wrong = replace(problem, measure=FLAT.measure)
    lost = gi.solve(wrong, y, tau_end=100 * step, observe=["measure"], **run)
    assert lost.drift["measure"].max_abs_error > 1e-2


@pytest.mark.parametrize("clock", ["speed", "energy"])
@pytest.mark.parametrize(
    "problem",
    [
        henon_heiles.problem(),
        so_n_flow.problem(4, season=0.0),  # a field that asks for the number of its parameters
        gi.load_scene("ball-3d").problem,
        gi.load_scene("hamiltonized-n3").problem,
        gi.load_scene("sphere-n3").problem,  # functions that hand the time on
    ],
    ids=lambda p: p.name,
)
def test_forms_and_measures_agree(problem: gi.Problem, clock: str) -> None:
    rng = np.random.default_rng(3)
    y = problem.random_state(3) if problem.make_random else 0.2 * rng.normal(size=problem.rows)
    if problem.name == "classical-ball":
        y = gi.load_scene("ball-3d").state  # whose momentum in space is a constraint
    if clock not in ("speed", *problem.diagnostics):
        clock = next(iter(problem.invariants))
    try:
        other = gi.time_transformed(problem, clock, y)
    except gi.DomainError:
        other = gi.time_transformed(problem, twice, y)
    check_problem(other, [y])
    sigma = gi.value(other, other.clock, y)
    sigma /= 1.0 if problem.clock is None else gi.value(problem, problem.clock, y)
    assert gi.derivative(other, y) == pytest.approx(sigma * gi.derivative(problem, y), rel=1e-14)


@pytest.mark.parametrize("sigma", [2.0, 2.0**400, 2.0**-400])
def test_a_constant_clock_changes_no_bit(sigma: float) -> None:
    y, problem = [2.0, 0.5], replace(PENDULUM, params=[1.0, sigma])
    even = gi.solve(problem, y, t_end=20.0, method=GAUSS, step=0.25)
    other = gi.time_transformed(problem, second_number, y)
    sol = gi.solve(other, y, tau_end=20.0 / sigma, method=GAUSS, step=0.25 / sigma)
    assert sol.y.tobytes() == even.y.tobytes()
    assert sol.t[-1] == pytest.approx(20.0, rel=1e-13)
    assert sol.evaluations == even.evaluations


def test_at_rest_and_from_rest() -> None:
    still = gi.time_transformed(PENDULUM, "speed", [0.0, 0.0])
    sol = gi.solve(still, [0.0, 0.0], t_end=10.0, method=GAUSS, step=0.5)
    assert sol.y[-1].tolist() == [0.0, 0.0]
    assert sol.t[-1] == pytest.approx(10.0)
    for y in ([2.0, 0.0], [0.0, 1.0], [1e-150, 0.0]):
        falling = gi.time_transformed(PENDULUM, "speed", y)
        even = gi.solve(PENDULUM, y, t_end=10.0, method=GAUSS, step=0.1)
        sol = gi.solve(falling, y, t_end=10.0, method=GAUSS, step=0.1)
        assert off(PENDULUM, sol.y[-1], even.y[-1]) < 1e-12, y


def test_what_else_a_run_takes() -> None:
    """States at physical times, events, dense output, restarts, tolerances, ensembles, tangents."""
    problem, y, times = uneven(SHARP, "normal_squared"), state(SHARP), [0.0, 10.0, 200.0, END]
    run = functools.partial(gi.solve, problem, method=GAUSS)
    sol = run(y, t_end=END, step=7.0, t_eval=times, events="x[0]", dense=True)
    even = gi.solve(SHARP, y, t_end=END, step=0.03, method=GAUSS, t_eval=times, events="x[0]")
    assert sol.t == pytest.approx(np.array(times), abs=1e-10)
    assert sol.y == pytest.approx(even.y, abs=1e-6)
    (found,), (expected,) = sol.events.values(), even.events.values()
    assert found.t == pytest.approx(expected.t, abs=1e-6)
    assert sol.sol(t=200.0) == pytest.approx(sol.y[2], abs=1e-9)

    half = run(y, tau_end=350.0, step=7.0, save_every=1)
    whole, rest = run(y, tau_end=700.0, step=7.0), gi.solve(half, tau_end=700.0)
    assert rest.y[-1].tobytes() == whole.y[-1].tobytes()
    assert rest.t[-1] == whole.t[-1]

    chosen = run(y, t_end=END, tolerance=1e-9)
    assert off(SHARP, chosen.y[-1], known(SHARP)) < 1e-8
    members = gi.solve_ensemble(problem, [y, y], t_end=END, method=GAUSS, step=7.0)
    assert np.array_equal(members.y[1, -1], run(y, t_end=END, step=7.0).y[-1])
    moved = gi.tangent_flow(problem, y, tau_end=70.0, method=GAUSS, step=7.0)
    assert np.isfinite(moved.slopes).all()


@pytest.mark.parametrize(
    ("given", "error", "said"),
    [
        ((None, "speed", None), gi.DomainError, "problem"),
        ((SHARP, "sped", None), gi.DomainError, "Did you mean 'speed'"),
        ((SHARP, 1.0, None), gi.DomainError, "clock"),
        ((SHARP, "speed", None), gi.DomainError, "y0"),
        ((SHARP, "tangency", state(SHARP)), gi.DomainError, "clock > 0"),
        ((PENDULUM, angle, [-1.0, 0.0]), gi.DomainError, "clock > 0"),
        ((replace(PENDULUM, field=driven), twice, None), gi.DomainError, "depends on time"),
        ((replace(PENDULUM, field=driven), twice, [1.0, 0.0]), gi.FormError, "on time explicitly"),
        ((replace(SHARP, field=None), "normal_squared", None), gi.FormError, "field or an action"),
    ],
)
def test_what_has_no_other_time(given: Any, error: type[Exception], said: str) -> None:
    with pytest.raises(error, match=said):
        gi.time_transformed(*given)


def test_what_runs_in_no_other_time() -> None:
    """Other forms; and σ = angle, which falls to 0 within finite t: the end is never reached."""
    with pytest.raises(gi.FormError, match="hamiltonian"):
        gi.solve(uneven(SHARP, "speed"), state(SHARP), t_end=1.0, method="rattle-2", step=0.1)
    other = gi.time_transformed(PENDULUM, angle, [1.0, 0.0])
    with pytest.raises(gi.ClockError):
        gi.solve(other, [1.0, 0.0], t_end=3.0, method=GAUSS, step=0.1)


def test_scenes() -> None:
    scene = gi.load_scene("ellipsoid-uneven")
    own, plan = scene.problem, gi.make_plan(scene)
    assert own.time == "tau"
    assert plan.problem is own
    even = scene.changed(time={"clock": None})
    assert even.problem.time == "t"
    assert even.hash != scene.hash
    assert scene.changed(time={"t_end": 5.0}).problem is own
    other = scene.changed(time={"clock": "speed"}, integrate={"step": 0.5})
    assert other.problem.time == "tau"
    ends = [gi.run_scene(s) for s in (scene, other)]
    assert off(FLAT, ends[0].y[-1], ends[1].y[-1]) < 1e-7
    explicit = gi.make_plan(scene.changed_integration("rattle-2", 0.1))
    assert explicit.problem.time == "t"  # a form that the scene's own representation has not
    for clock, said in (("sped", "Did you mean 'speed'"), ("tangency", "clock > 0")):
        with pytest.raises(gi.SceneError, match=rf"\[time\] clock = .*{said}"):
            scene.changed(time={"clock": clock})


def test_functions_get_their_own_parameters_only() -> None:
    @gi.observable
    def count(params, t, y, work):
        return 0.0 * y[0] + 1.0 * len(params)

    problem = replace(PENDULUM, observables={"count": count})
    other = gi.time_transformed(problem, "speed", [1.0, 0.5])
    assert len(other.params) > 2
    assert gi.value(other, "count", [1.0, 0.5]) == 2.0
