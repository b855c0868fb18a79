"""The rules: every way of going wrong is caught, and under its own name."""

import dataclasses
import warnings

import numpy as np
import pytest

import geomint as gi
from geomint.stress import judge as judging
from geomint.stress.judge import Trial, judge
from geomint.stress.known_end import KnownEnd, known_end


@gi.field
def turning(params, t, y, out, work):
    """A point on a circle, at an angular velocity."""
    out[0] = -params[0] * y[1]
    out[1] = params[0] * y[0]


@gi.observable
def radius_squared(params, t, y, work):
    """x² + y²."""
    return y[0] * y[0] + y[1] * y[1]


CIRCLE = {"field": turning, "invariants": {"radius-squared": radius_squared}}
PROBLEM = gi.Problem("circle", (("x", 2),), [1.0], **CIRCLE)
METHOD = gi.find_method("rk-4")


class Keeping(gi.RungeKutta):
    """The same steps, and a false statement about them."""

    keeps = ("quadratic invariants",)


class Following(gi.RungeKutta):
    keeps = ("steady motions",)


KEEPING = Keeping("rk-4")
HALF = 0.5 * METHOD.step_fraction
EPS = np.finfo(float).eps


def exact(end):
    return np.array([np.cos(end), np.sin(end)])


@pytest.fixture
def verdict_on(monkeypatch):
    """Return a function that judges runs that were tampered with."""

    def verdict(tamper=None, method=METHOD, raises=None, **options):
        def fake(*arguments, **keywords):
            solution = gi.solve(*arguments, **{**keywords, "compiled": False})
            if raises is not None:
                raises(solution)
            if tamper is not None:
                for i, t in enumerate(solution.tau):
                    solution.y[i] = tamper(solution.y[i], t, solution.step)
            return solution

        monkeypatch.setattr(judging, "solve", fake)
        options = {"step": HALF, "steps": 20, **options}
        reference = options.pop("reference", lambda end: KnownEnd({"x": exact(end)}, 1.0))
        model = gi.Model({"plane": PROBLEM}, {"plane": np.array([1.0, 0.0])})
        axis = gi.StressAxis("none", "", "")
        trial = Trial(gi.StressCase("circle", axis, 0.0, 2, lambda: model, **options), "plane")
        monkeypatch.setattr(trial, "reference", reference)
        return judge(lambda: trial, method)

    return verdict


def test_good(verdict_on):
    found = verdict_on()
    told = {"verdict": "ok", "h": pytest.approx(HALF), "steps": 20, "allowed": 32.0 * EPS}
    error = pytest.approx(HALF**5 / 6.0, rel=0.01)  # of the phase, in 20 steps
    unsure = {"known": None, "confirmed": None}
    assert found.pop("seconds") > 0.0
    assert found.pop("message").endswith(" at 1/2 of the step")
    assert found == {**told, **unsure, "error": error}
    adaptive = gi.find_method("dop853-adaptive")
    found = verdict_on(method=adaptive, step=None)
    off = adaptive.options["rtol"] + adaptive.options["atol"]
    wanted = off * found["steps"], 2.0 / found["steps"]
    assert (found["allowed"], found["h"]) == pytest.approx(wanted)


def test_round_off_is_ok_without_a_second_run(verdict_on):
    found = verdict_on(lambda y, t, h: exact(t))
    assert (found["verdict"], found["message"]) == ("ok", "")
    assert verdict_on(lambda y, t, h: exact(t), KEEPING)["verdict"] == "ok"


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_not_finite(verdict_on, number):
    found = verdict_on(lambda y, t, h: np.array([number, 0.0]))
    assert (found["verdict"], "not finite" in found["message"]) == ("wrong", True)


def test_untyped(verdict_on):
    for raises in (
        lambda solution: solution.no_such_name,
        lambda solution: warnings.warn("overflow", RuntimeWarning, stacklevel=1),
    ):
        found = verdict_on(raises=raises)
        assert (found["verdict"], type(found["message"])) == ("untyped", str)


def failing(change=lambda error: None):
    def fail(solution):
        error = gi.ConvergenceError(0.3, 4, 1e-3, 100)
        error.partial = solution
        change(error)
        raise error

    return fail


def spoil(error):
    error.partial.y[0] = np.nan


def test_failed(verdict_on):
    found = verdict_on(raises=failing())
    assert (found["verdict"], found["quantity"]) == ("failed", "residual")
    assert found["error"] == 1e-3


def test_failed_without_what_a_failure_promises(verdict_on):
    for change in (
        spoil,
        lambda error: setattr(error, "partial", None),
        lambda error: setattr(error, "t", np.nan),
    ):
        assert verdict_on(raises=failing(change))["verdict"] == "wrong"


def test_refused(verdict_on):
    def refuse(solution):
        raise gi.DomainError("D", -1.0, "a positive number")

    assert verdict_on(raises=refuse)["verdict"] == "refused"


def test_a_promised_invariant_that_is_lost(verdict_on, monkeypatch):
    def grown(y, t, h):
        return exact(t) * (1.0 + 1e-13 * (t > 0.0))

    rough = {"reference": lambda end: KnownEnd({"x": exact(end)}, 1e6)}
    assert verdict_on(grown, **rough)["verdict"] == "ok"
    scale = 2.0 * max(exact(0.3)) * sum(exact(0.3))
    lost = {"verdict": "wrong", "message": "radius-squared is to be preserved"}
    lost |= {"quantity": "radius-squared", "error": pytest.approx(2e-13 / scale, rel=0.01)}
    for defect in (0.0, 1e-14):
        kept = {"radius-squared": defect}
        monkeypatch.setattr(judging.Quantities, "preserved", lambda *_, kept=kept: kept)
        found = verdict_on(grown, KEEPING, **rough)
        assert found.items() >= {**lost, "steps": 20, "allowed": 32.0 * EPS + defect}.items()
    long = verdict_on(grown, KEEPING, **rough, steps=200)
    assert long["allowed"] == pytest.approx(3.0 * 32.0 * EPS + defect)  # times the first one


