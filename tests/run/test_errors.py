"""Failures: typed, with their numbers, at the right step, and never a silent last iterate."""

from __future__ import annotations

import dataclasses
import math
import warnings
from typing import Any

import numpy as np
import pytest
from numba.core import config
from numba.core.errors import NumbaError

import geomint as gi
from geomint.methods import methods
from geomint.problems.testproblems import henon_heiles, pulsating_body, sphere_metric
from geomint.tableaux import gauss_legendre
from tests.problems import double_pendulum, lotka_volterra, so_n_flow, spherical_pendulum

pytestmark = pytest.mark.nojit
compiler = pytest.mark.skipif(config.DISABLE_JIT, reason="nothing is compiled")


@gi.field
def explosion(params, t, y, out, work):
    out[0] = y[0] * y[0]
    out[1] = 1.0 + 0.0 * y[0]


EXPLOSION = gi.Problem("explosion", (("y", 1), ("z", 1)), field=explosion)


@gi.field
def late_nan(params, t, y, out, work):
    out[0] = 1.0 + 0.0 * y[0]
    out[1] = gi.sqrt(1.0 - y[0])


LATE_NAN = gi.Problem("late-nan", (("y", 1), ("z", 1)), field=late_nan)


@gi.field
def runaway(params, t, y, out, work):
    out[0] = 1.0 / (1.0 - t)
    out[1] = y[3] * y[3] / (1.05 - t)
    out[2] = gi.sqrt(1.02 - t)


RUNAWAY = gi.Problem("runaway", (("v", 6),), action=gi.GroupAction(runaway, gi.so3(2)))


@pytest.mark.parametrize(
    "method",
    ["rk-4", "dop853", "gauss-2", "gauss-8", pytest.param("gauss-12", marks=pytest.mark.nightly)],
)
@pytest.mark.parametrize("compiled", [True, False])
def test_a_solution_that_explodes(method: str, compiled: bool) -> None:
    """At t = 1; what was computed before is finite and kept."""
    with pytest.raises(gi.StepError) as caught:
        gi.solve(
            EXPLOSION,
            [1.0, 0.0],
            t_end=2.0,
            step=0.1,
            method=method,
            save_every=1,
            compiled=compiled,
        )
    error = caught.value
    assert isinstance(error, gi.ConvergenceError | gi.NonFiniteError)
    assert 0.5 <= error.t < 1.5
    assert error.step == round(error.t / 0.1)
    assert error.iterations >= 1
    partial = error.partial
    assert partial.status == "failed"
    assert not partial.success
    assert partial.message == str(error)
    assert partial.steps == error.step
    assert partial.t[-1] == pytest.approx(error.t)
    assert len(partial.y) == error.step + 1
    assert np.isfinite(partial.y).all()
    np.testing.assert_allclose(partial.y[: error.step - 1, 1], partial.t[: error.step - 1])


@pytest.mark.parametrize("method", ["rk-4", "gauss-2", "gauss-8", "gauss-11", "gauss-1-suzuki-4"])
def test_a_nan_in_one_row_is_not_a_result(method: str) -> None:
    """Though the other rows are fine: never NaN with success."""
    with pytest.raises(gi.NonFiniteError) as caught:
        gi.solve(LATE_NAN, [0.0, 0.0], t_end=2.0, step=0.1, method=method, save_every=1)
    assert 0.7 < caught.value.t <= 1.0
    assert np.isfinite(caught.value.partial.y).all()
    with pytest.raises(gi.NonFiniteError) as caught:
        gi.solve(LATE_NAN, [2.0, 0.0], t_end=2.0, step=0.1, method=method)
    assert (caught.value.t, caught.value.step) == (0.0, 0)


@pytest.mark.parametrize("method", ["cf-4", "cf-3", "rkmk-4", "rkmk-dop853", "rkmk-cayley-4"])
def test_a_generator_that_fails(method: str) -> None:
    """At the pole, or where the square root ends, or where a step turns too far."""
    y0 = [1.0, 0.0, 0.0, 0.0, 0.6, 0.8]
    with pytest.raises((gi.NonFiniteError, gi.StepSizeError)) as caught:
        gi.solve(RUNAWAY, y0, t_end=2.0, step=0.05, method=method, save_every=1)
    assert 0.9 <= caught.value.t <= 1.05
    partial = caught.value.partial
    np.testing.assert_allclose(np.linalg.norm(partial.y[:, 3:], axis=1), 1.0, atol=1e-13)


