"""Adaptive steps: what is asked for is reached, no more is done than needed, failures are typed."""

from __future__ import annotations

import dataclasses
import math
from collections import deque
from functools import cache
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import pulsating_body
from tests.problems import lotka_volterra, so_n_flow

ADAPTIVE = [name for name in gi.method_names() if gi.find_method(name).adaptive]
OF_FIELDS = [name for name in ADAPTIVE if gi.find_method(name).needs == "field"]
FAST = ("dormand-prince-5-adaptive", "rkmk-dormand-prince-5-adaptive")
T_END = 10.0


@cache
def cases(form: str) -> list[tuple[gi.Problem, np.ndarray]]:
    """The problems of a form: nonlinear, non-autonomous, non-commuting."""
    if form == "field":
        return [(lotka_volterra.problem(), lotka_volterra.INITIAL)]
    return [
        (pulsating_body.problem(), pulsating_body.INITIAL),
        (so_n_flow.problem(4), so_n_flow.initial(4)),
    ]


@cache
def truth(form: str, index: int) -> np.ndarray:
    return gi.solve(*cases(form)[index], t_end=T_END, step=0.05, method="gauss-8").y[-1]


def error(name: str, index: int, rtol: float) -> tuple[float, gi.Solution]:
    """The largest error at the end of a run, and the run."""
    method = gi.find_method(name).with_options(rtol=rtol, atol=1e-4 * rtol)
    problem, y0 = cases(method.needs)[index]
    sol = gi.solve(problem, y0, t_end=T_END, method=method)
    return float(np.max(np.abs(sol.y[-1] - truth(method.needs, index)))), sol


def each(names: list[str], problems: int = 1) -> pytest.MarkDecorator:
    """Adaptive methods on problems of their form; of each kind one in the fast row."""
    found = []
    for name in names:
        for index in range(min(problems, len(cases(gi.find_method(name).needs)))):
            late = [pytest.mark.nightly] * (name not in FAST or index > 0)
            found.append(pytest.param(name, index, marks=late))
    return pytest.mark.parametrize(("name", "index"), found)


# --- accuracy -------------------------------------------------------------------------------------


@each(ADAPTIVE, 2)
def test_the_error_is_proportional_to_the_tolerance(name: str, index: int) -> None:
    """Over four powers of ten, and of its size."""
    tolerances = (1e-5, 1e-7, 1e-9) if "bogacki" in name else (1e-6, 1e-8, 1e-10)
    errors = [error(name, index, rtol)[0] for rtol in tolerances]
    assert all(0.003 <= e / r <= 30.0 for e, r in zip(errors, tolerances, strict=True)), errors
    overall = math.log(errors[0] / errors[-1]) / math.log(tolerances[0] / tolerances[-1])
    assert overall == pytest.approx(1.0, abs=0.2), errors


# --- steps ----------------------------------------------------------------------------------------


def textbook(
    table: Any, problem: gi.Problem, y: np.ndarray, end: float, h: float, rtol: float, atol: float
) -> tuple[list[float], int]:
    """Times of accepted steps and the number of tries: the PI controller of Gustafsson (1991).

    What is allowed in a piece is by its largest row, before and after; the largest ratio counts.
    """
    t, times, former, tries, rejected = 0.0, [0.0], 1.0, 0, False
    A, b = table.A_float, table.b_float
    weights = [b - np.array(w, dtype=float) for w in (table.b_hat, table.b_low) if w is not None]
    while t < end:
        tries += 1
        left = end - t
        last, tried = left <= h, h
        h = left if last else 0.5 * left if left < 2.0 * h else h
        K = np.zeros((len(b), len(y)))
        for i, c in enumerate(table.c_float):
            K[i] = gi.derivative(problem, y + h * A[i] @ K, t + c * h)
        new = y + h * b @ K
        sizes = []
        for w in weights:
            off = np.abs(h * w @ K)
            sizes.append(
                max(
                    off[p].max() / (atol + rtol * max(np.abs(y[p]).max(), np.abs(new[p]).max()))
                    for p in problem.slices.values()
                )
            )
        e = sizes[0] if len(sizes) == 1 else sizes[0] ** 2 / np.hypot(sizes[0], 0.1 * sizes[1])
        if e > 1.0:
            h, rejected = h * max(0.2, 0.9 * e ** (-1.0 / table.estimate_order)), True
            continue
        factor = 0.9 * (former**0.4 / e**0.7) ** (1.0 / table.estimate_order)
        factor = min(max(factor, 0.2), 1.0 if rejected else 10.0)
        y, t = new, end if last else t + h
        h = max(factor * h, tried) if last else factor * h
        former, rejected = max(e, 1e-4), False
        times.append(t)
    return times, tries


