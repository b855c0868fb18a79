"""Default steps, wherever runs take them: they err by what is promised, or a warning says that not."""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import geomint as gi
from tests.problems import abc_flow, double_pendulum, examples
from tests.run.motions import APOCENTRE, KEPLER, REGULAR, TRAPS, promised, solve, turned

DOUBTED = 36.0  # times what is promised: two measurements, each to a factor of some
Way = Callable[[gi.Problem, Any, float, str], float]


def ending(problem: gi.Problem, end: float) -> dict[str, Any]:
    return {"tau_end" if problem.time == "tau" else "t_end": end}


def first_of(problem: gi.Problem, row: int = 0) -> str:
    piece, rows = problem.pieces[0]
    return f"{piece}[{min(row, rows - 1)}]"


def in_a_loop(problem: gi.Problem, y0: Any, end: float, method: str) -> float:
    motion = gi.Integrator(problem, y0, method)
    while motion.time + motion.h < end:
        motion.step()
    return motion.h


def in_a_call(problem: gi.Problem, y0: Any, end: float, method: str) -> float:
    motion = gi.Integrator(problem, y0, method)
    motion.propagate_until(end)
    return motion.h


def in_short_spans(problem: gi.Problem, y0: Any, end: float, method: str) -> float:
    """Of which each is a single step, less than a whole one."""
    motion = gi.Integrator(problem, y0, method)
    span = 0.8 * motion.h
    while motion.time + span < end:
        motion.propagate_for(span)
    return span


def of_members(problem: gi.Problem, y0: Any, end: float, method: str) -> float:
    clock = False if problem.time == "tau" else None
    states = np.array([y0] * 9)
    many = gi.solve_ensemble(problem, states, method=method, clock=clock, **ending(problem, end))
    assert many.success
    alone = many.single(4)  # to its bits, whether it has begun anew or not
    assert alone.y[-1].tobytes() == many.final[4].tobytes()
    return abs(alone.step)


def of_members_at_times(problem: gi.Problem, y0: Any, end: float, method: str) -> float:
    given: dict[str, Any] = {f"{problem.time}_eval": [0.5 * end, end], **ending(problem, end)}
    many = gi.solve_ensemble(problem, np.array([y0] * 3), method=method, **given)
    return end / float(many.steps[1])


def of_exponents(problem: gi.Problem, y0: Any, end: float, method: str) -> float:
    return end / gi.lyapunov(problem, y0, method=method, count=1, **ending(problem, end)).steps


def of_sections(problem: gi.Problem, y0: Any, end: float, method: str) -> float:
    event = first_of(problem, 1)
    return gi.poincare_section(problem, y0, event, 10**6, method=method, end=end).step


WAYS = [in_a_loop, in_a_call, in_short_spans]
WAYS += [of_members, of_members_at_times, of_exponents, of_sections]


def _error(problem: gi.Problem, y0: Any, end: float, method: str, step: float) -> float:
    """Return what steps err by, over what is promised."""
    given: dict[str, Any] = {"clock": False if problem.time == "tau" else None}
    try:
        sol = gi.solve(problem, y0, method=method, step=step, **given, **ending(problem, end))
    except gi.StepError:
        return math.inf
    return sol.local_error.largest / promised(sol.method)


LATE = pytest.mark.nightly
# What becomes faster later is seen neither in the first steps of few members nor at their ends; of
# gauss-8, where Newton's method is compiled, one way is enough.
TRIED = [
    (way, case, method)
    for way, case, method in product(WAYS, TRAPS, ("gauss-8", "gauss-4", "rk-4", "dop853"))
    if case != "faster later" or way is in_a_loop or (way is not of_members and method != "gauss-8")
]


def rows(every: Any, fast: Callable[..., bool]) -> Any:
    """Return ways, cases and methods as parameters; what is not `fast` runs at night."""
    marked = (pytest.param(*one, marks=[LATE] * (not fast(*one))) for one in every)
    return pytest.mark.parametrize(("way", "case", "method"), list(marked))


def telling(way: Way, case: str, method: str) -> bool:
    """Tell whether it is in the fast row: each way, each case, each kind of method."""
    if method == "rk-4":  # exponents and members are compiled for each size
        return case == ("axis" if way is of_exponents else "apocentre") or way is in_a_call
    return method == "gauss-8" and way is in_a_loop and case in ("epidemic", "lowest point")


