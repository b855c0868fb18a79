"""Adaptive steps: what is asked for is reached, no more is done than needed, failures are typed."""

from __future__ import annotations

import dataclasses
import math
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.integrate import solve_ivp

import chaplygin as ch
import geomint as gi
from geomint.kernels.numbers.blocks import Block
from geomint.kernels.solve.step_control import error_size, exponential, logarithm, retry_factor
from geomint.methods import methods
from geomint.problems.declaration import check_problem
from geomint.problems.testproblems import pulsating_body
from geomint.tableaux import RUNGE_KUTTA
from tests.problems import lotka_volterra, so_n_flow

ADAPTIVE = [name for name, method in methods().items() if method.adaptive]
OF_FIELDS = [name for name in ADAPTIVE if gi.find_method(name).needs == "field"]
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
    problem, y0 = cases(form)[index]
    return gi.solve(problem, y0, t_end=T_END, step=0.04, method="gauss-12").y[-1]


def error(name: str, index: int, rtol: float) -> tuple[float, gi.Solution]:
    """The largest error at the end of a run, and the run."""
    method = gi.find_method(name).with_options(rtol=rtol, atol=1e-4 * rtol)
    problem, y0 = cases(method.needs)[index]
    sol = gi.solve(problem, y0, t_end=T_END, method=method)
    return float(np.max(np.abs(sol.y[-1] - truth(method.needs, index)))), sol


# --- accuracy -------------------------------------------------------------------------------------


def test_all_adaptive_methods_are_known() -> None:
    """Every tableau with embedded weights, on fields and on groups in both coordinates."""
    tableaux = [name for name, table in RUNGE_KUTTA.items() if table.b_hat is not None]
    families = ("{}", "rkmk-{}", "rkmk-cayley-{}")
    assert set(ADAPTIVE) == {f"{f.format(t)}-adaptive" for f in families for t in tableaux}


@pytest.mark.parametrize("name", ADAPTIVE)
def test_the_error_is_proportional_to_the_tolerance(name: str) -> None:
    """Over four powers of ten, and of its size."""
    tolerances = (1e-5, 1e-7, 1e-9) if "bogacki" in name else (1e-6, 1e-8, 1e-10)
    for index in range(len(cases(gi.find_method(name).needs))):
        errors = [error(name, index, rtol)[0] for rtol in tolerances]
        slopes = [
            math.log(e / f) / math.log(r / s)
            for (e, r), (f, s) in pairwise(zip(errors, tolerances, strict=True))
        ]
        assert all(0.003 <= e / r <= 30.0 for e, r in zip(errors, tolerances, strict=True)), errors
        overall = math.log(errors[0] / errors[-1]) / math.log(tolerances[0] / tolerances[-1])
        assert overall == pytest.approx(1.0, abs=0.2), slopes


@pytest.mark.parametrize(
    ("name", "scipy_name"),
    [
        ("bogacki-shampine-3-adaptive", "RK23"),
        ("dormand-prince-5-adaptive", "RK45"),
        ("dop853-adaptive", "DOP853"),
    ],
)
def test_against_scipy(name: str, scipy_name: str) -> None:
    """At equal tolerances as accurate; for the same error hardly more evaluations."""
    problem, y0 = cases("field")[0]
    for rtol in (1e-5, 1e-8, 1e-11):
        ours, sol = error(name, 0, rtol)
        theirs = solve_ivp(
            lambda t, y: gi.derivative(problem, y, t),
            (0.0, T_END),
            y0,
            method=scipy_name,
            rtol=rtol,
            atol=1e-4 * rtol,
        )
        their_error = np.max(np.abs(theirs.y[:, -1] - truth("field", 0)))
        assert ours <= max(2.0 * their_error, rtol)
        worth = (their_error / ours) ** (1.0 / gi.find_method(name).order)
        assert sol.evaluations <= 1.25 * worth * theirs.nfev


# --- steps ----------------------------------------------------------------------------------------


@gi.field
def bump(params, t, y, out, work):
    """Slow, but for a moment at t = 5."""
    z = (t - 5.0) / 0.01
    out[0] = 100.0 / (1.0 + z * z) - y[0]
    out[1] = y[0]


BUMP = gi.Problem("bump", (("x", 1), ("y", 1)), field=bump)


