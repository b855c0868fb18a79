"""`tolerance=`: the error at the end is about what was asked for, by every family of methods."""

from __future__ import annotations

import dataclasses
import itertools
import math
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import chaplygin as ch
import geomint as gi
from geomint import part
from geomint.kernels.compiling.recorded import Recorded
from geomint.methods import Start
from geomint.problems.deviation import sizes_of
from geomint.problems.evaluate import rates_of
from geomint.problems.testproblems import henon_heiles
from geomint.problems.time_scale import characteristic_time
from geomint.run.accuracy import choose
from geomint.run.accuracy.accuracy import Accuracy
from geomint.run.accuracy.auto import STAGES, auto_method
from geomint.run.accuracy.choose import LARGE
from geomint.run.accuracy.search import MOST, Search, Trial
from geomint.run.accuracy.stretch import Motion, Stretch, extrapolated, stretch
from geomint.scene.load import builtin_scenes
from tests.families import FAMILIES, KINDS, PROBLEMS, pairs
from tests.problems import outer_solar_system, schwarzschild

SPHERE = gi.load_scene("sphere-n3")
HAMILTONIZED = gi.load_scene("hamiltonized-n3")


def truth(problem: gi.Problem, y0: np.ndarray, end: float, start: float = 0.0) -> np.ndarray:
    """Return the state at the end by SciPy, on the functions in plain Python."""
    found = solve_ivp(
        lambda t, y: gi.derivative(problem, y, t),
        (start, end),
        y0,
        "DOP853",
        rtol=1e-13,
        atol=1e-15,
    )
    return np.asarray(found.y[:, -1])


def off(problem: gi.Problem, found: np.ndarray, right: np.ndarray) -> float:
    return float(np.max(np.abs(found - right) / sizes_of(problem, right)))


def tolerance_for(method: gi.Method) -> float:
    """Return a tolerance that a method meets in some thousand steps."""
    return {1: 1e-2, 2: 1e-3, 3: 1e-4, 4: 1e-5, 5: 1e-6}.get(method.order, 1e-8)


@pairs([pair for pair in FAMILIES if "rest" not in pair[1]], KINDS)
@pytest.mark.parametrize("end", [9.0, pytest.param(-4.0, marks=pytest.mark.nightly)])
def test_every_family_meets_it(name: str, problem: str, end: float) -> None:
    p, initial = PROBLEMS[problem]
    y0, method = p.canonical(np.asarray(initial, float)), gi.find_method(name)
    tolerance = tolerance_for(method)
    ends = {"tau_end": end, "clock": False} if p.time == "tau" else {"t_end": end}
    sol = gi.solve(p, y0, **ends, method=method, tolerance=tolerance, progress=False)
    error = off(p, sol.y[-1], truth(p, y0, end))
    assert sol.success
    assert 1e-3 * tolerance < error < 4.0 * tolerance, error / tolerance
    assert sol.accuracy is not None
    assert sol.accuracy.expected <= tolerance
    assert sol.method.name == method.name


@pytest.mark.parametrize(
    "name",
    [
        "gauss-8",
        *(
            pytest.param(x, marks=pytest.mark.nightly)
            for x in ("rk-4", "verlet-6", "dop853-adaptive")
        ),
    ],
)
def test_against_the_exact_flow_at_physical_times(name: str) -> None:
    """The state at the same physical time, however late the clock is."""
    p, y0 = HAMILTONIZED.problem, HAMILTONIZED.state
    tolerance = 1e-5 if name == "rk-4" else 1e-8
    for end in (40.0, -3.0):
        sol = gi.solve(p, y0, t_end=end, method=name, tolerance=tolerance, progress=False)
        error = off(p, sol.y[-1], p.exact(y0)(np.array([end]))[0])
        assert 1e-3 * tolerance < error < 4.0 * tolerance, (end, error / tolerance)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("end", [0.3, 20.0, 500.0])
