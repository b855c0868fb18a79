"""A reference shares nothing with what it judges: references are confirmed, and refused where they err.

No test here rests on an error that a method of ours happens to make: the wrong references are planted.
"""

from __future__ import annotations

import dataclasses
import functools
import json

import numpy as np
import pytest

import geomint as gi
from geomint.compare import confirmation, reference, reference_record
from geomint.compare.confirmation import Confirmation, confirm
from geomint.compare.reference import reference_solution
from geomint.compare.reference_record import Reference, name_of, stored
from geomint.kernels.compiling import digest
from geomint.kernels.compiling.private import PrivateFolder
from geomint.problems.testproblems import neumann


@gi.field
def pendulum(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -gi.sin(y[0])


@gi.field
def circle(params, t, y, out, work):
    out[0] = -y[1]
    out[1] = y[0]


@gi.field
def circle_rate(params, t, y, work):
    return 2.0 + y[0]


PENDULUM = gi.Problem("pendulum", (("angle", 1), ("momentum", 1)), field=pendulum)
CIRCLE = gi.Problem("circle", (("x", 2),), field=circle)
IN_TAU = gi.Problem("circle", (("x", 2),), field=circle, clock=circle_rate, time="tau")
EAST = np.array([1.0, 0.0])
REST = np.array([2.0, 0.0])
REST_AT_100 = np.array([1.98232565, 0.17964074])  # to 8 digits, from outside of this package


def on_circle(t):
    return np.array([np.cos(t), np.sin(t)], dtype=np.longdouble)


def with_time(tau):
    return np.append(on_circle(tau), 2.0 * tau + np.sin(tau))


@pytest.fixture(autouse=True)
def own_folder(monkeypatch, tmp_path):
    """Neither take references from disk nor leave wrong ones there."""
    monkeypatch.setattr(reference_record, "private_folder", lambda _: PrivateFolder(tmp_path, ""))
    return tmp_path


@pytest.fixture
def planted(monkeypatch):
    """Return a function that makes every double-double solution of the circle wrong."""

    def plant(wrong):
        monkeypatch.setattr(
            reference, "integrate_extended", lambda p, y0, end, h: wrong(on_circle(end), end, h)
        )

    return plant


# The second method


@pytest.mark.nojit
def test_a_short_run_is_confirmed_without_any_compiled_code(monkeypatch):
    monkeypatch.setattr(confirmation, "solve", lambda *a, **k: pytest.fail("a kernel of ours"))
    found = confirm(CIRCLE, EAST, 20.0, on_circle)
    assert "SciPy" in found.method
    assert found.own_end == 20.0
    assert 1e-15 < found.difference < found.accuracy < 1e-11


@pytest.mark.nojit
def test_a_long_run_is_confirmed_by_kernels_of_another_family(monkeypatch):
    monkeypatch.setattr(confirmation, "PLAIN", 100)
    uncompiled = functools.partial(gi.solve, compiled=False)
    monkeypatch.setattr(confirmation, "solve", uncompiled)
    for problem, right in ((CIRCLE, on_circle), (IN_TAU, with_time)):
        found = confirm(problem, EAST, 5.0, right)
        assert found.method == "dop853-adaptive"
        assert found.own_end == 5.0
        assert found.difference < found.accuracy < 1e-11


@pytest.mark.nojit
def test_a_run_that_python_finds_longer_than_expected_is_compiled(monkeypatch):
    monkeypatch.setattr(confirmation, "EVALUATIONS", 1.0)
    monkeypatch.setattr(confirmation, "PLAIN", 200)
    monkeypatch.setattr(confirmation, "solve", functools.partial(gi.solve, compiled=False))
    assert confirm(CIRCLE, EAST, 5.0, on_circle).method == "dop853-adaptive"


def test_the_second_method_takes_states_as_they_are(monkeypatch):
    """A start that is shifted off the space is not brought back to it."""
    asked = []

    def second(problem, y0, end, turns):
        asked.append(problem.canonical(y0 * (1.0 + 1e-9)))
        return "any", confirmation.named(problem, y0), 1e-12

    monkeypatch.setattr(confirmation, "_second", second)
    on_space = gi.Problem("circle", space=gi.Sphere(2, "x"), field=circle)
    confirm(on_space, EAST, 1.0, on_circle)
    np.testing.assert_array_equal(asked, [EAST * (1.0 + 1e-9)])


@pytest.mark.nojit
@pytest.mark.parametrize("end", [-3.0, 1e-12, 3.0])
@pytest.mark.parametrize("size", [1e-150, 1.0, 1e150])
def test_any_sign_and_any_unit(end, size):
    found = confirm(CIRCLE, size * EAST, end, lambda t: size * on_circle(t))
    assert found.agrees(0.0)
    assert found.own_end == end
    assert found.accuracy < 1e-11


@pytest.mark.nojit
def test_physical_time_is_confirmed_too():
    assert confirm(IN_TAU, EAST, 5.0, with_time).agrees(0.0)
    late = confirm(IN_TAU, EAST, 5.0, lambda tau: with_time(tau) * [1.0, 1.0, 1.0 + 1e-8])
    assert not late.agrees(0.0)
    assert late.difference == pytest.approx(1e-8, rel=1e-3)


@gi.field
def parting(params, t, y, out, work):
    out[0] = params[0] * y[1]
    out[1] = params[0] * y[0]


@pytest.mark.nojit
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


def second_of(accuracies):
    """Return a second method that has an accuracy for every end, or gets nowhere there."""

    def fake(problem, y0, end, turns):
        if accuracies.get(end) is None:
            raise gi.StepLimitError(0.0, 0, 1.0, 1)
        return "fake", {"x": on_circle(end).astype(float)}, accuracies[end]

    return fake


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("accuracies", "end"),
    [
        ({64.0: 1e-9}, 64.0),
        ({64.0: 0.3, 16.0: 1e-9}, 16.0),
        ({64.0: None, 16.0: 0.3, 4.0: 1e-9}, 4.0),
        ({64.0: 0.3, 16.0: 1e-4, 4.0: 1e-5, 1.0: 1e-6}, 1.0),
        ({64.0: 0.3, **{16.0 / 4.0**k: 1e-4 / 2.0**k for k in range(8)}}, 16.0),
    ],
)
def test_where_the_second_loses_itself_a_part_of_the_run_is_confirmed(monkeypatch, accuracies, end):
    monkeypatch.setattr(confirmation, "_second", second_of(accuracies))
    found = confirm(CIRCLE, EAST, 64.0, on_circle)
    assert (found.own_end, found.accuracy) == (end, accuracies[end])
    assert found.agrees(0.0)