class Counter:
    """Counts the calls of a recorded function, in plain Python."""

    def __init__(self, function: gi.Problem) -> None:
        self.calls, self._function = 0, function
        self.field = gi.field(self._count())

    def _count(self) -> object:
        def counted(*args):
            self.calls += 1
            return self._function.function(*args)

        return counted


@pytest.mark.nojit
@pytest.mark.parametrize("name", OF_FIELDS)
def test_rejected_steps_are_counted(name: str) -> None:
    """And so are the evaluations: those of rejected steps too, but no first stage twice."""
    counter = Counter(bump)
    problem = dataclasses.replace(BUMP, field=counter.field)
    check_problem(problem, np.array([1.0, 0.0]), "field")  # runs it once, and remembers
    for _ in range(2):  # the first one looks at what the problem declares, too
        counter.calls = 0
        sol = gi.solve(
            problem, [1.0, 0.0], t_end=10.0, step=0.1, method=name, save_every=1, compiled=False
        )
    assert sol.rejected >= 2
    assert sol.iterations == sol.steps + sol.rejected
    assert sol.evaluations == counter.calls
    assert len(sol.t) == sol.steps + 1
    lengths = np.diff(sol.t)
    sizes = sol.step_sizes
    assert sizes.min == pytest.approx(np.min(lengths[:-2]), rel=1e-6)
    assert sizes.max == pytest.approx(np.max(lengths[:-2]), rel=1e-6)
    assert sizes.mean == pytest.approx(np.mean(lengths)) == pytest.approx(sol.step)
    assert sizes.max > 20.0 * sizes.min
    assert f"steps {sol.steps} of mean" in " ".join(repr(sol).split())


def test_rejected_steps_on_a_group() -> None:
    """A generator that changes suddenly; a first step that turns too far is one of them."""
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
    exact = gi.solve(
        problem, y0, t_end=t_end, method="gauss-8", step=abs(t_end) / 300, t_eval=wanted
    ).y
    np.testing.assert_allclose(sol.y, exact, rtol=0, atol=1e-7)


def test_no_end_needs_a_crumb() -> None:
    """The last two steps share what is left, and the last one ends exactly, whatever rounds how."""
    problem, y0 = cases("field")[0]
    for t_end in np.random.default_rng(5).uniform(1.0, 30.0, 40):
        run = gi.solve(problem, y0, t_end=t_end, method="dop853-adaptive", save_every=1)
        assert run.t[-1] == t_end
        lengths = np.diff(run.t)
        assert lengths[-1] > 0.3 * lengths[-2]


def test_nothing_is_evaluated_beyond_the_end() -> None:
    """A field that ends with the run."""

    @gi.field
    def until(params, t, y, out, work):
        out[0] = gi.sqrt(2.0 - t) + 0.0 * y[0]
        out[1] = 0.0 * y[1]

    problem = gi.Problem("until", (("y", 2),), field=until)
    sol = gi.solve(problem, [0.0, 0.0], t_end=2.0, method="dormand-prince-5-adaptive")
    assert sol.y[-1, 0] == pytest.approx(2.0**1.5 / 1.5, abs=1e-6)


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


def test_a_rest_takes_few_steps() -> None:
    """Where nothing moves, steps grow tenfold and no error is divided by nothing."""

    @gi.field
    def rest(params, t, y, out, work):
        out[0] = 0.0 * y[0]
        out[1] = 0.0 * y[1]

    problem = gi.Problem("rest", (("x", 1), ("y", 1)), field=rest)
    method = gi.Adaptive(gi.RungeKutta("dormand-prince-5"), atol=0.0)
    sol = gi.solve(problem, [0.0, 1.0], t_end=1e6, method=method)
    np.testing.assert_array_equal(sol.y[-1], [0.0, 1.0])
    assert sol.steps < 20


def test_steps_do_not_depend_on_units() -> None:
    """With atol = 0, a state 10⁻¹⁵⁰ or 10¹⁵⁰ times as large takes the same steps."""

    @gi.field
    def turning(params, t, y, out, work):
        out[0] = (1.0 + 0.5 * gi.cos(3.0 * t)) * y[1]
        out[1] = -(1.0 + 0.5 * gi.cos(3.0 * t)) * y[0]

    problem = gi.Problem("turning", (("y", 2),), field=turning)
    for name in ("dormand-prince-5", "dop853"):
        method = gi.Adaptive(gi.RungeKutta(name), atol=0.0)
        runs = [
            gi.solve(problem, [size, 0.0], t_end=20.0, step=0.1, method=method)
            for size in (2.0**-500, 1.0, 2.0**500)
        ]
        for size, run in zip((2.0**-500, 1.0, 2.0**500), runs, strict=True):
            assert (run.steps, run.rejected) == (runs[1].steps, runs[1].rejected)
            np.testing.assert_array_equal(run.y[-1], size * runs[1].y[-1])


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


