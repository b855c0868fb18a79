"""`tolerance=`: the error at the end is about what was asked for, by every family of methods."""

from __future__ import annotations

import dataclasses
import math
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.integrate import solve_ivp

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import henon_heiles
from geomint.run.accuracy.search import Search, Trial
from geomint.run.accuracy.stretch import extrapolated
from tests.families import FAMILIES, KINDS, PROBLEMS, pairs
from tests.problems import schwarzschild
from tests.run.motions import first, second, swing

LARGE = 32  # numbers of a state: of fewer Newton's method is fast
HENON = henon_heiles.problem()
SPHERE, HAMILTONIZED = gi.load_scene("sphere-n3"), gi.load_scene("hamiltonized-n3")


def sphere(end: float, **given: Any) -> gi.Solution:
    """A run of the sphere in physical time, whose exact flow is known."""
    return gi.solve(SPHERE.problem, SPHERE.state, **{"t_end": end, "progress": False, **given})


def off(problem: gi.Problem, found: Any, right: Any) -> float:
    """The largest difference, relative to the largest number of each piece."""
    pieces = problem.slices.values()
    return max(float(np.abs(found - right)[p].max() / np.abs(right[p]).max()) for p in pieces)


def off_exact(scene: Any, sol: gi.Solution, end: float) -> float:
    return off(scene.problem, sol.y[-1], scene.problem.exact(scene.state)(np.array([end]))[0])


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
    run = {"method": "DOP853", "rtol": 1e-3 * tolerance, "atol": 1e-5 * tolerance}
    truth = solve_ivp(lambda t, y: gi.derivative(p, y, t), (0.0, end), y0, **run).y[:, -1]
    error = off(p, sol.y[-1], truth)
    assert sol.success
    assert 1e-3 * tolerance < error < 4.0 * tolerance, error / tolerance
    assert sol.accuracy.expected <= tolerance
    assert sol.method.name == method.name


LATE = pytest.mark.nightly


def test_against_the_exact_flow_at_physical_times() -> None:
    """The state at the same physical time, however late the clock is."""
    run: Any = {"method": gi.Gauss(8, iteration="fixed-point"), "tolerance": 1e-8}
    for end in (40.0, -3.0):
        sol = gi.solve(HAMILTONIZED.problem, HAMILTONIZED.state, t_end=end, **run)
        assert 1e-3 < off_exact(HAMILTONIZED, sol, end) / 1e-8 < 4.0


@pytest.mark.parametrize("name", ["rk-4", "gauss-2"])
@pytest.mark.parametrize("end", [20.0, 100.0, 500.0])
def test_errors_are_those_expected(name: str, end: float) -> None:
    """By trials, and by the second run in steps 1.37 times as long, which errs 1.37⁴ times as much."""
    sol = sphere(end, method=name, tolerance=1e-6)
    error = off_exact(SPHERE, sol, end)
    assert 0.2 < error / 1e-6 < 1.0
    assert 0.9 < error / sol.accuracy.expected < (2.5 if end == 20.0 else 1.3)
    assert sol.end_error.error * (1.0 / (1.37**4 - 1.0)) == pytest.approx(error, rel=0.1)


@pytest.mark.parametrize("end", [0.3, 20.0, 500.0])
def test_auto_on_the_exact_flow(end: float) -> None:
    """Short and long, from scarce to near rounding; the shortest runs are better than asked for."""
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10):
        error = off_exact(SPHERE, sphere(end, method="auto", tolerance=tolerance), end)
        assert error < 3.0 * tolerance
        assert end < 1.0 or error > 1e-4 * tolerance