@gi.field
def overflowing(params, t, y, out, work):
    """Generator of SO(2) × R⁷: no turn, and a push that is still finite while h times it is not."""
    for i in range(8):
        out[i] = 0.0 * y[0]
    out[1] += 9e299


OVERFLOWING = gi.Problem(
    "overflowing",
    (("v", 2), ("r", 7)),  # more than 8 rows: the stepper of all groups SO(n)
    action=gi.GroupAction(overflowing, gi.so_n(2, "vector") * gi.translations(7)),
)


@pytest.mark.parametrize("method", ["cf-1", "cf-2", "cf-3", "cf-4", "cg-3", "rkmk-4"])
def test_a_move_that_overflows(method: str) -> None:
    """Every stage is finite, only their sum is not."""
    with pytest.raises((gi.NonFiniteError, gi.StepSizeError)) as caught:
        gi.solve(OVERFLOWING, [1.0, *[0.0] * 8], t_end=4e9, step=1e9, method=method, save_every=1)
    assert caught.value.step == 0
    assert np.isfinite(caught.value.partial.y).all()


@gi.field
def spinning(params, t, y, out, work):
    out[0] = 1.0 + 0.0 * y[0]
    out[1] = 0.1 * y[1]
    out[2] = 0.1 * y[2]


# As many rows as other problems here, whose steppers they share.
SPINNING = gi.Problem("spinning", (("v", 6),), action=gi.GroupAction(spinning, gi.so3(2)))
SPINNING_4 = gi.Problem(
    "spinning-4", (("v", 9),), action=gi.GroupAction(spinning, gi.so_n(3, *["vector"] * 3))
)