def test_roundings_of_a_fast_motion_are_counted_step_by_step(verdict_on, monkeypatch):
    """200 steps of a motion that turns much faster than its first state tells round 200 times."""

    def grown(y, t, h):
        return exact(t) * (1.0 + 5e-14 * (t > 0.0))

    options = {"steps": 200, "reference": lambda end: KnownEnd({"x": exact(end)}, 1e6)}
    assert verdict_on(grown, KEEPING, **options)["verdict"] == "wrong"
    monkeypatch.setattr(judging, "separation_time", lambda problem, y0: 1e-6)
    assert verdict_on(grown, KEEPING, **options)["verdict"] != "wrong"
    options["steps"] = 4
    assert verdict_on(grown, KEEPING, **options)["verdict"] == "wrong"


def test_digits_that_the_field_loses_are_no_fault_of_the_method(verdict_on, monkeypatch):
    """An error that no step makes smaller is wrong, unless rounding makes as much of the field."""

    def tamper(y, t, h):
        return exact(t) + 1e-9

    assert verdict_on(tamper)["verdict"] == "wrong"
    monkeypatch.setattr(judging, "field_rounding", lambda problem, y0: 1e-8)
    assert verdict_on(tamper)["verdict"] == "ok"


@pytest.mark.parametrize(
    ("error", "step", "verdict"),
    [
        (lambda h: 1e-4, HALF, "wrong"),  # does not fall with the step
        (lambda h: 1e-4 * (h / HALF), HALF, "wrong"),  # falls with order 1, not 4
        (lambda h: 1e-4 * (h / HALF) ** 4, HALF, "ok"),
        (lambda h: 0.3, HALF, "wrong"),
        (lambda h: 0.3, 2 * METHOD.step_fraction, "unresolved"),
        (lambda h: 1e-4, 2 * METHOD.step_fraction, "unresolved"),
    ],
)
def test_accuracy(verdict_on, error, step, verdict):
    def tamper(y, t, h):
        return exact(t) + error(h)

    assert verdict_on(tamper, step=step)["verdict"] == verdict


def test_a_steady_motion_is_never_unresolved_where_it_is_promised(verdict_on):
    step = {"step": 3.0, "steps": 4}
    assert verdict_on(**step)["verdict"] == "unresolved"
    following = Following("rk-4")
    assert verdict_on(**step, steady=True)["verdict"] == "unresolved"
    assert verdict_on(**step, steady=True, method=following)["verdict"] == "wrong"
    right = verdict_on(lambda y, t, h: exact(t), **step, steady=True, method=following)
    assert right["verdict"] == "ok"


def test_a_motion_that_magnifies_round_off_to_its_own_size(verdict_on):
    found = verdict_on(reference=lambda end: KnownEnd({"x": -exact(end)}, 1e15))
    assert found["verdict"] == "unresolved"
    assert found["allowed"] > 0.1


def test_without_a_reference_a_finer_run_is_the_measure(verdict_on):
    found = verdict_on(reference=lambda end: None)
    assert found["verdict"] == "ok"
    assert "no reference" in found["message"]
    assert verdict_on(lambda y, t, h: y + h, reference=lambda end: None)["verdict"] == "wrong"


def test_a_reference_that_is_not_known_blames_no_method(verdict_on):
    def unknown(end):
        raise gi.UnknownReferenceError("SciPy says otherwise", 1e-3, 1e-5, "advice")

    found = verdict_on(reference=unknown)
    assert (found["verdict"], found.get("confirmed")) == ("ok", None)
    assert "no reference (UnknownReferenceError" in found["message"]


def test_a_reference_says_how_sure_it_is():
    end = known_end(PROBLEM, np.array([1.0, 0.0]), 2.0)
    np.testing.assert_allclose(end.pieces["x"], exact(2.0), rtol=0.0, atol=1e-15)
    assert end.known < 1e-16
    assert 1e-16 < end.confirmed < 1e-11
    assert 1.0 <= end.condition < 10.0


def test_references_at_tiny_times_are_those_of_the_same_motion():
    """Their steps were rounded as float32, which has no number below 1e-45."""
    size = 2.0**200
    one, other = (
        known_end(dataclasses.replace(PROBLEM, params=[w]), np.array([1.0, 0.0]), 1.0 / w)
        for w in (1.0, size)
    )
    np.testing.assert_array_equal(one.pieces["x"], other.pieces["x"])


@gi.field
def cancelling(params, t, y, out, work):
    """Two large numbers whose difference is 1 to 1e-8."""
    out[0] = (params[0] + y[0]) - params[0]
    out[1] = 1.0 * y[1]


def test_digits_that_a_field_loses_are_seen():
    if np.finfo(np.longdouble).eps > 1e-18:
        pytest.skip("no extended precision here")
    lossy = gi.Problem("lossy", (("x", 2),), params=[1e8 / 3.0], field=cancelling)
    assert 1e-10 < judging.field_rounding(lossy, np.array([0.7, 1.0])) < 1e-7
    assert judging.field_rounding(PROBLEM, np.array([1.0, 0.0])) <= 1e-15
