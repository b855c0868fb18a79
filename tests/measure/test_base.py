"""A fibre over a base: what steps by the action make of the measure is what they make of the base's."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.testing import check_problem
from geomint.watch.measure import InvariantMeasure

BODY = ch.ChaplyginSphere.from_moments((1.0, 2.0, 3.0), 1.0, 1.0)
BALL = ch.ChaplyginSphere(a=[0.7, 0.9, 1.2, 1.5], D=4.0)
ROLLING = ch.ChaplyginSphere(a=[0.7, 0.9, 1.2], D=4.0)
PROBLEMS = {
    "attitude, R³": BODY.classical(attitude=True),
    "attitude, R⁴": BALL.ball(attitude=True),
    "attitude and contact point": ROLLING.contact(m=1.0, rho=2.0),
}
ATTITUDE = PROBLEMS["attitude, R³"]
BY_GROUP = ("cf-4", "cg-3", "rkmk-4", "rkmk-cayley-4", "rkmk-dormand-prince-5-adaptive")
BY_GROUP += ("gauss-1", "gauss-3", "gauss-1-suzuki-4")


def whole(problem: gi.Problem) -> gi.Problem:
    """The same problem, whose measure knows no base."""
    return dataclasses.replace(problem, measure=dataclasses.replace(problem.measure, base=None))


def drift(problem: gi.Problem, y0: Any, method: Any, t_end: float = 0.1, **options: Any):
    step = {} if "adaptive" in str(method) else {"step": 0.1}
    run = {"observe": ["measure"], "compiled": False, **step, **options}
    (found,) = gi.solve(problem, y0, t_end=t_end, method=method, **run).drift.values()
    return found


def both(problem: gi.Problem, y0: Any, method: Any = "cf-4", **options: Any) -> list[gi.Drift]:
    """By the base, and by the whole state."""
    return [drift(p, y0, method, **options) for p in (problem, whole(problem))]


SLOW = [pytest.mark.nightly]
CASES = [
    *(pytest.param(m, "attitude, R³", False, marks=SLOW * ("gauss-1" in m)) for m in BY_GROUP),
    pytest.param("cf-4", "attitude and contact point", False, marks=SLOW),
    *(pytest.param(m, n, True, marks=SLOW) for m in BY_GROUP for n in PROBLEMS),
]


@pytest.mark.parametrize(("method", "name", "compiled"), CASES)
def test_the_base_alone_says_as_much(method: str, name: str, compiled: bool) -> None:
    problem, t_end = PROBLEMS[name], 6.0 if compiled else 0.1
    options = {"t_end": t_end, "compiled": compiled}
    by_base, by_all = both(problem, problem.random_state(3), method, **options)
    noise = 32.0 * 2.0**-52 * by_all.scale
    assert by_base.scale < by_all.scale  # fewer rows make less noise
    assert abs(by_base.final_error) > noise or not compiled
    np.testing.assert_allclose(by_base.windows.maxima, by_all.windows.maxima, atol=noise, rtol=0.0)
    if compiled:
        y0 = problem.random_state(1)
        assert drift(problem, y0, method, compiled=True) == drift(problem, y0, method)


@pytest.mark.parametrize("method", ["rk-4", gi.Gauss(2, iteration_tolerance=1e-4)])
def test_methods_that_do_not_keep_the_fibre_are_judged_by_the_whole_state(method: Any) -> None:
    """Those of fields; and iterations that stop early."""
    y0 = ATTITUDE.random_state(3)
    by_base, by_all = both(ATTITUDE, y0, method)
    assert by_base == by_all
    base = ATTITUDE.measure.base
    alone = drift(base, y0[: base.rows], method)
    assert abs(alone.final_error - by_all.final_error) > 1e-12


def test_steps_that_are_not_all_watched_and_a_last_partial_step() -> None:
    for observe in (["measure"], {"it": InvariantMeasure(steps=2)}):
        options = {"t_end": 0.23, "observe": observe}
        one, other = both(ATTITUDE, ATTITUDE.random_state(4), **options)
        assert abs(one.final_error - other.final_error) < 1e-13 < abs(one.final_error)


def test_from_rest_steady_tiny_and_fast() -> None:
    for k in ([0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1e-200, 0.0, 0.0], [1e3, 1.0, 2.0]):
        y0 = ATTITUDE.state(gamma=[0.0, 1.0, 0.0], k=k)
        found = drift(ATTITUDE, y0, "cf-4", t_end=0.002, step=0.001)
        assert np.isfinite(found.final_error)
        assert found.within_roundoff or k[0] == 1e3


def test_a_problem_that_runs_in_another_time_has_no_base() -> None:
    uneven = gi.time_transformed(ATTITUDE, "speed", ATTITUDE.random_state(0))
    assert uneven.measure.base is None


# --- what is no base ------------------------------------------------------------------------------


def generator(coupled: Any = lambda params, t, y: 0.0) -> Any:
    """ξ = (1, 2, 3) (|x|² + what the fibre does), of x the first three rows."""
    extra = gi.helper(coupled)

    @gi.field
    def turning(params, t, y, out, work):
        size = y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + extra(params, t, y)
        out[0], out[1], out[2] = size, 2.0 * size, 3.0 * size

    return turning


def turned(xi: Any = None, both: bool = True, **given: Any) -> gi.Problem:
    """x alone, or x and a fibre z."""
    action = gi.GroupAction(xi or generator(), gi.so3(2 if both else 1))
    pieces = (("x", 3), ("z", 3)) if both else (("x", 3),)
    return gi.Problem(
        "turned", pieces, [1.0], **{"measure": gi.Measure(), "action": action, **given}
    )


ALONE = turned(both=False)
Y0 = np.array([1.0, 0.2, 0.3, 0.0, 0.6, 0.8])


def over(base: Any, xi: Any = None, **given: Any) -> gi.Problem:
    return turned(xi, measure=gi.Measure(base=base), **given)


def test_a_fibre_of_ones_own() -> None:
    check_problem(over(ALONE), [Y0])
    assert drift(over(ALONE), Y0, "cf-4").within_roundoff


def about(speed: Any) -> Any:
    """The rates of the action, z at another speed."""
    by = gi.helper(speed)

    @gi.field
    def field(params, t, y, out, work):
        for i in range(0, len(y), 3):
            size = (y[0] * y[0] + y[1] * y[1] + y[2] * y[2]) * (1.0 if i == 0 else by(y))
            out[i] = size * (2.0 * y[i + 2] - 3.0 * y[i + 1])
            out[i + 1] = size * (3.0 * y[i] - y[i + 2])
            out[i + 2] = size * (y[i + 1] - 2.0 * y[i])

    return field


BENT = about(lambda y: y[3] * y[3] + y[4] * y[4] + y[5] * y[5])


@gi.observable
def of_the_fibre(params, t, y, work):
    return y[len(y) - 1]


BY_FIBRE = generator(lambda params, t, y: params[0] * y[3])
LATER = generator(lambda params, t, y: t * y[3] if len(y) > 3 else 0.0)
AT = [1, 0.2, 0.3, 1, 1, 2]
OFF = [1, 0.2, 0.3, 0, 1, 2]
DENSE = gi.Measure(of_the_fibre)
WRONG = {
    "where the fibre is": (over(ALONE, BY_FIBRE), AT, "do not move as the base"),
    "where it is not": (over(ALONE, BY_FIBRE), OFF, "do not move by themselves"),
    "at other times": (over(ALONE, LATER), Y0, "do not move"),
    # They agree with the action where the fibre is, |z| = 1, and Gauss methods differ.
    "rates": (over(dataclasses.replace(ALONE, field=BENT), field=BENT), Y0, "are not affine"),
    "form": (over(turned(both=False, action=None, field=BENT)), Y0, "neither a field nor an"),
    "density": (turned(measure=dataclasses.replace(DENSE, base=ALONE)), Y0, "densities differ"),
    "density of the base": (over(turned(both=False, measure=DENSE)), Y0, "densities differ"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_depends_on_the_fibre_has_no_base(name: str) -> None:
    """The check of problems says why; the whole state is looked at."""
    problem, y0, words = WRONG[name]
    y0 = np.array(y0, dtype=float)
    with pytest.raises(AssertionError, match=words):
        check_problem(problem, [y0])
    by_base, by_all = both(problem, y0)
    assert by_base == by_all


def test_what_cannot_be_seen_of_a_base() -> None:
    """The field that is integrated, if it has none: that is no fault, and no use."""
    problem = over(ALONE, field=about(lambda y: 1.0))
    check_problem(problem, [Y0])
    by_base, by_all = both(problem, Y0, "gauss-2")
    assert by_base == by_all


@gi.field
def shrinking(params, t, y, out, work):
    out[0] = 1.0 + 0.0 * y[0]
    if len(y) > 1:
        out[1] = -0.5 * y[1]


def test_a_fibre_that_is_stretched_is_found_by_the_check_of_problems() -> None:
    """Translations by −z/2: affine, by elements of the group, and yet they keep no measure."""

    def moved(rows: int, measure: gi.Measure) -> gi.Problem:
        action = gi.GroupAction(shrinking, gi.translations(rows))
        return gi.Problem("moved", (("x", 1), ("z", 1))[:rows], action=action, measure=measure)

    problem = moved(2, gi.Measure(base=moved(1, gi.Measure())))
    with pytest.raises(AssertionError, match="is stretched"):
        check_problem(problem, [np.array([0.5, 0.3])])


@gi.field
def too_far(params, t, y, out, work):
    out[0] = out[1] = out[2] = y[0]
    out[100_000_000] = 1.0


def test_a_base_whose_functions_do_not_fit_is_refused() -> None:
    """Compiled, they would write and read other memory; though the field of the base is right."""
    action = gi.GroupAction(too_far, gi.so3(1))
    for place, given in (
        (r"action\.generator", {"field": BENT, "action": action}),
        (r"measure\.manifold", {"measure": gi.Measure(manifold=too_far, conditions=1)}),
    ):
        with pytest.raises(gi.DeclarationError, match=place):
            drift(over(turned(both=False, **given)), Y0, "cf-4")


@pytest.mark.filterwarnings("ignore::geomint.DeclarationWarning")  # of numbers that fit no body
def test_other_parameters_from_a_steady_rotation_too() -> None:
    """There the rates are 0 for all bodies."""
    steady = ATTITUDE.state(gamma=[0.0, 0.0, 1.0], k=[0.0, 0.0, 1.0])
    for factor, y0 in ((1.5, ATTITUDE.random_state(0)), (1.0 + 3e-7, steady)):
        changed = dataclasses.replace(ATTITUDE, params=ATTITUDE.params * factor)
        by_base, by_all = both(changed, y0)
        assert by_base == by_all


def test_what_cannot_be_one() -> None:
    timed = {"time": "tau", "clock": gi.observable(lambda params, t, y, work: 1.0)}
    for base, error, words in (
        (3, gi.DomainError, "base = 3: expected a geomint.Problem, or None"),
        (turned(), gi.DomainError, "a problem in the first pieces"),
        (turned(both=False, measure=None), gi.FormError, "has no measure"),
        (BODY.classical(), gi.DomainError, "a problem in the first pieces"),
        (turned(both=False, **timed), gi.DomainError, "in the same time, 't'"),
    ):
        with pytest.raises(error, match=words):
            over(base)
