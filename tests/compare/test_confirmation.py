"""A reference shares nothing with what it judges: a second method confirms it, or objects."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import pytest
from hypothesis import given, strategies as st

import geomint as gi
from geomint.compare import confirmation
from geomint.compare.confirmation import confirm
from geomint.compare.runs import compare
from tests.compare.circle import (
    CIRCLE,
    EAST,
    IN_TAU,
    PENDULUM,
    REST,
    REST_AT_100,
    on_circle,
    turning,
    with_time,
)
from tests.rows import examples

pytestmark = pytest.mark.nojit


@examples(4)
@given(st.floats(-20.0, 20.0).filter(lambda t: abs(t) > 1e-12), st.integers(-150, 150))
def test_a_short_run_is_confirmed_without_any_compiled_code(end, power):
    """Of any sign and any unit; physical time is confirmed too."""
    size = 10.0**power
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(confirmation, "solve", lambda *a, **k: pytest.fail("a kernel of ours"))
        found = confirm(CIRCLE, size * EAST, end, lambda t: size * on_circle(t))
        late = confirm(IN_TAU, EAST, end, lambda tau: with_time(tau) * [1.0, 1.0, 1.0 + 1e-8])
        assert confirm(IN_TAU, EAST, end, with_time).agrees(0.0)
    assert "SciPy" in found.method
    assert found.own_end == end
    assert found.agrees(0.0)
    assert found.difference < found.accuracy < 1e-11
    assert not late.agrees(0.0)
    assert late.difference == pytest.approx(1e-8, rel=1e-3)


@pytest.mark.parametrize("expected", [100.0, 1.0])  # evaluations: one finds it longer than that
def test_a_long_run_is_confirmed_by_kernels_of_another_family(monkeypatch, expected):
    monkeypatch.setattr(confirmation, "PLAIN", 200)
    monkeypatch.setattr(confirmation, "EVALUATIONS", expected)
    monkeypatch.setattr(confirmation, "solve", functools.partial(gi.solve, compiled=False))
    for problem, right in ((CIRCLE, on_circle), (IN_TAU, with_time)):
        found = confirm(problem, EAST, 5.0, right)
        assert (found.method, found.own_end) == ("dop853-adaptive", 5.0)
        assert found.difference < found.accuracy < 1e-11


def test_the_second_method_takes_states_as_they_are(monkeypatch):
    """A start that is shifted off the space is not brought back to it."""
    asked = []

    def second(problem, y0, end, turns):
        asked.append(problem.canonical(y0 * (1.0 + 1e-9)))
        return "any", {"x": y0}, 1e-12

    monkeypatch.setattr(confirmation, "_second", second)
    on_space = gi.Problem("circle", space=gi.Sphere(2, "x"), field=turning)
    confirm(on_space, EAST, 1.0, on_circle)
    np.testing.assert_array_equal(asked, [EAST * (1.0 + 1e-9)])


@gi.field
def parting(params, t, y, out, work):
    out[0] = params[0] * y[1]
    out[1] = params[0] * y[0]


@pytest.mark.parametrize(("shift", "least", "most"), [(2.0**-48, 1e-9, 1e-6), (0.0, 0.0, 2e-13)])
def test_the_accuracy_counts_what_roundings_grow_to(monkeypatch, shift, least, most):
    """Next to the way into a saddle they grow by e¹⁶, whatever the tolerances."""
    monkeypatch.setattr(confirmation, "LOOSER", 1.0)
    monkeypatch.setattr(confirmation, "SHIFT", shift)
    problem = gi.Problem("saddle", (("x", 2),), params=[10.0], field=parting)
    end, near = 0.8, np.array([1.0, -1.0 + 1e-9])

    def right(t):
        grow, fall = np.exp(np.longdouble(10.0 * t)), np.exp(np.longdouble(-10.0 * t))
        up, down = 0.5 * (near[0] + near[1]), 0.5 * (near[0] - near[1])
        return np.array([up * grow + down * fall, up * grow - down * fall])

    found = confirm(problem, near, end, right)
    assert least < found.accuracy < most
    assert found.own_end == end
    assert found.agrees(0.0) == (shift > 0.0)


@pytest.mark.parametrize(
    ("accuracies", "end"),
    [
        ({64.0: 1e-9}, 64.0),
        ({64.0: 0.3, 16.0: 1e-9}, 16.0),
        ({64.0: None, 16.0: 0.3, 4.0: 1e-9}, 4.0),
        ({64.0: 0.3, 16.0: 1e-4, 4.0: 1e-5, 1.0: 1e-6}, 1.0),
        ({64.0: 0.3, **{16.0 / 4.0**k: 1e-4 / 2.0**k for k in range(8)}}, 16.0),
        ({64.0 / 4.0**k: 2e-3 for k in range(9)}, None),  # never accurate: it confirms nothing
    ],
)
def test_where_the_second_loses_itself_a_part_of_the_run_is_confirmed(monkeypatch, accuracies, end):
    def second(problem, y0, end, turns):
        if accuracies.get(end) is None:
            raise gi.StepLimitError(0.0, 0, 1.0, 1)
        return "fake", {"x": on_circle(end).astype(float)}, accuracies[end]

    monkeypatch.setattr(confirmation, "_second", second)
    found = confirm(CIRCLE, EAST, 64.0, on_circle)
    assert found.difference < found.accuracy
    assert found.agrees(0.0) == (end is not None)
    if end is not None:
        assert (found.own_end, found.accuracy) == (end, accuracies[end])


def test_no_run_is_too_long_to_be_confirmed_at_its_beginning(monkeypatch):
    ends = []
    monkeypatch.setattr(confirmation, "_second", lambda p, y, end, turns: ends.append(end) or turns)
    with pytest.raises(TypeError):
        confirm(CIRCLE, EAST, 1e12, on_circle)
    assert ends == [pytest.approx(240_000.0)]


def test_the_second_method_is_right_from_rest():
    """Neither pieces that are exactly 0 nor a time scale that is missing there matter to it."""
    found = confirm(PENDULUM, REST, 100.0, lambda t: REST_AT_100)
    assert found.own_end == 100.0
    assert found.accuracy < 1e-8
    assert found.difference < 2e-8


class Turning:
    """The exact motion on the circle."""

    def __init__(self, off=0.0, estimate=1e-15):
        self.off, self.estimate = off, estimate

    def __call__(self, t):
        return self.at_tau(t)

    def at_tau(self, tau):
        return on_circle(tau + self.off).astype(float)

    def time(self, tau):
        return 2.0 * tau + np.sin(tau)

    def tau(self, t):
        return t

    def phase_error(self, tau):
        return self.estimate

    def time_error(self, tau):
        return 0.0


@pytest.mark.parametrize(
    ("motion", "word"), [(Turning(1e-4), "differs by"), (Turning(0.0, 1e-3), r"errs by 0\.001")]
)
def test_an_exact_flow_that_is_not_is_refused(motion, word):
    for problem, end in ((CIRCLE, {"t_end": 3.0}), (IN_TAU, {"tau_end": 3.0})):
        exact = dataclasses.replace(problem, make_exact=lambda y: motion)
        model = gi.Model({"circle": exact}, {"circle": EAST})
        with pytest.raises(gi.UnknownReferenceError, match=word):
            compare(model, end, ["rk-4"], repeats=1, observe=False, reference="exact")


@pytest.mark.nightly
def test_an_exact_flow_that_is_refused_is_not_replaced_without_a_word():
    """Where the other reference would take minutes."""
    exact = dataclasses.replace(CIRCLE, make_exact=lambda y: Turning(1e-4))
    with pytest.raises(gi.UnknownReferenceError, match="exact flow"):
        compare(gi.Model({"circle": exact}, {"circle": EAST}), {"t_end": 1e5}, ["rk-4"])