def test_auto_on_the_exact_flow(tolerance: float, end: float) -> None:
    """Short and long, from scarce to near rounding; the shortest runs are better than asked for."""
    p, y0 = SPHERE.problem, SPHERE.state
    sol = gi.solve(p, y0, t_end=end, method="auto", tolerance=tolerance, progress=False)
    error = off(p, sol.y[-1], p.exact(y0)(np.array([end]))[0])
    assert error < 3.0 * tolerance
    assert end < 1.0 or error > 1e-4 * tolerance


@pytest.mark.parametrize("name", ["gauss-3", "cf-4", "dormand-prince-5-adaptive"])
def test_the_bits_are_those_of_plain_python(name: str) -> None:
    p, y0 = SPHERE.problem, SPHERE.state
    given: dict[str, Any] = {"t_end": 1.5, "method": name, "tolerance": 1e-6, "progress": False}
    one, again, plain = (
        gi.solve(p, y0, **given, compiled=compiled) for compiled in (True, True, False)
    )
    assert one == again
    assert one.accuracy == plain.accuracy
    np.testing.assert_array_equal(one.y, plain.y)


def test_what_is_chosen_is_a_step_and_where_the_iteration_stops() -> None:
    """With something observed the iteration goes on to rounding; what a user chose stays."""
    p, y0 = SPHERE.problem, SPHERE.state
    given: dict[str, Any] = {"t_end": 30.0, "tolerance": 1e-6, "progress": False}
    sol = gi.solve(p, y0, **given, method="gauss-4")
    assert 0.0 < sol.method.options["iteration_tolerance"] < 1e-8
    watched = gi.solve(p, y0, **given, method="gauss-4", observe="energy")
    assert watched.method == gi.Gauss(4)
    own = gi.Gauss(4, iteration_tolerance=2.0**-50)
    assert gi.solve(p, y0, **given, method=own).method == own
    by_hand = gi.solve(p, y0, t_end=30.0, method=sol.method, step=sol.step, progress=False)
    np.testing.assert_array_equal(by_hand.y, sol.y)
    finer = gi.solve(p, y0, t_end=30.0, method="gauss-4", tolerance=1e-9, progress=False)
    assert abs(finer.step) < abs(sol.step)