def regular(way: Way, case: str, method: str) -> bool:
    return method == "rk-4" and case == ("ball" if way is of_exponents else "henon-heiles")


@rows(TRIED, telling)
def test_no_default_step_errs_by_more_in_silence(way: Way, case: str, method: str) -> None:
    problem, y0, end = TRAPS[case]
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            step = way(problem, y0, end, method)
        except gi.ConvergenceError:  # a typed error is no silence
            return
        said = [str(w.message) for w in told]
        known = ("than is promised where no step is given; give", "steps are half as long")
        assert all(any(words in text for words in known) for text in said)
        assert said or _error(problem, y0, end, method, step) <= DOUBTED


@pytest.mark.filterwarnings("error::geomint.GeomintWarning")
@rows(product(WAYS, ("sphere", "ball", "henon-heiles"), ("gauss-8", "rk-4", "heun-2")), regular)
def test_regular_motions_are_told_nothing_of(way: Way, case: str, method: str) -> None:
    problem, y0, end = REGULAR[case]
    step = way(problem, y0, end, method)
    assert step == pytest.approx(abs(gi.Integrator(problem, y0, method).h), rel=0.21)


@pytest.mark.filterwarnings("error::geomint.GeomintWarning")
def test_a_step_that_is_given_is_taken_as_it_is() -> None:
    given, chosen = gi.Integrator(KEPLER, APOCENTRE, "rk-4", step=0.1), in_a_step(APOCENTRE)
    for motion in (given, chosen):
        motion.h = 0.1
        motion.step(200)
    run: dict[str, Any] = {"t_end": 20.0, "method": "rk-4", "step": 0.1}
    gi.solve_ensemble(KEPLER, [APOCENTRE] * 9, **run)
    gi.lyapunov(KEPLER, APOCENTRE, **run)


def in_a_step(y0: Any) -> gi.Integrator:
    return gi.Integrator(KEPLER, y0, "rk-4")