@pytest.mark.parametrize("problem", [SPINNING, SPINNING_4], ids=["so3", "so_n"])
def test_a_step_that_turns_too_far(problem: gi.Problem) -> None:
    """Near a full turn dexp is singular: a typed error with the step, not a number."""
    y0 = np.tile([0.6, 0.0, 0.8], problem.rows // 3)
    for h, fine in ((5.5, True), (6.2, False), (2 * math.pi, False), (50.0, False)):
        if fine:
            sol = gi.solve(problem, y0, t_end=h, step=h, method="rkmk-4")
            lengths = np.linalg.norm(sol.y[-1].reshape(-1, 3), axis=1)
            np.testing.assert_allclose(lengths, 1.0, rtol=0, atol=1e-15)
            continue
        with pytest.raises(gi.StepSizeError, match="coordinates end") as caught:
            gi.solve(problem, y0, t_end=h, step=h, method="rkmk-4")
        assert (caught.value.t, caught.value.step, caught.value.h) == (0.0, 0, h)


@pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")
def test_a_cayley_step_that_turns_too_far() -> None:
    """SO(n) refuses coordinates in which its elimination would lose digits."""
    kwargs = {"t_end": 50.0, "step": 50.0, "method": "rkmk-cayley-4"}
    with pytest.raises(gi.StepSizeError, match="h = 50 turns so far"):
        gi.solve(SPINNING_4, [0.6, 0.0, 0.8] * 3, **kwargs)
    sol = gi.solve(SPINNING, [0.6, 0.0, 0.8] * 2, **kwargs)
    assert abs(np.linalg.norm(sol.y[-1][:3]) - 1.0) < 1e-15


def test_an_exponential_step_beyond_the_chart() -> None:
    """Series of dexp⁻¹ are none beyond the pole: exponents would grow until exp has no digits."""
    problem, y0 = so_n_flow.problem(4), so_n_flow.initial(4)
    once: dict[str, Any] = {"compiled": False, "progress": False}  # single steps, of many kernels
    for h, name in ((30.0, "rkmk-4"), (30.0, "rkmk-dop853"), (400.0, "rkmk-heun-2")):
        with pytest.raises(gi.StepSizeError, match="coordinates end"):
            gi.solve(problem, y0, t_end=h, step=h, method=name, **once)
    sol = gi.solve(problem, y0, t_end=30.0, method="rkmk-dop853-adaptive")
    assert sol.status == "success"
    plane = so_n_flow.problem(2)  # whose series is exact
    sol = gi.solve(plane, so_n_flow.initial(2), t_end=30.0, step=30.0, method="rkmk-4", **once)
    assert np.isfinite(sol.y).all()
    free = dataclasses.replace(problem.action.group, extent=None)
    action = gi.GroupAction(problem.action.generator, free)
    without = dataclasses.replace(problem, action=action)
    sol = gi.solve(without, y0, t_end=2.0, step=2.0, method="rkmk-4", **once)
    assert np.isfinite(sol.y).all()


def test_a_group_without_a_cayley_map() -> None:
    """Is refused with advice."""
    group = dataclasses.replace(gi.so3(1), cayley=None)
    problem = gi.Problem("plain", (("v", 3),), action=gi.GroupAction(spinning, group))
    with pytest.raises(gi.FormError, match=r"no Cayley map.*coordinates='exp'"):
        gi.solve(problem, [0.6, 0.0, 0.8], t_end=1.0, method="rkmk-cayley-4")
    with pytest.raises(gi.DomainError, match="coordinates = 'cayly'"):
        gi.RKMK(coordinates="cayly")


FIXED_POINT = [gi.Gauss(stages, iteration="fixed-point") for stages in (1, 8)]


@pytest.mark.parametrize(
    ("method", "problem", "y0", "h"),
    [
        (FIXED_POINT[0], henon_heiles.problem(), henon_heiles.INITIAL, 30.0),
        (FIXED_POINT[1], henon_heiles.problem(), henon_heiles.INITIAL, 30.0),
        ("rattle-2", spherical_pendulum.problem(), spherical_pendulum.INITIAL, 9.0),
        ("rattle-6", double_pendulum.problem(), double_pendulum.INITIAL, 20.0),
    ],
)
def test_a_step_too_large_to_converge(
    method: str | gi.Method, problem: gi.Problem, y0: np.ndarray, h: float
) -> None:
    """A ConvergenceError with t, step, residual, iterations, and a hint."""
    with pytest.raises(
        gi.ConvergenceError, match=r"did not converge at t = 0 .*too large"
    ) as caught:
        gi.solve(problem, y0, t_end=10 * h, step=h, method=method)
    error = caught.value
    assert (error.t, error.step) == (0.0, 0)
    assert error.residual > 0.0
    assert 1 <= error.iterations <= 200 * 11
    np.testing.assert_array_equal(error.partial.y[-1], y0)


def test_the_cap_on_iterations() -> None:
    """Reached: an error with just so many iterations."""
    problem = lotka_volterra.problem()
    method = gi.Gauss(4, max_iterations=3, iteration="fixed-point")
    with pytest.raises(gi.ConvergenceError) as caught:
        gi.solve(problem, lotka_volterra.INITIAL, t_end=1.0, step=0.5, method=method)
    assert caught.value.iterations == 3
    metric = sphere_metric.problem()
    with pytest.raises(gi.ConvergenceError) as caught:
        gi.solve(
            metric,
            sphere_metric.initial(metric),
            t_end=1.0,
            step=0.2,
            method=gi.Rattle(max_iterations=2),
        )
    assert caught.value.iterations == 2


def test_numbers_of_a_failure_do_not_depend_on_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """t, step, residual and iterations are those of the failed step."""
    from geomint.run import driver

    found = []
    for first_chunk in (1, 5, 1000):
        monkeypatch.setattr(driver, "FIRST_CHUNK", first_chunk)
        for method in ("gauss-2", "rk-4"):
            with pytest.raises(gi.StepError) as caught:
                gi.solve(EXPLOSION, [1.0, 0.0], t_end=2.0, step=0.1, method=method, save_every=2)
            e = caught.value
            p = e.partial
            numbers = (e.t, e.step, e.residual, e.iterations, p.steps, p.iterations, len(p.t))
            found.append((method, *numbers, tuple(p.y[-1])))
    assert len(set(found)) == 2


@gi.field
def wall(params, t, q, p, dq, dp, work):
    """A pendulum whose gravity ends at t = 1.02."""
    for i in range(3):
        dq[i] = 0.0 * q[i]
        dp[i] = 1.0 * p[i]
    dq[2] = gi.sqrt(1.02 - t)


def test_a_failure_inside_a_composition(monkeypatch: pytest.MonkeyPatch) -> None:
    """The partial result ends with a whole step, not with the substeps that succeeded."""
    from tests.problems.spherical_pendulum import INITIAL

    problem = gi.Problem(
        "wall", (("q", 3), ("p", 3)), hamiltonian=gi.Hamiltonian(wall, gi.Sphere(3).constraint, 1)
    )
    kwargs = {"step": 0.1, "method": "rattle-4"}
    with pytest.raises(gi.NonFiniteError) as caught:
        gi.solve(problem, INITIAL, t_end=2.0, **kwargs)
    error = caught.value
    assert error.step in (9, 10)
    good = gi.solve(problem, INITIAL, t_end=0.1 * error.step, **kwargs)
    np.testing.assert_array_equal(error.partial.y[-1], good.y[-1])
    assert error.partial.t[-1] == pytest.approx(0.1 * error.step)


def test_failures_beside_the_run() -> None:
    """In a partial step at the end, or at a time that was asked for."""
    with pytest.raises(gi.StepError) as caught:
        gi.solve(LATE_NAN, [0.0, 0.0], t_end=1.05, step=0.1, method="rk-4")
    assert caught.value.step == 10
    assert caught.value.t == pytest.approx(1.0)
    with pytest.raises(gi.StepError) as caught:
        gi.solve(LATE_NAN, [0.0, 0.0], t_end=2.0, step=0.1, method="rk-4", t_eval=[1.5])
    assert len(caught.value.partial.t) == 0
    assert caught.value.partial.y.shape == (0, 2)


# --- options and forms ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "make",
    [
        lambda: gi.Gauss(0),
        lambda: gi.Gauss(17),
        lambda: gi.Gauss(2.5),
        lambda: gi.Gauss(True),
        lambda: gi.Gauss("8"),
        lambda: gi.Gauss(4, iteration_tolerance=-1.0),
        lambda: gi.Gauss(4, iteration_tolerance=0.5),
        lambda: gi.Gauss(4, iteration_tolerance=math.nan),
        lambda: gi.Gauss(4, max_iterations=0),
        lambda: gi.Rattle(iteration_tolerance=1.0),
        lambda: gi.Rattle(max_iterations=0),
        lambda: gi.Lobatto(2),
        lambda: gi.Lobatto(9),
        lambda: gi.Lobatto(4, iteration_tolerance=1.0),
        lambda: gi.RungeKutta("rk-5"),
        lambda: gi.RKMK("gauss"),
        lambda: gi.RungeKutta(gauss_legendre(2).tableau),
        lambda: gi.RKMK(gauss_legendre(1).tableau),
        lambda: gi.CommutatorFree("cf-9"),
        lambda: gi.Compose(gi.Gauss(1), "suzuki-5"),
        lambda: gi.Compose(gi.Gauss(1), 5),
        lambda: gi.Compose(gi.Gauss(2), "suzuki-4"),
        lambda: gi.Compose(gi.Gauss(1), "suzuki-6"),
        lambda: gi.Compose(gi.Gauss(1), True),
        lambda: gi.Compose(gi.RungeKutta("rk-4"), 4),
        lambda: gi.Compose(gi.Rattle().with_options(iteration_tolerance=0.0), 7),
        lambda: gi.Rattle().with_options(tolerence=0.0),
        lambda: gi.Rattle().with_options(max_iterations=2.5),
        lambda: gi.find_method("gauss-17"),
        lambda: gi.find_method("rk4"),
        lambda: gi.find_method("rattle-suzuki-5"),
        lambda: gi.find_method("rk-4-suzuki-4"),
        lambda: gi.find_method(8),
        lambda: gi.find_method(None),
        lambda: gi.find_method(""),
    ],
)
def test_options_outside_their_domain(make: object) -> None:
    """A typed error with one line of text."""
    with pytest.raises(gi.GeomintError) as caught:
        make()
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) > 15