@gi.field
def two_sizes(params, t, y, out, work):
    """A circle beside a decay a thousand times as large, kicked for a moment at t = 3."""
    z = (t - 3.0) / 0.05
    out[0] = y[1] + 10.0 / (1.0 + z * z)
    out[1] = -y[0]
    out[2] = -0.3 * y[2] + 300.0 * gi.sin(t)


SIZES = gi.Problem("sizes", (("x", 2), ("z", 1)), field=two_sizes)


def first_step(y: np.ndarray, end: float, p: int, rtol: float, atol: float) -> float:
    """By Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, page 169."""
    sizes = np.array([*[np.abs(y[:2]).max()] * 2, abs(y[2])])
    scale, f = atol + rtol * sizes, gi.derivative(SIZES, y, 0.0)
    d0, d1 = np.abs(y / scale).max(), np.abs(f / scale).max()
    h0 = min(0.01 * d0 / d1 if d0 >= 1e-5 and d1 >= 1e-5 else 1e-6, abs(end)) * np.sign(end)
    d2 = np.abs((gi.derivative(SIZES, y + h0 * f, h0) - f) / scale).max() / abs(h0)
    return min(100.0 * abs(h0), (0.01 / max(d1, d2)) ** (1.0 / (p + 1.0)), abs(end))


@pytest.mark.parametrize("end", [7.0, -7.0, 1e-5])
@pytest.mark.parametrize(("rtol", "atol"), [(1e-5, 1e-3), (2e-9, 0.0), (1e-3, 1e9)])
def test_the_first_step_is_that_of_the_textbook(rtol: float, atol: float, end: float) -> None:
    for y in (np.array([0.3, -2.0, 1e3]), np.array([-1e-3, 0.0, -5.0])):
        for name in ("bogacki-shampine-3-adaptive", "dop853-adaptive"):
            method = gi.find_method(name).with_options(rtol=rtol, atol=atol)
            known = first_step(y, end, method.order, rtol, atol)
            assert method.default_step(SIZES, y, end) == pytest.approx(known, rel=1e-12)


@pytest.mark.nojit
@pytest.mark.parametrize("name", OF_FIELDS)
@pytest.mark.parametrize(("rtol", "atol", "first"), [(1e-5, 1e-3, 0.3), (2e-5, 0.0, 3.0)])
def test_steps_are_those_of_the_textbook(name: str, rtol: float, atol: float, first: float) -> None:
    """Accepted, rejected, the last two, and how long each is."""
    method, y0 = gi.find_method(name).with_options(rtol=rtol, atol=atol), np.array([1.0, 0.0, 1e3])
    run = {"method": method, "step": first, "save_every": 1, "compiled": False}
    sol = gi.solve(SIZES, y0, t_end=7.0, **run)
    times, tries = textbook(method.base.table, SIZES, y0, 7.0, first, rtol, atol)
    assert sol.steps + sol.rejected == tries > sol.steps + 2
    np.testing.assert_allclose(sol.t, times, rtol=1e-5)


@pytest.mark.nojit
@pytest.mark.parametrize("name", OF_FIELDS)
def test_rejected_steps_are_counted(name: str) -> None:
    """And so are the evaluations: those of rejected steps too, but no first stage twice."""
    calls: deque[int] = deque()

    def counted(params, t, y, out, work):
        calls.append(1)
        two_sizes.function(params, t, y, out, work)

    problem = dataclasses.replace(SIZES, field=gi.field(counted))
    method = gi.find_method(name).with_options(rtol=1e-5)
    run = {"t_end": 4.0, "step": 0.3, "method": method, "save_every": 1, "compiled": False}
    for _ in range(2):  # the first one looks at what the problem declares, too
        calls.clear()
        sol = gi.solve(problem, [1.0, 0.0, 1e3], **run)
    assert sol.rejected >= 1
    assert sol.evaluations == len(calls)
    lengths, sizes = np.diff(sol.t), sol.step_sizes
    assert sizes.min == pytest.approx(np.min(lengths[:-2]), rel=1e-6)
    assert sizes.max == pytest.approx(np.max(lengths[:-2]), rel=1e-6)
    assert sizes.mean == pytest.approx(np.mean(lengths)) == pytest.approx(sol.step)
    assert f"steps {sol.steps} of mean" in " ".join(repr(sol).split())


