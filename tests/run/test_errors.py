"""Failures: typed, with their numbers, at the right step, and never a silent last iterate."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from numba.core import config
from numba.core.errors import NumbaError

import geomint as gi
from geomint.problems.testproblems import henon_heiles
from geomint.run import driver
from geomint.tableaux import gauss_legendre
from tests.problems import lotka_volterra, so_n_flow, spherical_pendulum

pytestmark = pytest.mark.nojit
compiler = pytest.mark.skipif(config.DISABLE_JIT, reason="nothing is compiled")
PLAIN: dict[str, Any] = {"compiled": False, "progress": False}  # few steps of many kernels
TURNED_FAR = (gi.NonFiniteError, gi.StepSizeError)


def nightly(*names: str) -> list[Any]:
    return [pytest.param(name, marks=pytest.mark.nightly) for name in names]


@gi.field
def ending(params, t, y, out, work):
    """The first row explodes, or goes on evenly to where the root in the second one ends."""
    out[0], out[1] = params[0] * y[0] * y[0] + (1.0 - params[0]), gi.sqrt(1.0 - params[1] * y[0])


EXPLOSION = gi.Problem("explosion", (("y", 1), ("z", 1)), [1.0, 0.0], field=ending)
LATE_NAN = dataclasses.replace(EXPLOSION, params=[0.0, 1.0])


@pytest.mark.parametrize("method", ["rk-4", "gauss-2", *nightly("dop853", "gauss-8", "gauss-12")])
@pytest.mark.parametrize("compiled", [True, False])
def test_a_solution_that_explodes(method: str, compiled: bool) -> None:
    """At t = 1; what was computed before is finite and kept, and nothing is said beside the error."""
    run = {"step": 0.1, "method": method, "save_every": 1, "compiled": compiled}
    with pytest.raises((gi.ConvergenceError, gi.NonFiniteError)) as caught:
        gi.solve(EXPLOSION, [1.0, 0.0], t_end=2.0, **run)
    error, partial = caught.value, caught.value.partial
    assert 0.5 <= error.t < 1.5
    assert error.step == partial.steps == len(partial.y) - 1 == round(error.t / 0.1)
    assert error.iterations >= 1
    assert (partial.status, partial.success, partial.message) == ("failed", False, str(error))
    assert partial.t[-1] == pytest.approx(error.t)
    assert np.isfinite(partial.y).all()
    np.testing.assert_allclose(partial.y[: error.step - 1, 1], partial.t[: error.step - 1])
    with pytest.raises(gi.StepError):
        gi.solve(EXPLOSION, [1e200, 0.0], t_end=1.0, **run)


@pytest.mark.parametrize(
    "method", ["rk-4", "gauss-2", *nightly("gauss-8", "gauss-11", "gauss-1-suzuki-4")]
)
def test_a_nan_in_one_row_is_not_a_result(method: str) -> None:
    """Though the other rows are fine: never NaN with success; in a last step, or at a time, neither."""
    run = {"step": 0.1, "method": method}
    for more, t in (({"save_every": 1}, 0.7), ({"t_eval": [1.5]}, 0.7), ({"t_end": 1.05}, 0.9)):
        kind = gi.NonFiniteError if "t_end" not in more else gi.StepError
        with pytest.raises(kind) as caught:
            gi.solve(LATE_NAN, [0.0, 0.0], **{"t_end": 2.0, **run, **more})
        assert t < caught.value.t <= 1.0
        assert caught.value.step == round(10 * caught.value.t)
        assert np.isfinite(caught.value.partial.y).all()
        assert len(caught.value.partial.y) > 0 or "t_eval" in more
    with pytest.raises(gi.NonFiniteError) as caught:
        gi.solve(LATE_NAN, [2.0, 0.0], t_end=2.0, **run)
    assert (caught.value.t, caught.value.step) == (0.0, 0)


@gi.field
def runaway(params, t, y, out, work):
    out[0] = 1.0 / (1.0 - t)
    out[1] = y[3] * y[3] / (1.05 - t)
    out[2] = gi.sqrt(1.02 - t)


RUNAWAY = gi.Problem("runaway", (("v", 6),), action=gi.GroupAction(runaway, gi.so3(2)))


@pytest.mark.parametrize(
    "method", ["cf-4", "rkmk-4", "rkmk-cayley-4", *nightly("cf-3", "rkmk-dop853")]
)
def test_a_generator_that_fails(method: str) -> None:
    """At the pole, or where the square root ends, or where a step turns too far."""
    y0 = [1.0, 0.0, 0.0, 0.0, 0.6, 0.8]
    with pytest.raises(TURNED_FAR) as caught:
        gi.solve(RUNAWAY, y0, t_end=2.0, step=0.05, method=method, save_every=1, **PLAIN)
    assert 0.9 <= caught.value.t <= 1.05
    lengths = np.linalg.norm(caught.value.partial.y[:, 3:], axis=1)
    np.testing.assert_allclose(lengths, 1.0, atol=1e-13)


@gi.field
def overflowing(params, t, y, out, work):
    """Generator of SO(2) × R⁷: no turn, and a push that is still finite while h times it is not."""
    for i in range(8):
        out[i] = 0.0 * y[0]
    out[1] += 9e299


@pytest.mark.parametrize("method", ["cf-1", "cf-4", "cg-3", "rkmk-4"])
def test_a_move_that_overflows(method: str) -> None:
    """Every stage is finite, only their sum is not."""
    group = gi.so_n(2, "vector") * gi.translations(7)
    action, pieces = gi.GroupAction(overflowing, group), (("v", 2), ("r", 7))
    problem = gi.Problem("overflowing", pieces, action=action)
    with pytest.raises(TURNED_FAR) as caught:
        gi.solve(problem, [1.0, *[0.0] * 8], t_end=4e9, step=1e9, method=method, **PLAIN)
    assert caught.value.step == 0
    assert np.isfinite(caught.value.partial.y).all()


@gi.field
def spinning(params, t, y, out, work):
    out[0] = 1.0 + 0.0 * y[0]
    out[1] = 0.1 * y[1]
    out[2] = 0.1 * y[2]


SPINNING = gi.Problem("spinning", (("v", 6),), action=gi.GroupAction(spinning, gi.so3(2)))
ON_BOTH = gi.GroupAction(spinning, gi.so_n(3, "vector", "vector"))
SPINNING_N = gi.Problem("spinning-n", (("v", 6),), action=ON_BOTH)


@pytest.mark.parametrize("problem", [SPINNING, SPINNING_N], ids=["so3", "so_n"])
@pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")
def test_a_step_that_turns_too_far(problem: gi.Problem) -> None:
    """Near a full turn dexp is singular: a typed error with the step, not a number."""
    y0 = np.tile([0.6, 0.0, 0.8], 2)

    def check_lengths(h: float, method: str) -> None:
        run = gi.solve(problem, y0, t_end=h, step=h, method=method, **PLAIN)
        lengths = np.linalg.norm(run.y[-1].reshape(-1, 3), axis=1)
        np.testing.assert_allclose(lengths, 1.0, rtol=0, atol=1e-15)

    check_lengths(5.5, "rkmk-4")
    for h in (6.2, 2.0 * math.pi, 50.0):
        with pytest.raises(gi.StepSizeError, match="coordinates end") as caught:
            check_lengths(h, "rkmk-4")
        assert (caught.value.t, caught.value.step, caught.value.h) == (0.0, 0, h)
    if problem is SPINNING:
        check_lengths(50.0, "rkmk-cayley-4")
    else:  # elimination would lose digits
        with pytest.raises(gi.StepSizeError, match="h = 50 turns so far"):
            check_lengths(50.0, "rkmk-cayley-4")


def test_an_exponential_step_beyond_the_chart() -> None:
    """Series of dexp⁻¹ are none beyond the pole: exponents would grow until exp has no digits."""
    problem, y0 = so_n_flow.problem(4), so_n_flow.initial(4)
    for h, name in ((30.0, "rkmk-4"), (30.0, "rkmk-dop853"), (400.0, "rkmk-heun-2")):
        with pytest.raises(gi.StepSizeError, match="coordinates end"):
            gi.solve(problem, y0, t_end=h, step=h, method=name, **PLAIN)
    shorter = gi.Adaptive(gi.RKMK("bogacki-shampine-3"), rtol=1e-2, atol=1e-2)
    sol = gi.solve(problem, y0, t_end=30.0, step=30.0, method=shorter, **PLAIN)
    assert sol.status == "success"
    plane = so_n_flow.problem(2), so_n_flow.initial(2)  # whose series is exact
    assert np.isfinite(gi.solve(*plane, t_end=30.0, step=30.0, method="rkmk-4", **PLAIN).y).all()


HENON = henon_heiles.problem(), henon_heiles.INITIAL
PENDULUM = spherical_pendulum.problem(), spherical_pendulum.INITIAL


TOO_LARGE = {
    "one": (gi.Gauss(1, iteration="fixed-point"), HENON, 30.0),
    "eight": (gi.Gauss(8, iteration="fixed-point"), HENON, 30.0),
    "rattle": ("rattle-2", PENDULUM, 9.0),
}


@pytest.mark.parametrize("case", TOO_LARGE)
def test_a_step_too_large_to_converge(case: str) -> None:
    """A ConvergenceError with t, step, residual, iterations, and a hint; as many as are allowed."""
    (method, given, h), said = TOO_LARGE[case], r"did not converge at t = 0 .*too large"
    with pytest.raises(gi.ConvergenceError, match=said) as caught:
        gi.solve(*given, t_end=10 * h, step=h, method=method, **PLAIN)
    error = caught.value
    assert (error.t, error.step) == (0.0, 0)
    assert error.residual > 0.0
    assert 1 <= error.iterations <= 200 * 11
    np.testing.assert_array_equal(error.partial.y[-1], given[1])
    few = gi.find_method(method).with_options(max_iterations=2)
    with pytest.raises(gi.ConvergenceError) as caught:
        gi.solve(*given, t_end=1.0, step=0.5, method=few, **PLAIN)
    assert caught.value.iterations == 2


def test_numbers_of_a_failure_do_not_depend_on_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """t, step, residual and iterations are those of the failed step."""
    found = set()
    for first_chunk in (1, 5, 1000):
        monkeypatch.setattr(driver, "FIRST_CHUNK", first_chunk)
        for method in ("gauss-2", "rk-4", "dormand-prince-5-adaptive"):
            with pytest.raises(gi.StepError) as caught:
                gi.solve(EXPLOSION, [1.0, 0.0], t_end=2.0, step=0.1, method=method, save_every=2)
            e, p = caught.value, caught.value.partial
            numbers = (e.t, e.step, e.residual, e.iterations, p.steps, p.iterations, len(p.t))
            found.add((method, *numbers, tuple(p.y[-1])))
    assert len(found) == 3


@gi.field
def wall(params, t, q, p, dq, dp, work):
    """A pendulum whose gravity ends at t = 1.02."""
    for i in range(3):
        dq[i] = 0.0 * q[i]
        dp[i] = 1.0 * p[i]
    dq[2] = gi.sqrt(1.02 - t)


def test_a_failure_inside_a_composition() -> None:
    """The partial result ends with a whole step, not with the substeps that succeeded."""
    form = gi.Hamiltonian(wall, gi.Sphere(3).constraint, 1)
    problem = gi.Problem("wall", (("q", 3), ("p", 3)), hamiltonian=form)
    run = {"step": 0.1, "method": "rattle-4", **PLAIN}
    with pytest.raises(gi.NonFiniteError) as caught:
        gi.solve(problem, PENDULUM[1], t_end=2.0, **run)
    error = caught.value
    assert error.step in (9, 10)
    good = gi.solve(problem, PENDULUM[1], t_end=0.1 * error.step, **run)
    np.testing.assert_array_equal(error.partial.y[-1], good.y[-1])
    assert error.partial.t[-1] == pytest.approx(0.1 * error.step)


# --- options and forms ----------------------------------------------------------------------------

ONE = gi.Gauss(1)
NAMES = ("gauss-17", "rattle-suzuki-5", "rk-4-suzuki-4", 8, None, "")
SCHEMES = [(ONE, "suzuki-5"), (ONE, 5), (ONE, True), (gi.Gauss(2), "suzuki-4"), (gi.Rattle(), 7)]
BAD: list[tuple[Any, Any]] = [
    *((gi.Gauss, (stages,)) for stages in (0, 17, 2.5, True, "8")),
    *((gi.Lobatto, (stages,)) for stages in (2, 9)),
    *((gi.RungeKutta, (tableau,)) for tableau in ("rk-5", gauss_legendre(2).tableau)),
    *((gi.RKMK, (tableau,)) for tableau in ("gauss", gauss_legendre(1).tableau)),
    (gi.RKMK, ("rk-4", "cayly")),
    (gi.CommutatorFree, ("cf-9",)),
    *((gi.Compose, arguments) for arguments in SCHEMES),
    *((gi.find_method, (name,)) for name in NAMES),
]
OPTIONS = {"iteration_tolerance": (-1.0, 0.5, 1.0, math.nan), "max_iterations": (0, 2.5)}


def test_options_outside_their_domain() -> None:
    """A typed error with one line of text that names the option."""
    for make, arguments in BAD:
        with pytest.raises(gi.GeomintError, match=r"^.{15,}$"):
            make(*arguments)
    for method in (gi.Gauss(4), gi.Rattle(), gi.Lobatto(4)):
        for option, values in OPTIONS.items():
            for value in values:
                with pytest.raises(gi.DomainError, match=rf"{option} = {value}.*: [^\n]*$"):
                    method.with_options(**{option: value})


NO_CAYLEY = gi.GroupAction(spinning, dataclasses.replace(gi.so3(1), cayley=None))
NO_CHART = gi.Problem("plain", (("v", 3),), action=NO_CAYLEY)


@pytest.mark.parametrize(
    ("problem", "method", "advice"),
    [
        (lotka_volterra.problem(), "cf-4", "offers field.*gauss-8"),
        (lotka_volterra.problem(), "rattle-2", "needs the form 'hamiltonian'.*dop853"),
        (RUNAWAY, "gauss-8", "offers action.*cf-4"),
        (RUNAWAY, "rattle-4", "cf-4, rkmk-4"),
        (PENDULUM[0], "rkmk-4", "offers field, hamiltonian.*rattle-4"),
        (NO_CHART, "rkmk-cayley-4", "no Cayley map.*coordinates='exp'"),
    ],
)
def test_a_form_that_does_not_fit(problem: gi.Problem, method: str, advice: str) -> None:
    """The error says what the method needs, what the problem offers, and what would fit: it does."""
    with pytest.raises(gi.FormError, match=advice) as caught:
        gi.solve(problem, np.eye(problem.rows)[0], t_end=1.0, method=method)
    words = set(str(caught.value).replace(",", " ").split()) & set(gi.method_names())
    for name in words - {method}:
        assert gi.find_method(name).needs in problem.forms


WRONG: dict[str, list[Any]] = {
    "state": [[1.0], [1.0] * 5, [math.nan] * 4, [math.inf, 0, 0, 0], "abcd", None, [1j] * 4],
    "t_end": [math.nan, math.inf, "1", None],
    "step": [0.0, -0.1, math.nan, "small", 1e-300],
    "save_every": [0, 2.5, True],
    "observe_every": [0, -3],
    "observe": ["energie", ["energy", "momentum"], {"energy": 3}, 5],
    "t_eval": [[0.5, 0.2], [math.nan], "soon", [[0.1, 0.2]]],
}


@pytest.mark.parametrize("name", WRONG)
def test_arguments_of_solve(name: str) -> None:
    """Refused before anything is computed, by name and in one line."""
    for value in WRONG[name]:
        given = {"y0" if name == "state" else name: value}
        with pytest.raises(gi.GeomintError, match=rf"\A.*{name}.*\Z"):
            gi.solve(**{"problem": HENON[0], "y0": HENON[1], "t_end": 1.0, **given})


# --- fields ---------------------------------------------------------------------------------------


def pendulum(force: object) -> gi.Problem:
    return gi.Problem("pendulum", (("y", 2),), [1.5], field=gi.field(force))


def branching(params, t, y, out, work):
    out[0] = y[1]
    if y[0] > 0.3:
        out[1] = -params[0] * y[0]
    else:
        out[1] = -y[0]


@compiler
def test_a_field_with_branches_runs_on_scalars() -> None:
    """Gauss methods warn once, say why, and come to the bits of plain Python."""
    problem, run = pendulum(branching), {"t_end": 10.0, "step": 0.1, "method": "gauss-4"}
    said = r"'branching'.*gi.select.*test_errors.py:\d"
    with pytest.warns(gi.GeomintWarning, match=said) as caught:
        found = gi.solve(problem, [0.5, 0.1], **run)
    assert [warning.filename for warning in caught] == [__file__]
    for compiled in (True, False):
        again = gi.solve(problem, [0.5, 0.1], **run, compiled=compiled)
        np.testing.assert_array_equal(again.y, found.y)
        assert again.iterations == found.iterations


def undefined_name(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -gravity * y[0]  # noqa: F821


def wrong_signature(t, y):
    return -y


NO_NAME = r"raises NameError: name 'gravity' is not defined \(undefined_name, .*:\d+"
OTHER = r"takes \(t, y\), where \(params, t, y, out, work\) is wanted"


@pytest.mark.parametrize(("field", "says"), [(undefined_name, NO_NAME), (wrong_signature, OTHER)])
@pytest.mark.parametrize("options", [{"step": 0.1, "method": "rk-4"}, {}])
def test_a_field_with_a_mistake(field: object, says: str, options: dict) -> None:
    """Is tried in Python first: what is wrong, at the user's line, without the compiler's words."""
    with pytest.raises(gi.DeclarationError, match=rf"\Afield of problem 'pendulum' {says}.*\Z"):
        gi.solve(pendulum(field), [0.5, 0.1], t_end=1.0, **options)


def unknown_to_the_compiler(params, t, y, out, work):
    out[0], out[1] = y[1], -float(np.float64(y[0]).hex()[:1] == "0")


@compiler
def test_a_field_that_does_not_compile() -> None:
    """One line that names the place; the cause is the compiler's own error, alone."""
    said = r"\A.*unknown_to_the_compiler.* cannot be compiled: .*\.py:\d+\)[^\n]*\Z"
    with pytest.raises(gi.DeclarationError, match=said) as caught:
        gi.solve(pendulum(unknown_to_the_compiler), [0.5, 0.1], t_end=1.0, step=0.1, method="rk-4")
    cause = caught.value.__cause__
    assert isinstance(cause, NumbaError)
    assert cause.__cause__ is None
    assert cause.__context__ is None or cause.__suppress_context__