@pytest.mark.nojit
def test_a_second_that_is_never_accurate_confirms_nothing(monkeypatch):
    poor = {64.0 / 4.0**k: 2e-3 for k in range(9)}
    monkeypatch.setattr(confirmation, "_second", second_of(poor))
    found = confirm(CIRCLE, EAST, 64.0, on_circle)
    assert found.difference < found.accuracy
    assert not found.agrees(0.0)


@pytest.mark.nojit
def test_no_run_is_too_long_to_be_confirmed_at_its_beginning(monkeypatch):
    ends = []
    monkeypatch.setattr(confirmation, "_second", lambda p, y, end, turns: ends.append(end) or turns)
    with pytest.raises(TypeError):
        confirm(CIRCLE, EAST, 1e12, on_circle)
    assert ends == [pytest.approx(240_000.0)]


# What a reference may judge


def reference_with(error, second):
    return Reference(3.0, None, EAST, error, (0.2, 0.1), "gauss", second)


GOOD = Confirmation("other", 3.0, 1e-13, 2e-14)
BAD = Confirmation("other", 3.0, 1e-13, 4.5e-3)


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("error", "second", "known"),
    [
        (1e-25, GOOD, 1e-25),
        (1e-12, GOOD, 1e-12),
        (1e-2, GOOD, 1e-2),
        (1e-25, BAD, 4.5e-3 + 1e-13),
        (1e-2, BAD, 1e-2),
        (1e-25, dataclasses.replace(BAD, own_end=1.0), np.inf),  # what comes after, nobody knows
        (1e-25, None, np.inf),
        (1e-25, Confirmation("other", 3.0, np.inf, np.inf), np.inf),
        (np.nan, GOOD, np.inf),
        (1e-25, Confirmation("other", 3.0, 1e-13, np.nan), np.inf),
        (1e-25, Confirmation("other", 1.0, 0.5, 1e-3), np.inf),
    ],
)
def test_what_is_known_of_a_reference(error, second, known):
    found = reference_with(error, second)
    assert found.known == known
    assert found.for_errors(10.0 * known) is found if known < np.inf else True
    with pytest.raises(gi.UnknownReferenceError) as raised:
        found.for_errors(5.0 * known if known < np.inf else 1e300)
    assert raised.value.known == known