def test_rejected_steps_on_a_group() -> None:
    """A first step that turns too far is one of them."""
    problem, y0 = cases("action")[0]
    sol = gi.solve(problem, y0, t_end=10.0, step=9.0, method="rkmk-dormand-prince-5-adaptive")
    assert 1 <= sol.rejected <= 20
    reference = gi.solve(problem, y0, t_end=10.0, method="rkmk-dormand-prince-5-adaptive")
    np.testing.assert_allclose(sol.y[-1], reference.y[-1], rtol=0, atol=1e-6)


@pytest.mark.parametrize("t_end", [3.0, -3.0, 1e-3])
@pytest.mark.parametrize("name", ["dop853-adaptive", "rkmk-dop853-adaptive"])
def test_the_end_and_the_times_asked_for_are_met(name: str, t_end: float) -> None:
    """Exactly, forwards and backwards, without disturbing the run."""
    method = gi.find_method(name)
    problem, y0 = cases(method.needs)[0]
    wanted = t_end * np.array([0.0, 0.1, 0.35, 0.9999, 1.0])
    run = gi.solve(problem, y0, t_end=t_end, method=method, save_every=1)
    assert run.t[-1] == t_end
    assert (np.diff(run.t) * t_end > 0.0).all()
    sol = gi.solve(problem, y0, t_end=t_end, method=method, t_eval=wanted)
    np.testing.assert_array_equal(sol.t, wanted)
    np.testing.assert_array_equal(sol.y[-1], run.y[-1])
    run = {"method": "gauss-8", "step": abs(t_end) / 20}
    exact = gi.solve(problem, y0, t_end=t_end, t_eval=wanted, **run).y
    np.testing.assert_allclose(sol.y, exact, rtol=0, atol=1e-7)


def test_no_end_needs_a_crumb() -> None:
    """The last two steps share what is left, and the last one ends exactly, whatever rounds how."""
    problem, y0 = cases("field")[0]
    for t_end in np.random.default_rng(5).uniform(1.0, 30.0, 40):
        run = gi.solve(problem, y0, t_end=t_end, method="dop853-adaptive", save_every=1)
        assert run.t[-1] == t_end
        lengths = np.diff(run.t)
        assert lengths[-1] > 0.3 * lengths[-2]


def test_first_and_longest_step() -> None:
    """`step` is the first step; `max_step` bounds all of them, the first too."""
    problem, y0 = cases("field")[0]
    method = gi.Adaptive(gi.RungeKutta("dop853"))
    sol = gi.solve(problem, y0, t_end=5.0, step=0.01, method=method, save_every=1)
    assert sol.t[1] == 0.01
    short = method.with_options(max_step=0.05)
    sol = gi.solve(problem, y0, t_end=5.0, step=0.2, method=short, save_every=1)
    assert np.max(np.diff(sol.t)) <= 0.05 * (1 + 1e-12)
    assert sol.steps == pytest.approx(100, abs=3)
    assert sol.rejected == 0


@gi.field
def turning(params, t, y, out, work):
    out[0] = params[0] * (1.0 + 0.5 * gi.cos(3.0 * t)) * y[1]
    out[1] = -params[0] * (1.0 + 0.5 * gi.cos(3.0 * t)) * y[0]


@pytest.mark.parametrize("name", ["dormand-prince-5", "dop853"])
def test_steps_do_not_depend_on_units_and_rest_takes_few(name: str) -> None:
    """With atol = 0, a state 10⁻¹⁵⁰ or 10¹⁵⁰ times as large takes the same steps."""
    method = gi.Adaptive(gi.RungeKutta(name), atol=0.0)
    problem, runs = gi.Problem("turning", (("y", 2),), [1.0], field=turning), {}
    for size in (1.0, 2.0**-500, 2.0**500):
        run = runs[size] = gi.solve(problem, [size, 0.0], t_end=20.0, step=0.1, method=method)
        assert (run.steps, run.rejected) == (runs[1.0].steps, runs[1.0].rejected)
        np.testing.assert_array_equal(run.y[-1], size * runs[1.0].y[-1])
    still = dataclasses.replace(problem, params=[0.0])
    rest = gi.solve(still, [0.0, 1.0], t_end=1e6, method=method)
    np.testing.assert_array_equal(rest.y[-1], [0.0, 1.0])
    assert rest.steps < 25