# --- structure ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [n for n in ADAPTIVE if n.startswith("rkmk")])
def test_orbits_are_kept(name: str) -> None:
    """To a random walk of roundings, whatever the steps."""
    for problem, y0 in cases("action"):
        sol = gi.solve(problem, y0, t_end=200.0, method=name, observe="invariants")
        assert sol.steps > 200
        for drift in sol.drift.values():
            assert drift.max_abs_error <= 8 * 2.0**-52 * math.sqrt(sol.steps) * drift.scale


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


def test_the_measure_can_be_watched() -> None:
    """Steps of any length: the same sum as that of the tableau at fixed steps of its size."""
    problem, y0 = cases("field")[0]
    adaptive = gi.solve(problem, y0, t_end=20.0, method="dop853-adaptive", observe=["measure"])
    step = 20.0 / adaptive.steps
    fixed = gi.solve(problem, y0, t_end=20.0, step=step, method="dop853", observe=["measure"])
    ratio = adaptive.drift["measure"].max_abs_error / fixed.drift["measure"].max_abs_error
    assert 0.1 < ratio < 10.0


def test_a_run_is_saved_and_read(tmp_path) -> None:
    """With its steps."""
    problem, y0 = cases("field")[0]
    sol = gi.solve(problem, y0, t_end=5.0, method="dop853-adaptive", save_every=1)
    sol.save(tmp_path / "run.nc")
    saved = gi.load(tmp_path / "run.nc")
    np.testing.assert_array_equal(saved.y, sol.y)
    assert saved.provenance["rejected"] == sol.rejected
    assert saved.provenance["step_sizes"] == sol.step_sizes._asdict()
    options = {"rtol": 1e-8, "atol": 1e-12, "max_step": None, "max_steps": 10**8}
    assert saved.provenance["method_options"] == options


# --- failures -------------------------------------------------------------------------------------


@gi.field
def explosion(params, t, y, out, work):
    out[0] = y[0] * y[0]
    out[1] = 0.0 * y[1]


EXPLOSION = gi.Problem("explosion", (("y", 2),), field=explosion)


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("name", OF_FIELDS)
def test_a_solution_that_ends(name: str, compiled: bool) -> None:
    """y = 1/(1 − t) has no value beyond its pole: a typed error at t = 1, with its numbers."""
    if "bogacki" in name and not compiled:
        pytest.skip("too many steps for plain Python")
    with pytest.raises(gi.StepSizeError, match=r"rtol = 1e-08 and .* ask for a step of") as caught:
        gi.solve(EXPLOSION, [1.0, 0.0], t_end=2.0, method=name, save_every=10, compiled=compiled)
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