@pytest.mark.nojit
def test_the_refusal_says_what_was_found():
    with pytest.raises(gi.UnknownReferenceError) as raised:
        reference_with(1e-25, BAD).for_errors(1e-5)
    for word in ("gauss", "other", "0.0045", "1e-13", "1e-05"):
        assert word in str(raised.value)
    with pytest.raises(gi.UnknownReferenceError, match=r"errs by 0\.014 at 3"):
        reference_with(0.014, GOOD).for_errors(1e-5)
    with pytest.raises(gi.UnknownReferenceError, match="no second method"):
        reference_with(0.0, Confirmation("other", 3.0, np.inf, np.inf)).for_errors(1e-5)


def test_a_reference_whose_two_steps_err_alike_is_refused(planted):
    """The planted mistake: both steps are off by 0.0045 and say 0."""
    planted(lambda y, end, h: y + np.array([0.0045, 0.0]))
    with pytest.raises(gi.UnknownReferenceError, match="SciPy") as raised:
        reference_solution(CIRCLE, EAST, 3.0, judges=1e-5)
    assert raised.value.known == pytest.approx(0.0045, rel=0.05)


def test_a_reference_that_has_not_converged_is_refused(planted):
    planted(lambda y, end, h: y + np.array([0.14 * h, 0.0]))
    with pytest.raises(gi.UnknownReferenceError, match="errs by"):
        reference_solution(CIRCLE, EAST, 3.0, judges=1e-5)


def test_by_default_a_reference_judges_what_float64_can_show(planted):
    planted(lambda y, end, h: y + np.array([1e-13 * h, 0.0]))
    with pytest.raises(gi.UnknownReferenceError):
        reference_solution(CIRCLE, EAST, 3.0)
    assert reference_solution(CIRCLE, EAST, 3.0, judges=1e-9).known < 1e-13


def test_a_reference_from_rest_is_right_or_refused():
    """Whatever Gauss does there: a piece that is exactly 0 has led its first step astray before."""
    try:
        found = reference_solution(PENDULUM, REST, 100.0, judges=1e-5)
    except gi.UnknownReferenceError:
        return
    np.testing.assert_allclose(found.y, REST_AT_100, atol=1e-8)


def test_the_second_method_is_right_from_rest():
    """Neither pieces that are exactly 0 nor a time scale that is missing there matter to it."""
    found = confirm(PENDULUM, REST, 100.0, lambda t: REST_AT_100)
    assert found.own_end == 100.0
    assert found.accuracy < 1e-8
    assert found.difference < 2e-8


# On disk