def test_a_method_that_was_probably_meant() -> None:
    """Is named."""
    with pytest.raises(gi.MethodError, match="Did you mean 'gauss-8'"):
        gi.find_method("gaus-8")
    with pytest.raises(gi.MethodError, match="Did you mean 'rk-4'"):
        gi.RungeKutta("rk4")


@pytest.mark.parametrize(
    ("problem", "method", "advice"),
    [
        (lotka_volterra.problem(), "cf-4", "offers field.*gauss-8"),
        (lotka_volterra.problem(), "rattle-2", "needs the form 'hamiltonian'.*dop853"),
        (RUNAWAY, "gauss-8", "offers action.*cf-4"),
        (RUNAWAY, "rattle-4", "cf-4, rkmk-4"),
        (spherical_pendulum.problem(), "rkmk-4", "offers field, hamiltonian.*rattle-4"),
    ],
)
def test_a_form_that_does_not_fit(problem: gi.Problem, method: str, advice: str) -> None:
    """The error says what the method needs, what the problem offers, and what would fit."""
    with pytest.raises(gi.FormError, match=advice):
        gi.solve(problem, np.eye(problem.rows)[0], t_end=1.0, method=method)


def test_what_is_advised_fits() -> None:
    """The methods named in the advice exist and need that form."""
    from geomint.methods.method import FITTING

    for form, names in FITTING.items():
        for name in names.split(", "):
            assert methods()[name].needs == form