def test_what_is_chosen_is_a_step_and_where_the_iteration_stops() -> None:
    """With something observed the iteration goes on to rounding; what a user chose stays."""
    given: dict[str, Any] = {"method": "gauss-4", "tolerance": 1e-6}
    sol = sphere(30.0, **given)
    assert 0.0 < sol.method.options["iteration_tolerance"] < 1e-8
    assert sphere(30.0, **given, observe="energy").method == gi.Gauss(4)
    own = gi.Gauss(4, iteration_tolerance=2.0**-50)
    assert sphere(30.0, **{**given, "method": own}).method == own
    by_hand = sphere(30.0, method=sol.method, step=sol.step)
    np.testing.assert_array_equal(by_hand.y, sol.y)
    assert abs(sphere(30.0, **{**given, "tolerance": 1e-9}).step) < abs(sol.step)
    with pytest.raises(gi.DomainError, match="tolerance = 1e-09: expected nothing"):
        gi.solve(sol, t_end=39.0, tolerance=1e-9)
    on = gi.solve(sol, t_end=39.0, progress=False)  # with the step it has
    assert (on.step, on.accuracy) == (sol.step, None)


SWING = swing()
CHOSEN: dict[str, Any] = {"tolerance": 1e-7, "progress": False}


@pytest.mark.parametrize("name", ["gauss-8", "rk-4", "dop853-adaptive"])
def test_at_rest_from_rest_tiny_huge_and_short(name: str) -> None:
    method = gi.find_method(name)
    if method.adaptive:  # an absolute tolerance knows nothing of what is tiny
        method = method.with_options(atol=0.0)
    states = ([0.0, 0.0], [1.0, 0.0], [1e-200, 0.0], [1e200, 1e200])
    for y0, end in [*((y, 7.0) for y in states), *(([1.0, 0.5], t) for t in (1e-30, 1e-8, 0.01))]:
        sol = gi.solve(SWING, y0, t_end=end, method=method, **CHOSEN)
        c, s = math.cos(end), math.sin(end)
        right = np.array([c * y0[0] + s * y0[1], c * y0[1] - s * y0[0]])
        assert np.max(np.abs(sol.y[-1] - right)) <= 3e-7 * np.max(np.abs(y0))


def growing(p: Any, t: Any, y: Any) -> Any:
    return p[0] * y[0]


def of_its_inverse(p: Any, t: Any, y: Any) -> Any:
    return p[0] / y[0]


def of_time(p: Any, t: Any, y: Any) -> Any:
    return p[0] * gi.sqrt(t - p[1])


@np.errstate(all="ignore")
def closed(rate_of: Any, rate: float, y: float, t: float) -> float:
    found = {
        growing: y * np.exp(np.float64(rate) * t),
        of_its_inverse: np.hypot(y, np.sqrt(2.0 * np.float64(rate) * t)),
        of_time: y + np.float64(rate) * t * np.sqrt(t) * 2.0 / 3.0,
    }
    return float(found[rate_of])


BAD_SCALES = [
    *((growing, -2.0, 1.0, 1e100), (growing, -2.0, 1.0, 1e300), (growing, 1e300, 1e-200, 1e50)),
    *((growing, -1e-300, 1e200, 1e-200), (growing, 1.0, 5e-324, 1e-300)),
    *((of_its_inverse, 1e50, 1e6, 2.0), (of_its_inverse, 1e300, 10.0, 1e300)),
    *((of_its_inverse, 1e-300, 1e200, 1e300), (of_time, 1e-10, -1.0, 1.7e308)),
    *((of_time, 2.0, 1.0, 1e-200), (of_time, 0.3, -1e300, 1.0)),
]
SCALED = {rate: first("scaled", rate, 1.0, 0.0) for rate in (growing, of_its_inverse, of_time)}


BAD_NAMES = ("auto", "gauss-2", "dop853-adaptive")  # in turn; each for each at night


@pytest.mark.parametrize(
    ("name", "rate_of", "rate", "y0", "end"),
    [
        pytest.param(name, *case, marks=[LATE] * (name != BAD_NAMES[k % 3]))
        for k, case in enumerate(BAD_SCALES)
        for name in BAD_NAMES
    ],
)
@pytest.mark.filterwarnings("ignore::geomint.GeomintWarning")
def test_bad_scales(name: str, rate_of: Any, rate: float, y0: float, end: float) -> None:
    """The right value, or a typed error."""
    problem = dataclasses.replace(SCALED[rate_of], params=[rate, 0.0])
    asked: dict[str, Any] = {"method": name, "tolerance": 1e-6, "progress": False}
    try:
        sol = gi.solve(problem, [y0, 1.0], t_end=end, callback=lambda reached: True, **asked)
    except gi.GeomintError:
        return
    right = closed(rate_of, rate, y0, sol.tau[-1])
    assert sol.y[-1, 0] == pytest.approx(right, rel=1e-4, abs=1e-4 * abs(y0))