def test_the_confirmation_is_kept_on_disk(own_folder, monkeypatch):
    first = reference_solution(CIRCLE, EAST, 3.0)
    assert first.confirmation is not None
    monkeypatch.setattr(reference, "confirm", lambda *a: pytest.fail("confirmed again"))
    second = reference_solution(CIRCLE, EAST, 3.0)
    assert second.confirmation == first.confirmation
    assert second.agrees


def test_a_refused_reference_is_refused_from_disk_too(planted, monkeypatch):
    planted(lambda y, end, h: y + np.array([0.0045, 0.0]))
    messages = []
    for _ in range(2):
        with pytest.raises(gi.UnknownReferenceError) as raised:
            reference_solution(CIRCLE, EAST, 3.0)
        messages.append(str(raised.value))
        monkeypatch.setattr(reference, "integrate_extended", lambda *a: pytest.fail("again"))
    assert messages[0] == messages[1]


@pytest.mark.nojit
def test_a_file_without_confirmation_is_ignored(tmp_path):
    name = "reference.json"
    folder = PrivateFolder(tmp_path, "")
    reference_with(1e-25, GOOD).store(name)
    assert stored(name).confirmation == GOOD
    data = json.loads(folder.read(name))
    for change in ({"confirmation": None}, {"confirmation": {"method": "other"}}):
        folder.write(name, json.dumps({**data, **change}).encode())
        found = stored(name)
        assert found is None or found.known == np.inf
    del data["confirmation"]
    folder.write(name, json.dumps(data).encode())
    assert stored(name) is None


def test_other_sources_of_geomint_other_references(monkeypatch):
    """What a kernel got wrong once does not stay for ever."""
    before = name_of(CIRCLE, EAST, 3.0)
    assert before == name_of(CIRCLE, EAST, 3.0)
    monkeypatch.setattr(digest, "source_stamp", lambda: "edited")
    assert name_of(CIRCLE, EAST, 3.0) != before


# The exact flow


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
    ("motion", "word"),
    [(Turning(1e-4), "differs by"), (Turning(0.0, 1e-3), r"errs by 0\.001")],
)
def test_an_exact_flow_that_is_not_is_refused(motion, word):
    from geomint.compare.runs import compare

    for problem, end in ((CIRCLE, {"t_end": 3.0}), (IN_TAU, {"tau_end": 3.0})):
        exact = dataclasses.replace(problem, make_exact=lambda y: motion)
        model = gi.Model({"circle": exact}, {"circle": EAST})
        with pytest.raises(gi.UnknownReferenceError, match=word):
            compare(model, end, ["rk-4"], repeats=1, observe=False, reference="exact")


def test_an_exact_flow_that_is_refused_is_not_replaced_without_a_word(monkeypatch):
    from geomint.compare.runs import compare

    monkeypatch.setattr("geomint.compare.endpoint.MOST_EXTENDED_STEPS", 1)
    exact = dataclasses.replace(CIRCLE, make_exact=lambda y: Turning(1e-4))
    with pytest.raises(gi.UnknownReferenceError, match="exact flow"):
        compare(gi.Model({"circle": exact}, {"circle": EAST}), {"t_end": 3.0}, ["rk-4"])


# Problems in general


@pytest.mark.nojit
def test_a_problem_without_a_field_cannot_be_confirmed():
    problem = gi.Problem("action only", (("x", 3),), action=gi.GroupAction(circle, gi.so3(1)))
    with pytest.raises(gi.FormError, match="no field"):
        confirm(problem, np.ones(3), 1.0, on_circle)


@pytest.mark.nightly
def test_chaotic_and_restful_motions_of_the_sphere():
    """Neumann's system from rest, from which Gauss methods once went astray, and for long."""
    problem, y0 = neumann.problem(), neumann.initial()
    y0[3:] = 0.0
    for end in (1.0, 30.0, 300.0):
        try:
            found = reference_solution(problem, y0, end, judges=1e-5)
        except gi.UnknownReferenceError:
            continue
        assert found.agrees
        assert found.confirmation.own_end == end