# --- reparametrised time --------------------------------------------------------------------------


def test_a_physical_end_is_met() -> None:
    """A problem in τ runs until its clock shows t_end; t_eval is physical time as ever."""
    problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
    y0 = problem.state(gamma=[0.6, 0.0, 0.8], p=[0.8, 1.0, -0.6])
    wanted = [1.0, 2.5, 7.0]
    method = gi.Adaptive(gi.RungeKutta("dop853"), rtol=1e-11, atol=0.0)
    for sign in (1.0, -1.0):
        times = [sign * t for t in wanted]
        sol = gi.solve(problem, y0, t_end=times[-1], method=method, t_eval=times)
        np.testing.assert_array_equal(sol.t, times)
        exact = gi.solve(problem, y0, t_end=times[-1], method="gauss-8", step=0.1, t_eval=times)
        np.testing.assert_allclose(sol.tau, exact.tau, rtol=1e-9)
        np.testing.assert_allclose(sol.y, exact.y, rtol=0, atol=1e-8)
    ends = gi.solve(problem, y0, tau_end=3.0, method=method, clock=True)
    assert ends.tau[-1] == 3.0
    clock = gi.solve(problem, y0, tau_end=3.0, method="gauss-8", step=0.05)
    assert ends.t[-1] == pytest.approx(clock.t[-1], rel=1e-9)


def test_observers_see_accepted_steps() -> None:
    """Every so many, and the end."""
    problem, y0 = cases("field")[0]
    kwargs = {"t_end": 20.0, "method": "dormand-prince-5-adaptive"}
    every = gi.solve(problem, y0, observe={"first": first_row}, save_every=1, **kwargs)
    some = gi.solve(problem, y0, observe={"first": first_row}, observe_every=7, **kwargs)
    assert every.drift["first"].windows.samples == every.steps
    assert some.drift["first"].windows.samples == every.steps // 7 + (every.steps % 7 > 0)
    assert some.drift["first"].final_error == every.drift["first"].final_error
    assert every.drift["first"].final_error == every.y[-1, 0] - every.y[0, 0]
    assert some.drift["first"].windows.last_time == 20.0


@gi.observable
def first_row(params, t, y, work):
    return y[0]


# --- failures -------------------------------------------------------------------------------------


@gi.field
def explosion(params, t, y, out, work):
    out[0], out[1] = y[0] * y[0], 0.0 * y[1]


@gi.field
def until(params, t, y, out, work):
    """No number beyond the time that is given."""
    out[0], out[1] = gi.sqrt(params[0] - t) + 0.0 * y[0], 0.0 * y[1]


EXPLOSION = gi.Problem("explosion", (("y", 2),), field=explosion)


def ending_at(time: float, t_end: float = 2.0) -> gi.Solution:
    """A run of a field that ends."""
    problem = gi.Problem("until", (("y", 2),), [time], field=until)
    return gi.solve(problem, [0.0, 0.0], t_end=t_end, method="dormand-prince-5-adaptive")


@pytest.mark.parametrize("name", OF_FIELDS)
def test_a_solution_that_ends(name: str) -> None:
    """y = 1/(1 − t) has no value beyond its pole: a typed error at t = 1, with its numbers."""
    with pytest.raises(gi.StepSizeError, match=r"rtol = 1e-08 and .* ask for a step of") as caught:
        gi.solve(EXPLOSION, [1.0, 0.0], t_end=2.0, method=name, save_every=10)
    failure = caught.value
    assert failure.t == pytest.approx(1.0, abs=1e-6)
    assert 0.0 < failure.h < 1e-14
    assert failure.residual > 0.0
    partial = failure.partial
    assert partial.status == "failed"
    assert partial.steps == failure.step > 20
    assert partial.t[-1] == failure.t
    assert np.isfinite(partial.y).all()
    early = partial.t < 0.99
    np.testing.assert_allclose(partial.y[early, 0], 1.0 / (1.0 - partial.t[early]), rtol=1e-4)