@pytest.mark.parametrize("name", ["rk-4", pytest.param("gauss-8", marks=LATE)])
@pytest.mark.filterwarnings("ignore::geomint.GeomintWarning")
def test_trials_are_short_however_long_the_run(name: str) -> None:
    """They are calls of compiled code, for whose end Ctrl-C waits; the run is ended at once."""
    asked: dict[str, Any] = {"method": name, "tolerance": 1e-3, "progress": False}
    sol = gi.solve(SWING, [1.0, 0.0], t_end=1e13, callback=lambda reached: True, **asked)
    assert sol.steps < 1e6


# --- auto -------------------------------------------------------------------------------------------


def chosen(problem: gi.Problem, y0: Any, tolerance: float) -> gi.Method:
    """The method of a run of no length, which has a reason."""
    end = {"tau_end" if problem.time == "tau" else "t_end": 0.0}
    return gi.solve(problem, y0, **end, method="auto", tolerance=tolerance, compiled=False).method


def test_auto_takes_what_a_problem_has() -> None:
    """Of more stages, or a higher order, below the tolerances that the manual names."""
    p, y0 = HAMILTONIZED.problem, HAMILTONIZED.state
    asked = (1e-3, 0.99e-3, 1e-4, 0.99e-4, 1e-5, 0.99e-5, 3e-7, 2.9e-7, 1e-7, 0.99e-7, 1e-15)
    for gone in ("field", "splitting", ""):
        assert chosen(p, y0, 1e-8).needs == (gone or "hamiltonian")
        orders = [chosen(p, y0, tolerance).order for tolerance in asked]
        known = [10, 12, 12, 12, 12, 14, 14, 16, 16, 16, 16] if gone == "field" else None
        assert orders == (known or [4, 4, 4, 6, 6, 6, 6, 6, 6, 8, 8])
        p = dataclasses.replace(p, **{gone: None}) if gone else p
    ball = gi.load_scene("ball-3d")
    assert chosen(dataclasses.replace(ball.problem, field=None), ball.state, 1e-8).needs == "action"


# --- what it says -----------------------------------------------------------------------------------


def test_what_makes_no_sense() -> None:
    for asked, error, words in (
        *(({"tolerance": x}, gi.DomainError, f"tolerance = {x}") for x in (0.0, 0.1, math.nan)),
        ({"tolerance": 1e-17}, gi.DomainError, "2⁻⁵²"),
        ({"tolerance": 1e-9, "step": 0.1}, gi.DomainError, "step = 0.1"),
        ({"tolerance": 1e-9, "method": "exact"}, gi.DomainError, "exact flow"),
        ({"method": "auto"}, gi.MethodError, "needs a tolerance"),
        ({"method": "auto", "step": 0.1}, gi.DomainError, "step = 0.1"),
        ({"tolerance": 1e-9, "method": "verlet-4"}, gi.FormError, "splitting"),
    ):
        with pytest.raises(error, match=words):
            sphere(1.0, **asked)


def test_below_rounding_is_said() -> None:
    with pytest.warns(gi.GeomintWarning, match="roundings alone make about"):
        sol = sphere(200.0, tolerance=1e-15)
    assert off_exact(SPHERE, sol, 200.0) < 1e-12


def quickening(p: Any, t: Any, y: Any) -> Any:
    """An oscillator whose frequency rises from 1 to `p[0]` about time 100."""
    s = 0.01 * t
    s4 = s * s * s * s
    rate = 1.0 + (p[0] - 1.0) * s4 * s4 / (1.0 + s4 * s4)
    return -rate * rate * y[0]