def test_a_failure_does_not_depend_on_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor do its numbers."""
    from geomint.run import driver

    found = set()
    for size in (1, 7, 1000):
        monkeypatch.setattr(driver, "FIRST_CHUNK", size)
        with pytest.raises(gi.StepSizeError) as caught:
            gi.solve(EXPLOSION, [1.0, 0.0], t_end=2.0, method="dop853-adaptive", save_every=5)
        e = caught.value
        found.add((e.t, e.step, e.residual, e.h, e.iterations, e.partial.steps, len(e.partial.t)))
    assert len(found) == 1


def test_a_field_that_ends() -> None:
    """NaN beyond t = 1 is met with ever smaller steps, and then named."""

    @gi.field
    def until(params, t, y, out, work):
        out[0] = gi.sqrt(1.0 - t) + 0.0 * y[0]
        out[1] = 0.0 * y[1]

    problem = gi.Problem("until", (("y", 2),), field=until)
    with pytest.raises(gi.NonFiniteError, match=r"even with h = ") as caught:
        gi.solve(problem, [0.0, 0.0], t_end=2.0, method="dormand-prince-5-adaptive")
    assert caught.value.t == pytest.approx(1.0, abs=1e-8)
    assert caught.value.partial.y[-1, 0] == pytest.approx(2.0 / 3.0, abs=1e-7)


def test_a_nan_from_the_start() -> None:
    """Is not waited for."""

    @gi.field
    def never(params, t, y, out, work):
        out[0] = gi.sqrt(-1.0 - t * t) + 0.0 * y[0]
        out[1] = 0.0 * y[1]

    problem = gi.Problem("never", (("y", 2),), field=never)
    with pytest.raises(gi.NonFiniteError) as caught:
        gi.solve(problem, [0.0, 0.0], t_end=2.0, method="dormand-prince-5-adaptive")
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
        (lambda: gi.find_method("dop853-adaptive").with_options(rtol="1"), "rtol = '1'"),
        (lambda: gi.find_method("dop853").with_options(rtol=1e-3), "no option 'rtol'"),
    ],
)
def test_options_are_checked(make, message: str) -> None:
    """With name, value and expectation."""
    with pytest.raises(gi.GeomintError, match=message):
        make()


@pytest.mark.nojit
def test_options_are_kept() -> None:
    """Changing one leaves the others, the name and the coordinates."""
    method = gi.find_method("rkmk-cayley-dop853-adaptive").with_options(rtol=1e-6)
    assert method.options == {"rtol": 1e-6, "atol": 1e-12, "max_step": math.inf, "max_steps": 10**8}
    assert method.with_options(atol=0.0).options["rtol"] == 1e-6
    assert method.name == "rkmk-cayley-dop853-adaptive"
    assert "Cayley" in method.summary


# --- the controller -------------------------------------------------------------------------------


@pytest.mark.nojit
@given(st.floats(1e-12, 1e12))
def test_logarithm(x: float) -> None:
    """To 1e-9."""
    assert logarithm(x) == pytest.approx(math.log(x), abs=1e-9)


@pytest.mark.nojit
@given(st.floats(-5.0, 5.0))
def test_exponential(x: float) -> None:
    """To 1e-6, cut to the factors that are allowed."""
    assert exponential(x) == pytest.approx(min(max(math.exp(x), 0.2), 10.0), rel=1e-6)


@pytest.mark.nojit
@given(st.floats(1.0, exclude_min=True) | st.just(math.nan))
def test_a_retry_is_shorter(error: float) -> None:
    """Whatever went wrong."""
    assert 0.2 * (1 - 1e-6) <= retry_factor(5.0, error) < 0.91


def size_of(y: list[float], e: list[float], low: list[float] | None = None, **options) -> float:
    """The error of a state of two pieces, of one and two rows."""
    blocks = [Block(np.array(v, dtype=float)) for v in ([0, 1, 1], y, [0.0] * 3, e, low or e)]
    settings = {"rtol": 1e-3, "atol": 1e-6, **options}
    count = 1 if low is None else 2
    return error_size(settings["rtol"], settings["atol"], *blocks, count)


@pytest.mark.nojit
def test_the_size_of_an_error() -> None:
    """The largest ratio over the pieces, each measured by its own largest row."""
    assert size_of([1.0, 2.0, 0.0], [1e-3, 0.0, 0.0]) == pytest.approx(1e-3 / 1.001e-3)
    assert size_of([1.0, 0.0, 2.0], [0.0, 4e-3, 0.0]) == pytest.approx(4e-3 / 2.001e-3)
    assert size_of([0.0, 1.0, 1.0], [0.0, 0.0, 0.0], atol=0.0) == 0.0
    assert size_of([0.0, 1.0, 1.0], [1e-9, 0.0, 0.0]) == pytest.approx(1e-3)
    assert size_of([1e200, 1.0, 1.0], [1e198, 0.0, 0.0]) == pytest.approx(10.0)
    assert np.isnan(size_of([1.0, 1.0, 1.0], [0.0, np.nan, 0.0]))
    e, low = [1e-3, 0.0, 0.0], [1e-1, 0.0, 0.0]
    expected = 1e-3 / 1.001e-3 / math.sqrt(1.0 + 0.01 * 1e4)
    assert size_of([1.0, 1.0, 1.0], e, low) == pytest.approx(expected)


@pytest.mark.parametrize("limit", [1, 64, 65, 1000])
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


@pytest.mark.parametrize("limit", [0, -1, 10.5, math.inf, True])
def test_limits_that_make_no_sense(limit: float) -> None:
    with pytest.raises(gi.DomainError, match="max_steps"):
        gi.Adaptive(gi.RungeKutta("dop853"), max_steps=limit)


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
    out[0] = 1.0 * y[1]
    out[1] = -1.0 + 0.0 * y[0]