def test_a_new_state_is_another_motion_and_one_warning_is_enough() -> None:
    """From a far state to a near one nothing has jumped; what is too fast is told once."""
    motion = in_a_step([1.0, 0.0, 0.0, 1.0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for turn in np.linspace(0.0, 6.0, 30):
            motion.state = [np.cos(turn), np.sin(turn), -np.sin(turn), np.cos(turn)]
            motion.step(20)
    motion.state = [0.01, 0.0, 0.0, 10.0]
    with pytest.warns(gi.GeomintWarning, match="steps of .* err by"):
        motion.step(2000)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        motion.step(2000)


def test_scipys_runs_from_tolerances_tell_what_comes_after_the_pilot_run() -> None:
    def later(t: float, y: Any) -> Any:
        w = 1.0 + 20.0 * np.exp(-(((t - 300.0) / 2.0) ** 2))
        return np.array([y[1], -w * w * y[0]])

    with pytest.warns(gi.GeomintWarning, match=r"times rtol and atol, near t = (29|30)"):
        solve_ivp(later, (0.0, 500.0), [1.0, 0.0], gi.scipy.RK4)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solve_ivp(later, (0.0, 250.0), [1.0, 0.0], gi.scipy.RK4)
        solve_ivp(later, (0.0, 500.0), [1.0, 0.0], gi.scipy.RK4, step=0.5)


FORMS = {
    "action": (turned(37.0, 0.05, 0.0), [0.6, 0.0, 0.8], "rkmk-dop853"),
    "hamiltonian": (double_pendulum.problem(), double_pendulum.INITIAL, "lobatto-8"),
    "splitting": (abc_flow.problem(), abc_flow.INITIAL, "verlet-8"),
}


@pytest.mark.parametrize("form", FORMS)
def test_the_default_method_fits_the_form(form: str) -> None:
    """Where none is named; the motion is that of the field."""
    given, y0, name = FORMS[form]
    gone = dict.fromkeys(("field", "action", "hamiltonian", "splitting"))
    p, end = dataclasses.replace(given, **{**gone, form: getattr(given, form)}), ending(given, 2.0)
    run = gi.solve(p, y0, **end)
    assert run.method.name == name
    right = solve(given, y0, **end, method="dop853" if given.field else "rkmk-4", step=0.01).y[-1]
    np.testing.assert_allclose(run.y[-1], right, atol=1e-7)
    motion = gi.Integrator(p, y0)
    assert motion.method.name == name
    motion.step()
    assert gi.poincare_section(p, y0, event=first_of(p), points=1, end=50.0).steps > 0
    with pytest.raises(gi.FormError, match=r"given as field=f of geomint.Problem"):
        gi.solve(p, y0, **end, method="gauss-8")


@gi.field
def later(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """A rotation that is three hundred times as fast in the end."""
    rate = 1.0 + 300.0 * y[2] * y[2] * y[2] * y[2]
    out[0] = rate * y[1]
    out[1] = -rate * y[0]
    out[2], out[3] = 0.2 + 0.0 * y[0], 0.0 * y[0]


@pytest.mark.filterwarnings("ignore::geomint.GeomintWarning")
def test_a_default_step_that_fails_is_halved() -> None:
    """In loops from where it fails; in what else takes no given one as in runs."""
    p = gi.Problem("later", (("q", 1), ("p", 1), ("z", 1), ("c", 1)), field=later)
    y0, method = [1.0, 0.0, 0.0, 0.0], gi.Gauss(4, iteration="fixed-point")
    end = gi.solve(p, y0, t_end=5.0, method=method).y[-1]
    motion = gi.Integrator(p, y0, method)
    first = motion.h
    with pytest.warns(gi.StepWarning, match="from there steps are half as long"):
        motion.propagate_until(5.0)
    assert (motion.time, motion.h < 0.6 * first) == (5.0, True)
    np.testing.assert_allclose(np.hypot(*motion.state[:2]), 1.0, atol=1e-12)
    again = gi.Integrator(p, y0, method)
    again.step(40)
    assert (again.steps, again.h < first) == (40, True)
    for share in (0.55, 0.95):  # of which only the last step, less than a whole one, fails
        last = gi.Integrator(p, y0, method)
        last.state = [1.0, 0.0, 0.7, 0.0]
        last.propagate_for(share * last.h)
        np.testing.assert_allclose(np.hypot(*last.state[:2]), 1.0, atol=1e-12)
    with pytest.raises(gi.ConvergenceError):
        gi.Integrator(p, y0, method, step=first).propagate_until(5.0)
    np.testing.assert_allclose(gi.tangent_flow(p, y0, t_end=5.0, method=method).y, end, atol=1e-6)
    found = gi.sensitivities(p, y0, t_end=5.0, method=method)
    np.testing.assert_allclose(found.y, end, atol=1e-6)


# Forwards from time 0, and backwards from 0.7 with the last piece at rest: published results were
# made with these.
TIMES = {
    "seasonal-lotka-volterra": (0.7142857143, 0.834008589),
    "henon-heiles": (0.6666666667, 0.8312538755), "spherical-pendulum": (0.8821253025, 1.118033989),
    "double-spherical-pendulum": (1.219649979, 1.179309266),
    "pulsating-body": (1.050483227, 0.4452493851), "so-4-flow": (1.29126379, 1.336849537),
    "so-3-flow": (0.9015428567, 1.010529165), "abc-flow": (1.132021516, 1.249484726),
    "neumann-3": (0.9735148804, 0.9791681789), "frame-in-field": (0.8481132753, 0.9489867436),
    "sphere-metric-3": (0.6279982885, 0.7847041314),
    "outer-solar-system-6": (1028.112665, 516.6390856), "schwarzschild": (19.52882108, 26.30436584),
    "spring-pendulum": (0.01, 0.01), "fast-rotor": (0.009090909091, 0.009090909091),
    "fast-top": (0.02083333333, 0.0125), "toda-3": (0.5115561741, 0.4470594107),
    "morse": (0.4833366053, 0.5153730454),
}  # fmt: skip


def test_characteristic_times_are_those_that_they_have_been() -> None:
    for problem, y0 in examples():
        methods = map(gi.find_method, ("rk-4", "cf-4", "verlet-2", "rattle-2"))
        method = next(m for m in methods if m.needs in problem.forms)
        rest = np.where(np.arange(problem.rows) < problem.rows - problem.pieces[-1][1], y0, 0.0)
        runs = (y0, rest), (math.inf, -3.0), (0.0, 0.7)
        for y, end, begin, known in zip(*runs, TIMES[problem.name], strict=True):
            found = method.default_step(problem, y, end, begin) / method.step_fraction
            assert found == pytest.approx(known, rel=1e-7), problem.name