@pytest.mark.parametrize(
    "options",
    [
        {"t_end": math.nan},
        {"t_end": math.inf},
        {"t_end": "1"},
        {"t_end": 1.0, "tau_end": 1.0},
        {},
        {"tau_end": 1.0},
        {"t_end": 1.0, "step": 0.0},
        {"t_end": 1.0, "step": -0.1},
        {"t_end": 1.0, "step": math.nan},
        {"t_end": 1.0, "step": "small"},
        {"t_end": 1.0, "step": 1e-300},
        {"t_end": 1.0, "save_every": 0},
        {"t_end": 1.0, "save_every": 2.5},
        {"t_end": 1.0, "save_every": True},
        {"t_end": 1.0, "observe_every": 0},
        {"t_end": 1.0, "observe_every": -3},
        {"t_end": 1.0, "observe": "energie"},
        {"t_end": 1.0, "observe": ["energy", "momentum"]},
        {"t_end": 1.0, "observe": {"energy": 3}},
        {"t_end": 1.0, "observe": 5},
        {"t_end": 1.0, "t_eval": [0.5, 1.5]},
        {"t_end": 1.0, "t_eval": [-0.5]},
        {"t_end": 1.0, "t_eval": [0.5, 0.2]},
        {"t_end": 1.0, "t_eval": [math.nan]},
        {"t_end": 1.0, "t_eval": "soon"},
        {"t_end": 1.0, "t_eval": [[0.1, 0.2]]},
        {"t_end": -1.0, "t_eval": [0.5]},
        {"t_end": 1.0, "method": 4},
        {"t_end": 1.0, "clock": True},
    ],
    ids=repr,
)
def test_arguments_of_solve(options: dict) -> None:
    """Refused before anything is computed."""
    with pytest.raises(gi.GeomintError) as caught:
        gi.solve(henon_heiles.problem(), henon_heiles.INITIAL, **options)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "y0", [[1.0], [1.0] * 5, [math.nan] * 4, [math.inf, 0, 0, 0], "abcd", None, [1j] * 4]
)
def test_initial_states(y0: object) -> None:
    """Of wrong length, kind or not finite."""
    with pytest.raises(gi.DomainError, match="state"):
        gi.solve(henon_heiles.problem(), y0, t_end=1.0)


def test_problems_are_checked() -> None:
    """Without a form, with bad pieces, times or parameters."""
    for wrong in (
        {"field": None},
        {"pieces": ()},
        {"pieces": (("y", 0),)},
        {"params": [math.nan]},
        {"time": "s"},
    ):
        options = {"name": "p", "pieces": (("y", 1),), "field": explosion, **wrong}
        with pytest.raises(gi.GeomintError):
            gi.Problem(**options)


# --- fields ---------------------------------------------------------------------------------------


def pendulum(force: object) -> gi.Problem:
    return gi.Problem("pendulum", (("y", 2),), [1.5], field=gi.field(force))


def branching(params, t, y, out, work):
    out[0] = y[1]
    if y[0] > 0.3:
        out[1] = -params[0] * y[0]
    else:
        out[1] = -y[0]


def selecting(params, t, y, out, work):
    out[0] = y[1]
    out[1] = gi.select(y[0] > 0.3, -params[0] * y[0], -y[0])


def scalar_function(params, t, y, out, work):
    work[0] = math.atan(y[0] / (1.0 + t * t))
    out[0] = y[1]
    out[1] = -params[0] * work[0]