@gi.field
def lorenz(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = 10.0 * (y[1] - y[0])
    out[1] = y[0] * (28.0 - y[2]) - y[1]
    out[2] = y[0] * y[1] - params[0] * y[2]


LORENZ = gi.Problem("lorenz", (("x", 1), ("y", 1), ("z", 1)), params=[8.0 / 3.0], field=lorenz)


def test_an_estimated_error_is_no_second_reason_to_warn() -> None:
    """Nor is an error of a piece that turns around measured by what it is there."""
    given: dict[str, Any] = {"tolerance": 1e-6, "estimate_error": True, "progress": False}
    with pytest.warns(gi.GeomintWarning, match="by a second run the end errs by about") as told:
        sol = gi.solve(LORENZ, [-5.0, -6.0, 22.0], t_end=60.0, **given)
    assert len(told) == 1
    assert np.abs(sol.error_estimate[-1]).max() > 1e-5
    for end in (100.0, 32 * math.pi):
        gi.solve(SWING, [1.0, 0.0], t_end=end, method="rk-4", **given)


def test_steps_that_fail_on_the_way_are_shortened() -> None:
    method = gi.Gauss(8, iteration="fixed-point")
    given: dict[str, Any] = {"method": method, "tolerance": 1e-3, "progress": False}
    chirp = second("chirp", quickening, 12.0)
    sol = gi.solve(chirp, [1.0, 0.0], t_end=400.0, **given)
    assert sol.success
    assert any(error is None for _, error in sol.accuracy.trials)  # a step that failed


QUICKENING = gi.helper(quickening)


@gi.field
def quickening_pairs(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    for i in range(0, len(y), 2):
        out[i] = 1.0 * y[i + 1]
        out[i + 1] = QUICKENING(params, t, gi.part(y, i, 2))


@pytest.mark.filterwarnings("ignore:tolerance = 0.001 may not be met", "ignore:steps of ")
@pytest.mark.parametrize("pairs", [LARGE // 2, 3])
def test_large_states_take_shorter_steps_before_newtons_method(pairs: int) -> None:
    """Not of small states: there Newton's is fast."""
    p = gi.Problem("chirps", (("x", 2 * pairs),), params=[12.0], field=quickening_pairs)
    y0, given = np.tile([1.0, 0.0], pairs), {"t_end": 400.0, "progress": False}
    events = iter(["x[0]"])  # of which the first run takes the last
    sol = gi.solve(p, y0, tolerance=1e-3, method="gauss-8", **given, events=events)
    assert sol.success
    assert len(sol.events["x[0]"].t) > 10
    assert sol.method.options["iteration"] == "auto"
    if 2 * pairs >= LARGE:
        assert sol.step < sol.accuracy.trials[-1][0]
    alone = gi.solve(p, y0, step=sol.step, method=sol.method, **given)
    on = [gi.solve(s, t_end=401.0) for s in (sol, alone)]
    assert (alone.y == sol.y).all()
    assert (on[0].y == on[1].y).all()


def of_energy(y: float) -> list[float]:
    """Return a state of energy 1/8."""
    return [0.0, y, math.sqrt(2.0 * (0.125 - 0.5 * y**2 + y**3 / 3.0)), 0.0]


def test_chaos_is_said_and_regular_motions_are_not_called_so() -> None:
    """Errors are as large as the motion after a small part of a long run."""
    for problem, y0, end, tolerance, until in (
        (LORENZ, [-5.0, -6.0, 22.0], 40.0, 1e-9, 30.0),  # errors grow e-fold in 1.1 of time
        (LORENZ, [-5.0, -6.0, 22.0], 400.0, 1e-9, 30.0),
        (HENON, of_energy(-0.15), 1500.0, 1e-8, 1000.0),  # of exponent 0.05; of 0
        (HENON, of_energy(0.55), 1500.0, 1e-8, None),
    ):
        given: dict[str, Any] = {"t_end": end, "tolerance": tolerance, "method": "auto"}
        if until is None:
            assert gi.solve(problem, y0, **given, progress=False).end_error.grown < 10.0
            continue
        with pytest.warns(gi.GeomintWarning, match="errors of steps grow .* times on the way"):
            error = gi.solve(problem, y0, **given, progress=False).end_error
        assert (error.error > 1e-2) or problem is HENON
        assert error.grown > 1e6
        assert 0.0 < error.until < until


def test_it_is_in_files_and_in_the_provenance(tmp_path: Path) -> None:
    sol = sphere(3000.0, method="auto", tolerance=1e-8)
    sol.save(tmp_path / "run.nc")
    loaded = gi.load(tmp_path / "run.nc")
    assert (loaded, loaded.accuracy) == (sol, sol.accuracy)
    known = loaded.provenance["accuracy"]
    assert known["tolerance"] == 1e-8
    assert "8 stages" in known["reason"]
    assert sphere(1.0, step=0.1).provenance["accuracy"] is None


# --- parts ------------------------------------------------------------------------------------------


@given(
    *(st.sampled_from([1, 2, 4, 8, 16]), st.sampled_from([1e-6, 1.0, 1e4, math.inf])),
    *(st.sampled_from([1e-3, 0.3, 50.0]), st.sampled_from([math.inf, 1.7, 4.0])),
)
def test_a_search_finds_the_setting(
    power: int, constant: float, begin: float, fails: float
) -> None:
    """From too small and too large beginnings, through a floor of rounding, and where runs fail."""
    right = (1e-7 / (10.0 * constant)) ** (1.0 / power)

    def attempt(h: float) -> Trial:
        error = max(constant * h**power, 3e-16)
        shown: Any = SimpleNamespace(work=1.0, errors=np.array([error]))
        runs = error <= 0.1 and h < fails * right
        return Trial(h, 10.0 * error, shown) if runs else Trial(h, None)

    search = Search(attempt, 1e-7, power, 1e3, False)
    setting, expected = search.run(begin)
    if constant == math.inf:  # nothing is expected where no trial runs
        assert (expected, len(search.trials)) == (math.inf, 8)
        assert 0.0 < setting < begin
    elif len(search.trials) < 8 and (power, constant) != (1, 1e4):  # else it is too far away
        assert setting == pytest.approx(right, rel=0.02)
        assert expected == pytest.approx(1e-7, rel=0.1)


def test_how_errors_grow() -> None:
    """In proportion to time, or to its square where a method is not symmetric, as both are seen."""
    t = np.arange(1.0, 21.0)
    for rise, end, symmetric, expected in (
        *((3e-9 * t, 1e3, True, 3e-6), (3e-9 * t, 1e3, False, 3e-6), (0.0 * t, 10.0, False, 0.0)),
        (1e-9 * t + 1e-9 * t * t, 1e3, False, 1.001e-3),
    ):
        assert extrapolated(t, rise, end, symmetric) == pytest.approx(expected)
    assert extrapolated(t, 1e-9 * t * t, 20.0, False) == pytest.approx(3e-7, rel=0.3)
    assert extrapolated(t[:1], 3e-9 * t[:1], 10.0, False) == pytest.approx(3e-8)


def test_motions_that_begin_where_they_are_slowest() -> None:
    """Around a black hole: steps are a hundredth of what the beginning says, and so iterations end."""
    p, tolerance = schwarzschild.problem(), 1e-10
    y0 = schwarzschild.initial(p, 27.0)
    found = gi.solve(p, y0, t_end=1e5, method="auto", tolerance=tolerance, progress=False)
    exact = gi.solve(p, y0, t_end=1e5, method="dop853", step=1.0, progress=False)
    off = np.abs(found.y[-1] - exact.y[-1]) / np.maximum(np.abs(y0), np.abs(exact.y[-1]))
    assert off.max() < 10.0 * tolerance


def test_states_are_admitted_once_and_calls_repeat() -> None:
    admitted: list[Any] = []
    problem = dataclasses.replace(SWING, admit=lambda y: admitted.append(y) or y)
    given: dict[str, Any] = {"t_end": 30.0, "method": "auto", "tolerance": 1e-8, "progress": False}
    once, again = (gi.solve(problem, [1.0, 0.5], **given) for _ in range(2))
    assert once == again
    assert len(admitted) == 2


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
            assert list(pool.map(step, 3 * states)) == 3 * alone
    finally:
        sys.setswitchinterval(before)