@gi.field
def standing(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = y[1]
    out[1] = -y[0]


OSCILLATOR = gi.Problem("oscillator", (("x", 1), ("v", 1)), field=standing)


@pytest.mark.parametrize("y0", [[0.0, 0.0], [1.0, 0.0], [1e-200, 0.0], [1e200, 1e200]])
@pytest.mark.parametrize("name", ["gauss-8", "rk-4", "dop853-adaptive"])
def test_at_rest_from_rest_tiny_and_huge(y0: list[float], name: str) -> None:
    method = gi.find_method(name)
    if method.adaptive:  # an absolute tolerance knows nothing of what is tiny
        method = method.with_options(atol=0.0)
    sol = gi.solve(OSCILLATOR, y0, t_end=7.0, method=method, tolerance=1e-7, progress=False)
    c, s = math.cos(7.0), math.sin(7.0)
    right = np.array([c * y0[0] + s * y0[1], c * y0[1] - s * y0[0]])
    assert np.max(np.abs(sol.y[-1] - right)) <= 3e-7 * max(np.max(np.abs(y0)), 0.0)


@pytest.mark.parametrize("end", [1e-30, 1e-8, 0.01])
def test_runs_shorter_than_any_step(end: float) -> None:
    for name in ("gauss-8", "rk-4", "dop853-adaptive"):
        sol = gi.solve(
            OSCILLATOR, [1.0, 0.5], t_end=end, method=name, tolerance=1e-9, progress=False
        )
        right = [math.cos(end) + 0.5 * math.sin(end), 0.5 * math.cos(end) - math.sin(end)]
        np.testing.assert_allclose(sol.y[-1], right, rtol=0, atol=1e-9)


@gi.field
def growing(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = params[0] * y[0]


@gi.field
def of_its_inverse(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = params[0] / y[0]


@gi.field
def of_time(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = params[0] * gi.sqrt(t)


@np.errstate(all="ignore")
def closed(field: Any, rate: float, y: float, t: float) -> float:
    found = {
        growing: y * np.exp(np.float64(rate) * t),
        of_its_inverse: np.hypot(y, np.sqrt(2.0 * np.float64(rate) * t)),
        of_time: y + np.float64(rate) * t * np.sqrt(t) * 2.0 / 3.0,
    }
    return float(found[field])


BAD_SCALES = [
    (growing, -2.0, 1.0, 1e100),
    (growing, -2.0, 1.0, 1e300),
    (growing, 1e300, 1e-200, 1e50),
    (growing, -1e-300, 1e200, 1e-200),
    (growing, 1.0, 5e-324, 1e-300),
    (of_its_inverse, 1e50, 1e6, 2.0),
    (of_its_inverse, 1e300, 10.0, 1e300),
    (of_its_inverse, 1e-300, 1e200, 1e300),
    (of_time, 1e-10, -1.0, 1.7e308),
    (of_time, 2.0, 1.0, 1e-200),
    (of_time, 0.3, -1e300, 1.0),
]


@pytest.mark.parametrize("name", ["auto", "gauss-2", "dop853-adaptive"])
@pytest.mark.parametrize(("field", "rate", "y0", "end"), BAD_SCALES)
@pytest.mark.filterwarnings("ignore::geomint.errors.GeomintWarning")
def test_bad_scales(name: str, field: Any, rate: float, y0: float, end: float) -> None:
    """The right value, or a typed error."""
    problem = gi.Problem("scaled", (("y", 1),), field=field, params=[rate])
    asked: dict[str, Any] = {"method": name, "tolerance": 1e-6, "progress": False}
    try:
        sol = gi.solve(problem, [y0], t_end=end, callback=lambda reached: True, **asked)
    except gi.GeomintError:
        return
    right = closed(field, rate, y0, sol.tau[-1])
    assert sol.y[-1, 0] == pytest.approx(right, rel=1e-4, abs=1e-4 * abs(y0))


@pytest.mark.parametrize("name", ["auto", "gauss-8", "dop853-adaptive"])
@pytest.mark.filterwarnings("ignore::geomint.errors.GeomintWarning")
def test_a_rate_without_derivatives_at_the_first_time(name: str) -> None:
    """y′ = √(t − 1) from t = 1."""

    @gi.field
    def root(params, t, y, out, work):
        out[0] = gi.sqrt(t - 1.0)

    problem = gi.Problem("root", (("y", 1),), field=root)
    sol = gi.solve(problem, [0.0], t0=1.0, t_end=3.0, method=name, tolerance=1e-9, progress=False)
    assert sol.y[-1, 0] == pytest.approx(2.0**2.5 / 3.0, rel=1e-7)
    assert sol.steps < 20_000


@pytest.mark.parametrize("name", ["rk-4", "gauss-8"])
@pytest.mark.filterwarnings("ignore::geomint.errors.GeomintWarning")
def test_trials_are_short_however_long_the_run(name: str) -> None:
    """They are calls of compiled code, for whose end Ctrl-C waits; the run is ended at once."""
    asked: dict[str, Any] = {"method": name, "tolerance": 1e-3, "progress": False}
    sol = gi.solve(OSCILLATOR, [1.0, 0.0], t_end=1e13, callback=lambda reached: True, **asked)
    assert sol.steps < 1e6


# --- auto -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted(builtin_scenes()))
def test_auto_fits_every_scene(name: str) -> None:
    scene = gi.load_scene(name)
    for problem in scene.model.problems.values():
        for tolerance in (1e-2, 1e-6, 1e-12):
            method, reason = auto_method(problem, tolerance)
            method.check_fits(problem, False)
            assert reason


def test_auto_takes_what_a_problem_has() -> None:
    p = HAMILTONIZED.problem
    for gone in ("field", "splitting", ""):
        method, _ = auto_method(p, 1e-8)
        assert method.needs == (gone or "hamiltonian")
        method.check_fits(p, False)
        if gone:
            p = dataclasses.replace(p, **{gone: None})
    ball = gi.load_scene("ball-3d").problem
    assert auto_method(dataclasses.replace(ball, field=None), 1e-8)[0].needs == "action"


def test_the_table_of_auto_goes_down_to_nothing() -> None:
    bounds = [least for least, _ in STAGES]
    assert bounds == sorted(bounds, reverse=True)
    assert bounds[-1] == 0.0
    assert [stages for _, stages in STAGES] == sorted(stages for _, stages in STAGES)


# --- what it says -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        ({"tolerance": 0.0}, gi.DomainError, "tolerance = 0.0"),
        ({"tolerance": 1e-17}, gi.DomainError, "2⁻⁵²"),
        ({"tolerance": 0.1}, gi.DomainError, "tolerance = 0.1"),
        ({"tolerance": math.nan}, gi.DomainError, "tolerance = nan"),
        ({"tolerance": True}, gi.DomainError, "tolerance = True"),
        ({"tolerance": 1e-9, "step": 0.1}, gi.DomainError, "step = 0.1"),
        ({"tolerance": 1e-9, "method": "exact"}, gi.DomainError, "exact flow"),
        ({"method": "auto"}, gi.MethodError, "needs a tolerance"),
        ({"method": "auto", "step": 0.1}, gi.DomainError, "step = 0.1"),
        ({"tolerance": 1e-9, "method": "verlet-4"}, gi.FormError, "splitting"),
    ],
)
def test_what_makes_no_sense(given: dict[str, Any], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        gi.solve(SPHERE.problem, SPHERE.state, **{"t_end": 1.0, **given})


def test_a_solution_goes_on_with_the_step_it_has() -> None:
    given = {"method": "auto", "tolerance": 1e-8, "progress": False}
    sol = gi.solve(SPHERE.problem, SPHERE.state, t_end=5.0, **given)
    with pytest.raises(gi.DomainError, match="tolerance = 1e-09: expected nothing"):
        gi.solve(sol, t_end=9.0, tolerance=1e-9)
    on = gi.solve(sol, t_end=9.0, progress=False)
    assert on.step == sol.step
    assert on.accuracy is None


def test_below_rounding_is_said() -> None:
    with pytest.warns(gi.GeomintWarning, match="roundings alone make about"):
        sol = gi.solve(SPHERE.problem, SPHERE.state, t_end=200.0, tolerance=1e-15, progress=False)
    assert sol.accuracy is not None
    assert (
        off(SPHERE.problem, sol.y[-1], SPHERE.problem.exact(SPHERE.state)(np.array([200.0]))[0])
        < 1e-12
    )


@gi.field
def quickening(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """An oscillator whose frequency rises from 1 to `params[0]` about time 100."""
    s = 0.01 * t
    s4 = s * s * s * s
    rate = 1.0 + (params[0] - 1.0) * s4 * s4 / (1.0 + s4 * s4)
    out[0] = y[1]
    out[1] = -rate * rate * y[0]


@pytest.mark.filterwarnings("ignore:tolerance = 1e-06 may not be met")
@pytest.mark.parametrize("name", ["gauss-6", "rk-4"])
def test_a_run_begins_anew_where_the_motion_becomes_faster(name: str) -> None:
    given: dict[str, Any] = {"t_end": 900.0, "method": name, "tolerance": 1e-6, "progress": False}
    p = gi.Problem("chirp", (("x", 1), ("v", 1)), params=[3.0], field=quickening)
    sol = gi.solve(p, [1.0, 0.0], **given)
    right = gi.solve(p, [1.0, 0.0], t_end=900.0, step=0.05, progress=False).y[-1]
    assert np.abs(sol.y[-1] - right).max() < 2e-5
    assert sol.local_error is not None
    assert sol.local_error.time > 80.0
    steady = gi.Problem("steady", (("x", 1), ("v", 1)), params=[1.0], field=quickening)
    once = gi.solve(steady, [1.0, 0.0], **given)
    assert once.step > 2.0 * sol.step


@gi.field
def rising_pitch(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    w = 1.0 + params[0] * t
    out[0] = y[1]
    out[1] = -w * w * y[0]


@gi.field
def bump(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """An oscillator that is 20 times as stiff for a while."""
    s = 0.5 * (t - 80.0)
    out[0] = y[1]
    out[1] = -(1.0 + 20.0 / (1.0 + s * s)) * y[0]


def test_an_estimated_error_is_no_second_reason_to_warn() -> None:
    """Nor is an error of a piece that turns around measured by what it is there."""
    given: dict[str, Any] = {"tolerance": 1e-6, "estimate_error": True, "progress": False}
    p = gi.Problem("lorenz", (("x", 1), ("y", 1), ("z", 1)), params=[8.0 / 3.0], field=lorenz)
    with pytest.warns(gi.GeomintWarning, match="by a second run the end errs by about") as told:
        sol = gi.solve(p, [-5.0, -6.0, 22.0], t_end=60.0, **given)
    assert len(told) == 1
    assert sol.error_estimate is not None
    assert np.abs(sol.error_estimate[-1]).max() > 1e-5
    steady = gi.Problem("steady", (("x", 1), ("v", 1)), params=[1.0], field=quickening)
    for end in (100.0, 32 * math.pi):
        gi.solve(steady, [1.0, 0.0], t_end=end, method="rk-4", **given)


def test_steps_that_fail_on_the_way_are_shortened() -> None:
    p = gi.Problem("chirp", (("x", 1), ("v", 1)), params=[12.0], field=quickening)
    method = gi.Gauss(8, iteration="fixed-point")
    sol = gi.solve(p, [1.0, 0.0], t_end=400.0, method=method, tolerance=1e-3, progress=False)
    assert sol.success
    assert sol.accuracy is not None
    assert any(error is None for _, error in sol.accuracy.trials)  # a step that failed


@gi.field
def quickening_pairs(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    for i in range(0, len(y), 2):
        quickening(params, t, part(y, i, 2), part(out, i, 2), work)


@pytest.mark.filterwarnings("ignore:tolerance = 0.001 may not be met", "ignore:steps of ")
@pytest.mark.parametrize(
    ("pairs", "called", "end", "rate"),
    [
        (LARGE // 2, False, 400.0, 12.0),
        (LARGE // 2, False, 160.0, 4.2),  # where the iteration goes on, but slowly
        (LARGE // 2, True, 400.0, 12.0),
        (3, False, 400.0, 12.0),
    ],
)
def test_large_states_take_shorter_steps_before_newtons_method(
    pairs: int, called: bool, end: float, rate: float
) -> None:
    """Not where a callback has seen the first run, and not of small states: there Newton's is fast."""
    p = gi.Problem("chirps", (("x", 2 * pairs),), params=[rate], field=quickening_pairs)
    y0 = np.tile([1.0, 0.0], pairs)
    times: list[float] = []
    given: dict[str, Any] = {"t_end": end, "method": gi.Gauss(8), "progress": False}
    callback = (lambda seen: times.append(seen.t)) if called else None
    events = iter(["x[0]"])  # of which the first run takes the last
    sol = gi.solve(p, y0, tolerance=1e-3, callback=callback, events=events, **given)
    assert sol.success
    assert len(sol.events["x[0]"].t) > 10
    assert sol.accuracy is not None
    assert times == sorted(times)
    assert sol.method.options["iteration"] == "auto"
    if 2 * pairs >= LARGE and not called:
        assert sol.step < sol.accuracy.trials[-1][0]
    alone = gi.solve(p, y0, step=sol.step, **{**given, "method": sol.method})
    assert (alone.y == sol.y).all()
    on, alone = (gi.solve(s, t_end=end + 1.0) for s in (sol, alone))
    assert (on.y == alone.y).all()


def test_stretches_of_large_states_are_shorter(monkeypatch: pytest.MonkeyPatch) -> None:
    """In a short run, by the root of the size."""
    lengths: list[float] = []

    def noting(*given: Any) -> Any:
        lengths.append(given[4])
        return stretch(*given)

    monkeypatch.setattr(choose, "stretch", noting)
    for count in (2, LARGE // 2, 2 * LARGE):
        p = gi.Problem("chirps", (("x", 2 * count),), params=[1.0], field=quickening_pairs)
        given: dict[str, Any] = {"t_end": 50.0, "method": gi.Gauss(6), "tolerance": 1e-6}
        gi.solve(p, np.tile([1.0, 0.0], count), progress=False, **given)
    assert set(np.round(np.array(lengths) / lengths[0], 6)) == {1.0, 0.5}


@gi.field
def lorenz(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = 10.0 * (y[1] - y[0])
    out[1] = y[0] * (28.0 - y[2]) - y[1]
    out[2] = y[0] * y[1] - params[0] * y[2]


@pytest.mark.parametrize("end", [40.0, 120.0, 400.0])
def test_fast_chaos_is_said_however_long_the_run(end: float) -> None:
    """Errors are as large as the motion after a small part of a long run."""
    p = gi.Problem("lorenz", (("x", 1), ("y", 1), ("z", 1)), params=[8.0 / 3.0], field=lorenz)
    with pytest.warns(gi.GeomintWarning, match="errors of steps grow .* times on the way"):
        sol = gi.solve(p, [-5.0, -6.0, 22.0], t_end=end, tolerance=1e-9, progress=False)
    assert sol.end_error is not None
    assert sol.end_error.error > 1e-2
    assert 0.0 < sol.end_error.until < 30.0  # errors grow e-fold in 1.1 of time


def test_chaos_is_said_and_regular_motions_are_not_called_so() -> None:

    p = henon_heiles.problem()
    given: dict[str, Any] = {"t_end": 1500.0, "method": "auto", "tolerance": 1e-8}
    # Two motions of energy 1/8, whose largest exponents are 0.05 and 0 (`geomint.lyapunov`).
    wild, tame = (np.array([0.0, y, 0.0, 0.0]) for y in (-0.15, 0.55))
    for y0 in (wild, tame):
        y0[2] = math.sqrt(2.0 * (0.125 - 0.5 * y0[1] ** 2 + y0[1] ** 3 / 3.0))
    with pytest.warns(gi.GeomintWarning, match="errors of steps grow .* times on the way"):
        sol = gi.solve(p, wild, **given, progress=False)
    assert sol.end_error is not None
    assert sol.end_error.grown > 1e6
    sol = gi.solve(p, tame, **given, progress=False)
    assert sol.end_error is not None
    assert sol.end_error.grown < 10.0


def test_runs_that_agree_by_chance_are_looked_at() -> None:
    """Both runs resolved nothing, and their ends were 2.6 tolerances apart."""
    p = gi.Problem("rising", (("y", 2),), params=[1.38428472], field=rising_pitch)
    given: dict[str, Any] = {"t_end": 24.74520810609258, "progress": False}
    sol = gi.solve(p, [0.67775478, 1.15880023], method="auto", tolerance=6.306e-4, **given)
    right = gi.solve(p, [0.67775478, 1.15880023], step=1e-3, **given).y[-1]
    assert np.abs(sol.y[-1] - right).max() < 6.306e-3 * np.abs(right).max()


@gi.field
def two_pairs(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    for i in range(2):
        out[i] = y[2 + i]
        out[2 + i] = -params[i] * params[i] * y[i]


def test_trials_go_on_where_errors_drown_in_roundings() -> None:
    """They ended at the first such step: the run had 307 steps, where 220 do."""
    p = gi.Problem("pairs", (("y", 4),), params=[1.3, 2.1], field=two_pairs)
    given: dict[str, Any] = {"t_end": 300.0, "method": "auto", "progress": False}
    sol = gi.solve(p, [1.0, 0.3, 0.2, 0.3], tolerance=1e-9, **given)
    assert 180 < sol.steps < 260


def test_older_files_are_read() -> None:
    """They had errors of steps among the numbers."""
    older = [1e-6, 1e-7, 0.0, [[0.1, None]], None, "fits"]
    assert Accuracy.read(older) == (1e-6, 1e-7, 0.0, ((0.1, None),), "fits")


def test_it_is_in_files_and_in_the_provenance(tmp_path: Path) -> None:
    p, y0 = HAMILTONIZED.problem, HAMILTONIZED.state
    sol = gi.solve(p, y0, tau_end=3000.0, method="auto", tolerance=1e-8, progress=False)
    assert sol.accuracy is not None
    sol.save(tmp_path / "run.nc")
    loaded = gi.load(tmp_path / "run.nc")
    assert loaded.accuracy == sol.accuracy
    assert loaded == sol
    known = loaded.provenance["accuracy"]
    assert known["tolerance"] == 1e-8
    assert "8 stages" in known["reason"]
    plain = gi.solve(p, y0, tau_end=1.0, step=0.1, progress=False)
    assert plain.provenance["accuracy"] is None


# --- parts ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_stretch_shows_errors_of_its_coarser_run(sign: float) -> None:
    p, y0, h = HAMILTONIZED.problem, HAMILTONIZED.state, 0.1
    method = gi.RungeKutta("rk-4")
    made = gi.Integrator.of(method, Start(p, y0, 0.0, sign * h, clock=True))
    made.prepare()
    found = stretch(made.stepper, Motion(p, y0, 0.0, sign * 500.0), 4, h, 8.0)
    assert found is not None
    end = sign * float(found.times[-1])
    sol = gi.solve(p, y0, tau_end=end, method=method, step=h, progress=False)
    sizes = sizes_of(p, np.abs(found.states[:, : p.rows]).max(axis=0))
    error = float(np.max(np.abs(sol.y[-1] - p.exact(y0).at_tau(end)) / sizes))
    assert found.errors[-1] == pytest.approx(error, rel=0.1)


def stretch_of(error: float) -> Stretch:
    times = np.arange(1.0, 17.0)
    return Stretch(times, error * times / 16.0, 1.0, np.ones((16, 2)))


@pytest.mark.parametrize(
    ("power", "constant"),  # of power 1 and constant 1e4: more than the changes of all trials away
    [c for c in itertools.product([1, 2, 4, 8, 16], [1e-6, 1.0, 1e4]) if c != (1, 1e4)],
)
@pytest.mark.parametrize("first", [1e-3, 0.3, 50.0])
def test_a_search_finds_the_setting(power: int, constant: float, first: float) -> None:
    """From too small and too large beginnings, through a floor of rounding, and where runs fail."""

    def attempt(h: float) -> Trial:
        error = constant * h**power
        found = None if error > 0.1 else stretch_of(max(error, 3e-16))
        return Trial(h, None if found is None else 10.0 * max(error, 3e-16), found)

    goal = 1e-7
    search = Search(attempt, goal, power, 1e3, False)
    setting, expected = search.run(first)
    right = (goal / (10.0 * constant)) ** (1.0 / power)
    if len(search.trials) < MOST:
        assert setting == pytest.approx(right, rel=0.02)
        assert expected == pytest.approx(goal, rel=0.1)


@pytest.mark.parametrize("radius", [21.3, 27.0, 28.9])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-10])
def test_motions_that_begin_where_they_are_slowest(radius: float, tolerance: float) -> None:
    """Around a black hole: steps are a hundredth of what the beginning says, and so iterations end."""
    p = schwarzschild.problem()
    y0 = schwarzschild.initial(p, radius)
    found = gi.solve(p, y0, t_end=1e5, method="auto", tolerance=tolerance, progress=False)
    exact = gi.solve(p, y0, t_end=1e5, method="dop853", step=1.0, progress=False)
    off = np.abs(found.y[-1] - exact.y[-1]) / np.maximum(np.abs(y0), np.abs(exact.y[-1]))
    assert off.max() < 10.0 * tolerance


def test_states_are_admitted_once_and_calls_repeat() -> None:
    admitted = []

    def admit(y: np.ndarray) -> np.ndarray:
        admitted.append(y)
        return y

    problem = dataclasses.replace(OSCILLATOR, admit=admit)
    given: dict[str, Any] = {"t_end": 30.0, "method": "auto", "tolerance": 1e-8, "progress": False}
    assert gi.solve(problem, [1.0, 0.5], **given) == gi.solve(problem, [1.0, 0.5], **given)
    assert len(admitted) == 2
    changed = dataclasses.replace(problem, field=gi.field(quicker))
    once, again = (gi.solve(changed, [1.0, 0.5], **given) for _ in range(2))
    assert once == again != gi.solve(problem, [1.0, 0.5], **given)


CHAPLYGIN = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)
ACTION = dataclasses.replace(CHAPLYGIN.reduced(), field=None)


@pytest.mark.parametrize(
    ("problem", "asked"),
    [
        (CHAPLYGIN.hamiltonized(), {"tau_end": 1.0, "step": 0.1}),
        (CHAPLYGIN.hamiltonized(), {"tau_end": 1.0, "step": 0.1, "observe": ["energy", "K"]}),
        (CHAPLYGIN.hamiltonized(), {"t_end": 1.0}),
        (CHAPLYGIN.hamiltonized(), {"t_end": 20.0, "tolerance": 1e-6}),
        (
            CHAPLYGIN.reduced(),
            {"t_end": 20.0, "tolerance": 1e-6, "method": "dormand-prince-5-adaptive"},
        ),
        (CHAPLYGIN.reduced(), {"t_end": 1.0, "step": 0.4, "method": "rk-4"}),
        (ACTION, {"t_end": 1.0, "method": "cf-4"}),
        (
            dataclasses.replace(CHAPLYGIN.hamiltonized(), field=None),
            {"tau_end": 1.0, "method": "rattle-2"},
        ),
    ],
    ids=lambda x: x.name if isinstance(x, gi.Problem) else "-".join(x),
)
def test_no_call_evaluates_functions_in_plain_python(
    problem: gi.Problem, asked: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """But the checks of the first one: from another state nothing is left to them."""
    gi.solve(problem, problem.random_state(0), **asked, progress=False)

    def call(f: Recorded, *given: Any) -> Any:
        assert not f.function.__module__.startswith("chaplygin"), f"{f} in plain Python"
        return f.function(*given)

    y0 = problem.random_state(1)
    monkeypatch.setattr(Recorded, "__call__", call)
    assert gi.solve(problem, y0, **asked, progress=False).success


def test_trials_of_other_threads_change_nothing() -> None:
    """Compiled code lets other threads run: each has calls, and what they change, of its own."""
    problem = ch.ChaplyginSphere.from_moments((1.0, 2.0, 3.0), 1.0, 1.0).classical()
    states = [problem.random_state(seed) for seed in range(16)]

    def step(y0: Any) -> float | None:
        return gi.solve(problem, y0, t_end=30.0, method="dop853", tolerance=1e-8).step

    alone, before = [step(y0) for y0 in states], sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as pool:
            assert list(pool.map(step, 8 * states)) == 8 * alone
    finally:
        sys.setswitchinterval(before)


def quicker(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = y[1]
    out[1] = -4.0 * y[0]


def test_compiled_derivatives_have_the_bits_of_plain_ones() -> None:
    """Those of large states, by which the first step is chosen: the same time, to the bit."""
    problem, y0 = outer_solar_system.problem(), outer_solar_system.initial()
    compiled = rates_of(problem, y0)
    for y in (y0, 1.1 * y0, y0[::-1][::-1]):
        np.testing.assert_array_equal(compiled(problem, y, 0.5), gi.derivative(problem, y))
    times = [characteristic_time(problem, y0, rate_at=f) for f in (gi.derivative, compiled)]
    assert times[0] == times[1]


def test_nothing_is_expected_where_no_trial_runs() -> None:
    search = Search(lambda h: Trial(h, None), 1e-8, 4, 1.0, False)
    setting, expected = search.run(0.5)
    assert expected == math.inf
    assert len(search.trials) == MOST
    assert 0.0 < setting < 0.5


def test_how_errors_grow() -> None:
    t = np.arange(1.0, 21.0)
    assert extrapolated(t, 3e-9 * t, 1e3, True) == pytest.approx(3e-6)
    assert extrapolated(t, 3e-9 * t, 1e3, False) == pytest.approx(3e-6)
    assert extrapolated(t, 1e-9 * t + 1e-9 * t * t, 1e3, False) == pytest.approx(1.001e-3)
    assert extrapolated(t, 1e-9 * t * t, 20.0, False) == pytest.approx(1e-9 * 300.0, rel=0.3)
    assert extrapolated(t[:1], 3e-9 * t[:1], 10.0, False) == pytest.approx(3e-8)
    assert extrapolated(t, 0.0 * t, 10.0, False) == 0.0
