"""A fibre over a base: what steps by the action make of the measure is what they make of the base's."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.problems.base import off_base
from geomint.testing import check_problem

BODY = ch.ChaplyginSphere.from_moments((1.0, 2.0, 3.0), 1.0, 1.0)
BALL = ch.ChaplyginSphere(a=[0.7, 0.9, 1.2, 1.5], D=4.0)
ROLLING = ch.ChaplyginSphere(a=[0.7, 0.9, 1.2], D=4.0)
PROBLEMS = {
    "attitude, R³": BODY.classical(attitude=True),
    "attitude, R⁴": BALL.ball(attitude=True),
    "attitude and contact point": ROLLING.contact(m=1.0, rho=2.0),
}
BY_GROUP = (
    "cf-4",
    "cg-3",
    "rkmk-4",
    "rkmk-cayley-4",
    "rkmk-dormand-prince-5-adaptive",
    "gauss-1",
    "gauss-3",
    "gauss-1-suzuki-4",
)
FAST = [("cf-4", "attitude, R³"), ("rkmk-4", "attitude, R³"), ("gauss-3", "attitude, R³")]


def whole(problem: gi.Problem) -> gi.Problem:
    """The same problem, whose measure knows no base."""
    return dataclasses.replace(problem, measure=dataclasses.replace(problem.measure, base=None))


def drift(problem: gi.Problem, y0: Any, method: str, **options: Any) -> gi.Drift:
    step = {} if "adaptive" in method else {"step": 0.1}
    run = gi.solve(problem, y0, t_end=6.0, method=method, observe=["measure"], **step, **options)
    return run.drift["measure"]


@pytest.mark.parametrize(
    ("method", "name"),
    [
        pytest.param(m, n, marks=[] if (m, n) in FAST else [pytest.mark.nightly])
        for m in BY_GROUP
        for n in PROBLEMS
        if m == "cf-4" or n == "attitude, R³"
    ],
)
def test_the_base_alone_says_as_much(method: str, name: str) -> None:
    problem = PROBLEMS[name]
    y0 = problem.random_state(3)
    by_base, by_all = drift(problem, y0, method), drift(whole(problem), y0, method)
    noise = 32.0 * 2.0**-52 * by_all.scale
    assert by_base.scale < by_all.scale  # fewer rows make less noise
    assert abs(by_base.final_error) > noise
    np.testing.assert_allclose(by_base.windows.maxima, by_all.windows.maxima, atol=noise, rtol=0.0)


@pytest.mark.parametrize(
    "name", ["attitude, R³", pytest.param("attitude, R⁴", marks=pytest.mark.nightly)]
)
def test_methods_of_fields_are_judged_by_the_whole_state(name: str) -> None:
    """They do not keep the measure of the fibre."""
    problem = PROBLEMS[name]
    y0 = problem.random_state(3)
    assert drift(problem, y0, "rk-4") == drift(whole(problem), y0, "rk-4")
    base = problem.measure.base
    alone = drift(base, y0[: base.rows], "rk-4")
    assert abs(alone.final_error - drift(problem, y0, "rk-4").final_error) > 1e-9


def test_steps_that_are_not_all_watched_and_a_last_partial_step() -> None:
    problem = PROBLEMS["attitude, R³"]
    y0 = problem.random_state(4)
    first = gi.watch.measure.InvariantMeasure(steps=7)
    for observe in (["measure"], {"it": first}):
        by_base, by_all = (
            gi.solve(p, y0, t_end=1.23, step=0.1, method="cf-4", observe=observe)
            for p in (problem, whole(problem))
        )
        (one,), (other,) = by_base.drift.values(), by_all.drift.values()
        assert abs(one.final_error - other.final_error) < 1e-13 < abs(one.final_error)


@pytest.mark.parametrize(
    "k", [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1e-200, 0.0, 0.0], [1e3, 1.0, 2.0]]
)
def test_from_rest_steady_tiny_and_fast(k: list[float]) -> None:
    problem = PROBLEMS["attitude, R³"]
    y0 = problem.state(gamma=[0.0, 1.0, 0.0], k=k)
    found = gi.solve(problem, y0, t_end=0.01, step=0.001, method="cf-4", observe=["measure"])
    assert np.isfinite(found.drift["measure"].final_error)
    assert found.drift["measure"].within_roundoff or k[0] == 1e3


def test_plain_python_has_the_bits() -> None:
    problem = PROBLEMS["attitude, R³"]
    y0 = problem.random_state(1)
    assert drift(problem, y0, "cf-4") == drift(problem, y0, "cf-4", compiled=False)


def test_a_problem_that_runs_in_another_time_has_no_base() -> None:
    problem = PROBLEMS["attitude, R³"]
    uneven = gi.time_transformed(problem, "speed", problem.random_state(0))
    assert uneven.measure.base is None


# --- what is no base ------------------------------------------------------------------------------


@gi.field
def turning(params, t, y, out, work):
    """ξ = (1, 2, 3) |x|² + params[0] z_1, of x the first three rows and z the others."""
    size = y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + params[0] * y[3]
    out[0], out[1], out[2] = size, 2.0 * size, 3.0 * size


def turned(coupled: float = 0.0, both: bool = True, **given: Any) -> gi.Problem:
    group = gi.so3(2 if both else 1)
    pieces = (("x", 3), ("z", 3)) if both else (("x", 3),)
    given = {"measure": gi.Measure(), "action": gi.GroupAction(turning, group), **given}
    return gi.Problem("turned", pieces, [coupled], **given)


@gi.field
def turning_alone(params, t, y, out, work):
    size = y[0] * y[0] + y[1] * y[1] + y[2] * y[2]
    out[0], out[1], out[2] = size, 2.0 * size, 3.0 * size


ALONE = turned(both=False, action=gi.GroupAction(turning_alone, gi.so3(1)))


def over(base: Any, coupled: float = 0.0) -> gi.Problem:
    return turned(coupled, measure=gi.Measure(base=base))


def test_a_fibre_of_ones_own() -> None:
    problem = over(ALONE)
    y0 = np.array([1.0, 0.2, 0.3, 0.0, 1.0, 2.0])
    found = gi.solve(problem, y0, t_end=1.0, step=0.1, method="cf-4", observe=["measure"])
    assert found.drift["measure"].within_roundoff


def by_all_and_by_base(problem: gi.Problem, y0: Any, method: str = "cf-4") -> list[gi.Drift]:
    return [drift(p, y0, method) for p in (whole(problem), problem)]


@pytest.mark.parametrize(
    ("y0", "coupled", "words"),
    [
        ([1.0, 0.2, 0.3, 1.0, 1.0, 2.0], 1.0, "do not move as the base does"),
        ([1.0, 0.2, 0.3, 0.0, 1.0, 2.0], 1.0, "do not move by themselves"),
    ],
)
def test_what_depends_on_the_fibre_has_no_base(y0: list[float], coupled: float, words: str) -> None:
    problem = over(ALONE, coupled)
    assert words in off_base(problem, ALONE, np.array(y0), 0.0)
    by_all, by_base = by_all_and_by_base(problem, y0)
    assert by_all == by_base
    with pytest.raises(AssertionError, match=words):
        check_problem(problem, [np.array(y0)])


@gi.field
def bent(params, t, y, out, work):
    """Both turned about (1, 2, 3) |x|², z at a speed that grows with itself."""
    size = y[0] * y[0] + y[1] * y[1] + y[2] * y[2]
    for i in range(0, len(y), 3):
        by = size if i == 0 else size * (y[3] * y[3] + y[4] * y[4] + y[5] * y[5])
        out[i] = by * (2.0 * y[i + 2] - 3.0 * y[i + 1])
        out[i + 1] = by * (3.0 * y[i] - y[i + 2])
        out[i + 2] = by * (y[i + 1] - 2.0 * y[i])


def test_rates_that_are_not_affine_in_the_fibre_have_no_base() -> None:
    """They may agree with the action where the fibre is, |z| = 1, and Gauss methods differ."""
    base = dataclasses.replace(ALONE, field=bent)
    problem = dataclasses.replace(over(base), field=bent)
    y0 = np.array([1.0, 0.2, 0.3, 0.0, 0.6, 0.8])
    assert "rates of the fibre are not affine" in off_base(problem, base, y0, 0.0)


def test_iterations_that_stop_early_are_judged_by_the_whole_state() -> None:
    problem = PROBLEMS["attitude, R³"]
    y0, early = problem.random_state(3), gi.Gauss(2, iteration_tolerance=1e-4)
    by_base, by_all = (
        gi.solve(p, y0, t_end=6.0, step=0.1, method=early, observe=["measure"]).drift["measure"]
        for p in (problem, whole(problem))
    )
    assert by_base == by_all


@gi.field
def too_far(params, t, y, out, work):
    out[0] = out[1] = out[2] = y[0]
    out[100_000_000] = 1.0


@gi.field
def reading_too_far(params, t, y, out, work):
    out[0] = out[1] = out[2] = y[3]


@pytest.mark.parametrize("generator", [too_far, reading_too_far])
def test_a_base_whose_functions_do_not_fit_is_refused(generator: Any) -> None:
    """Compiled, it would write and read other memory; though its field is right."""
    action = gi.GroupAction(generator, gi.so3(1))
    problem = over(turned(both=False, field=bent, action=action))
    with pytest.raises(gi.DeclarationError, match=r"action\.generator"):
        drift(problem, np.array([1.0, 0.2, 0.3, 0.0, 0.6, 0.8]), "cf-4")


def test_a_base_whose_manifold_does_not_fit_is_refused() -> None:
    base = dataclasses.replace(ALONE, measure=gi.Measure(manifold=too_far, conditions=1))
    with pytest.raises(gi.DeclarationError, match=r"measure\.manifold"):
        drift(over(base), np.array([1.0, 0.2, 0.3, 0.0, 0.6, 0.8]), "cf-4")


@gi.observable
def of_the_fibre(params, t, y, work):
    return y[len(y) - 1]


@gi.field
def coupled_later(params, t, y, out, work):
    """As `turning_alone`, but for what the fibre does at times that are not 0."""
    size = y[0] * y[0] + y[1] * y[1] + y[2] * y[2]
    if len(y) > 3:
        size = size + t * y[3]
    out[0], out[1], out[2] = size, 2.0 * size, 3.0 * size


@pytest.mark.parametrize(
    ("problem", "words"),
    [
        (turned(measure=gi.Measure(of_the_fibre, base=ALONE)), "densities differ"),
        (turned(measure=gi.Measure(base=turned(both=False, measure=gi.Measure(of_the_fibre),
            action=gi.GroupAction(turning_alone, gi.so3(1))))), "densities differ"),
        (turned(measure=gi.Measure(base=ALONE),
            action=gi.GroupAction(coupled_later, gi.so3(2))), "do not move"),
    ],
)  # fmt: skip
def test_what_shows_elsewhere_only(problem: gi.Problem, words: str) -> None:
    y0 = np.array([1.0, 0.2, 0.3, 0.0, 0.6, 0.8])
    assert words in off_base(problem, problem.measure.base, y0, 0.0)
    by_all, by_base = by_all_and_by_base(problem, y0)
    assert by_all == by_base


@pytest.mark.filterwarnings("ignore::geomint.DeclarationWarning")  # of numbers that fit no body
@pytest.mark.parametrize("factor", [1.5, 1.0 + 3e-7])
@pytest.mark.parametrize("seed", [None, 0])
def test_other_parameters_from_a_steady_rotation_too(seed: int | None, factor: float) -> None:
    """There the rates are 0 for all bodies."""
    problem = PROBLEMS["attitude, R³"]
    changed = dataclasses.replace(problem, params=problem.params * factor)
    steady = problem.state(gamma=[0.0, 0.0, 1.0], k=[0.0, 0.0, 1.0])
    y0 = steady if seed is None else problem.random_state(seed)
    by_all, by_base = by_all_and_by_base(changed, y0)
    assert by_all == by_base


@gi.field
def shrinking(params, t, y, out, work):
    out[0] = 1.0 + 0.0 * y[0]
    if len(y) > 1:
        out[1] = -0.5 * y[1]


def test_a_fibre_that_is_stretched_is_found_by_the_check_of_problems() -> None:
    """Translations by −z/2: affine, by elements of the group, and yet they keep no measure."""

    def moved(rows: int, **given: Any) -> gi.Problem:
        action = gi.GroupAction(shrinking, gi.translations(rows))
        pieces = (("x", 1), ("z", 1))[:rows]
        return gi.Problem("moved", pieces, action=action, **given)

    problem = moved(2, measure=gi.Measure(base=moved(1, measure=gi.Measure())))
    with pytest.raises(AssertionError, match="is stretched"):
        check_problem(problem, [np.array([0.5, 0.3])])


def test_subnormal_momenta() -> None:
    problem = PROBLEMS["attitude, R³"]
    y0 = problem.random_state(0)
    y0[:3] *= 1e-318
    assert off_base(problem, problem.measure.base, y0, 0.0) == ""


def test_a_base_without_the_form_that_is_integrated() -> None:
    by_field, y0 = turned(both=False, action=None, field=bent), np.ones(6)
    assert "neither a field nor an action" in off_base(over(by_field), by_field, y0, 0.0)
    by_all, by_base = by_all_and_by_base(over(by_field), np.array([1.0, 0.2, 0.3, 0.0, 0.6, 0.8]))
    assert by_all == by_base


@gi.field
def circling(params, t, y, out, work):
    size = y[0] * y[0] + y[1] * y[1] + y[2] * y[2]
    for i in range(0, len(y), 3):
        out[i] = size * (2.0 * y[i + 2] - 3.0 * y[i + 1])
        out[i + 1] = size * (3.0 * y[i] - y[i + 2])
        out[i + 2] = size * (y[i + 1] - 2.0 * y[i])


@pytest.mark.nightly
def test_a_base_without_the_field_that_is_integrated() -> None:
    problem = dataclasses.replace(over(ALONE), field=circling)
    y0 = np.array([1.0, 0.2, 0.3, 0.0, 0.6, 0.8])
    assert off_base(problem, ALONE, y0, 0.0) == ""
    by_all, by_base = by_all_and_by_base(problem, y0, "gauss-2")
    assert by_all == by_base


def test_the_base_of_another_ball_is_none() -> None:
    """So parameters may be changed without a new base."""
    problem = PROBLEMS["attitude, R³"]
    other = ch.ChaplyginSphere.from_moments((1.0, 2.0, 2.9), 1.0, 1.0).classical(attitude=True)
    changed = dataclasses.replace(problem, params=other.params)
    y0 = problem.random_state(0)
    by_all, by_base = by_all_and_by_base(changed, y0)
    assert by_all == by_base
    right = drift(other, y0, "cf-4")
    np.testing.assert_allclose(by_base.final_error, right.final_error, rtol=1e-6)


@pytest.mark.parametrize(
    ("base", "error", "words"),
    [
        (3, gi.DomainError, "base = 3: expected a geomint.Problem, or None"),
        (turned(), gi.DomainError, "a problem in the first pieces"),
        (turned(both=False, measure=None), gi.FormError, "has no measure"),
        (BODY.classical(), gi.DomainError, "a problem in the first pieces"),
        (
            turned(both=False, time="tau", clock=gi.observable(lambda params, t, y, work: 1.0)),
            gi.DomainError,
            "in the same time, 't'",
        ),
    ],
)
def test_what_cannot_be_one(base: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        over(base)