def test_a_field_that_ends() -> None:
    """NaN is met with ever smaller steps and named, from the start at once, after the end never."""
    assert ending_at(2.0).y[-1, 0] == pytest.approx(2.0**1.5 / 1.5, abs=1e-6)
    with pytest.raises(gi.NonFiniteError, match=r"even with h = ") as caught:
        ending_at(1.0)
    assert caught.value.t == pytest.approx(1.0, abs=1e-8)
    assert caught.value.partial.y[-1, 0] == pytest.approx(2.0 / 3.0, abs=1e-7)
    with pytest.raises(gi.NonFiniteError) as caught:
        ending_at(-1.0)
    assert (caught.value.t, caught.value.step) == (0.0, 0)


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: gi.Adaptive(gi.RungeKutta("rk-4")), "'rk-4' has no embedded method"),
        (lambda: gi.Adaptive(gi.Gauss(8)), "'gauss-8' has no embedded method"),
        (lambda: gi.Adaptive(gi.Adaptive(gi.RungeKutta("dop853"))), "has no embedded method"),
        (lambda: gi.Adaptive("dop853"), "expected a geomint method"),
        (lambda: gi.Adaptive(gi.RungeKutta("dop853"), rtol=1e-17), "rtol = 1e-17"),
        (lambda: gi.Adaptive(gi.RungeKutta("dop853"), rtol=True), "rtol = True"),
        (lambda: gi.Adaptive(gi.RungeKutta("dop853"), rtol=math.nan), "rtol = nan"),
        (lambda: gi.Adaptive(gi.RKMK("dop853"), atol=-1.0), "atol = -1.0"),
        (lambda: gi.Adaptive(gi.RKMK("dop853"), max_step=0), "max_step = 0"),
        (lambda: gi.Adaptive(gi.RKMK("dop853"), max_steps=0), "max_steps = 0"),
        (lambda: gi.Adaptive(gi.RKMK("dop853"), max_steps=math.inf), "max_steps = inf"),
        (lambda: gi.find_method("dop853-adaptive").with_options(rtol="1"), "rtol = '1'"),
        (lambda: gi.find_method("dop853").with_options(rtol=1e-3), "no option 'rtol'"),
    ],
)
def test_options_are_checked(make, message: str) -> None:
    """With name, value and expectation."""
    with pytest.raises(gi.GeomintError, match=message):
        make()


@pytest.mark.parametrize("limit", [1, 65])
@pytest.mark.parametrize("name", ["dop853-adaptive", "rkmk-dop853-adaptive"])
def test_no_more_steps_than_allowed(name: str, limit: int) -> None:
    """A limit that is met by the end is none; one step less is a typed error with what there is."""
    problem, y0 = cases("action")[0]
    method = gi.find_method(name).with_options(max_step=2.0**-7)
    with pytest.raises(gi.StepLimitError, match=rf"max_steps = {limit}\b") as caught:
        gi.solve(problem, y0, t_end=100.0, method=method.with_options(max_steps=limit))
    assert caught.value.step == limit == caught.value.partial.steps
    assert caught.value.residual == pytest.approx(100.0 - caught.value.t)
    whole = gi.solve(problem, y0, t_end=caught.value.t, method=method)
    again = method.with_options(max_steps=whole.steps)
    same = gi.solve(problem, y0, t_end=caught.value.t, method=again)
    assert same.steps == whole.steps
    assert np.array_equal(same.y, whole.y)


@pytest.mark.parametrize("name", ["dop853-adaptive", "dormand-prince-5-adaptive"])
@pytest.mark.parametrize("t0", [4.24, -1e3, 1e6])
def test_a_first_step_that_no_time_can_tell(name: str, t0: float) -> None:
    """Nearly from rest the first step that tolerances allow is no step there: it is made longer."""
    problem = gi.Problem("fall", (("q", 1), ("v", 1)), field=falls)
    for options in ({}, {"step": 1e-18}):
        for v in (1e-16, 1e-14, 1e-12):
            sol = gi.solve(problem, [0.0, v], t0=t0, t_end=t0 + 1.0, method=name, **options)
            np.testing.assert_allclose(sol.y[-1], [-0.5, -1.0], rtol=0, atol=1e-11)


@gi.field
def falls(params, t, y, out, work) -> None:
    out[0], out[1] = 1.0 * y[1], -1.0 + 0.0 * y[0]