@compiler
def test_a_field_with_branches_runs_on_scalars() -> None:
    """Gauss methods warn once, say why, and come to the bits of the field written for lanes."""
    problem = pendulum(branching)
    with pytest.warns(
        gi.GeomintWarning, match=r"'branching'.*gi.select.*test_errors.py:\d"
    ) as caught:
        found = gi.solve(problem, [0.5, 0.1], t_end=10.0, step=0.1, method="gauss-4")
    assert len(caught) == 1
    assert caught[0].filename == __file__
    again = gi.solve(problem, [0.5, 0.1], t_end=10.0, step=0.1, method="gauss-4")
    lanes = gi.solve(pendulum(selecting), [0.5, 0.1], t_end=10.0, step=0.1, method="gauss-4")
    np.testing.assert_array_equal(found.y, lanes.y)
    np.testing.assert_array_equal(again.y, lanes.y)
    assert found.iterations == lanes.iterations
    explicit = gi.solve(problem, [0.5, 0.1], t_end=10.0, step=0.1, method="rk-4")
    assert np.isfinite(explicit.y).all()


@compiler
def test_a_field_with_scalar_functions_runs_in_plain_python() -> None:
    """With scratch and two groups of lanes, to the same bits."""
    import dataclasses

    problem = dataclasses.replace(pendulum(scalar_function), work=1)
    for method in ("gauss-4", "gauss-11"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", gi.GeomintWarning)
            found = gi.solve(problem, [0.5, 0.1], t_end=1.0, step=0.1, method=method)
        plain = gi.solve(problem, [0.5, 0.1], t_end=1.0, step=0.1, method=method, compiled=False)
        np.testing.assert_array_equal(plain.y, found.y)


def undefined_name(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -gravity * y[0]  # noqa: F821


def wrong_signature(t, y):
    return -y


def slices(params, t, y, out, work):
    out[:] = y[:]


def last_row(params, t, y, out, work):
    out[0] = y[-1]
    out[1] = -y[0]


@pytest.mark.parametrize(
    ("field", "says"),
    [
        (
            undefined_name,
            r"raises NameError: name 'gravity' is not defined \(undefined_name, .*:\d+",
        ),
        (wrong_signature, r"takes \(t, y\), where \(params, t, y, out, work\) is wanted"),
        (slices, r"reads a slice of y: .*gi\.part\(y, start, rows\) \(slices, .*:\d+"),
        (last_row, r"reads row -1 of y, which has 2 rows, counted from 0 \(last_row, .*:\d+"),
    ],
)
@pytest.mark.parametrize("options", [{"step": 0.1, "method": "rk-4"}, {}])
def test_a_field_with_a_mistake(field: object, says: str, options: dict) -> None:
    """Is tried in Python first: what is wrong, at the user's line, without the compiler's words."""
    with pytest.raises(gi.DeclarationError, match=f"field of problem 'pendulum' {says}") as caught:
        gi.solve(pendulum(field), [0.5, 0.1], t_end=1.0, **options)
    assert "\n" not in str(caught.value)


def unknown_to_the_compiler(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -float(np.float64(y[0]).hex()[:1] == "0")


@pytest.mark.parametrize("method", ["rk-4", "gauss-2"])
@compiler
def test_a_field_that_does_not_compile(method: str) -> None:
    """One line that names the place; the cause is the compiler's own error, alone."""
    with pytest.raises(gi.DeclarationError, match=r"cannot be compiled: .*\.py:\d+\)") as caught:
        gi.solve(pendulum(unknown_to_the_compiler), [0.5, 0.1], t_end=1.0, step=0.1, method=method)
    assert "unknown_to_the_compiler" in str(caught.value)
    assert "\n" not in str(caught.value)
    cause = caught.value.__cause__
    assert isinstance(cause, NumbaError)
    assert cause.__cause__ is None
    assert cause.__context__ is None or cause.__suppress_context__


def test_plain_python_is_as_quiet_as_compiled_code() -> None:
    """Divisions by zero and overflows are no warnings, and end as the same error."""
    for compiled in (True, False):
        with pytest.raises(gi.StepError):
            gi.solve(EXPLOSION, [1e200, 0.0], t_end=1.0, step=0.1, method="rk-4", compiled=compiled)


def test_the_body_is_fine() -> None:
    """The problems of this file fail on purpose only."""
    sol = gi.solve(
        pulsating_body.problem(), pulsating_body.INITIAL, t_end=1.0, step=0.05, method="cf-4"
    )
    assert sol.success
    assert sol.message == ""
