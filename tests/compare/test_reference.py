"""References: right to more digits than float64 shows, kept on disk, refused where they err.

No test here rests on an error that a method of ours happens to make: the wrong references are planted.
"""

from __future__ import annotations

import dataclasses

import mpmath as mp
import numpy as np
import pytest

import geomint as gi
from geomint.compare import reference
from geomint.compare.confirmation import Confirmation
from geomint.compare.reference import reference_solution
from geomint.compare.reference_record import Reference, name_of, stored
from geomint.problems.testproblems import neumann
from tests.compare.circle import CIRCLE, EAST, IN_TAU, PENDULUM, REST, REST_AT_100, on_circle
from tests.problems import morse

GOOD = Confirmation("other", 3.0, 1e-13, 2e-14)
BAD = Confirmation("other", 3.0, 1e-13, 4.5e-3)


@gi.field
def driven(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -params[0] * gi.sin(y[0]) + 0.1 * gi.cos(t)


@pytest.fixture
def forget(monkeypatch):
    """Neither take references from disk nor leave any there."""
    monkeypatch.setattr(reference, "stored", lambda name: None)
    monkeypatch.setattr(Reference, "store", lambda self, name: None)


@pytest.fixture
def planted(monkeypatch, tmp_path):
    """Return a function that makes every double-double solution of the circle wrong.

    References are in a folder of their own.
    """
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))

    def plant(wrong):
        monkeypatch.setattr(
            reference, "integrate_extended", lambda p, y0, end, h: wrong(on_circle(end), end, h)
        )

    plant(lambda y, end, h: y)
    return plant


# To the last digit


@pytest.mark.usefixtures("forget")
def test_circle_to_the_last_bit():
    found = reference_solution(IN_TAU, EAST, 100.0)
    with mp.workdps(50):
        truth = [float(mp.cos(100)), float(mp.sin(100))]
        clock = float(200 + mp.sin(100))
    np.testing.assert_array_equal(found.y, truth)
    assert found.physical_end == clock
    assert found.error < 1e-25


@pytest.mark.usefixtures("forget")
def test_a_pendulum_that_is_driven():
    problem = gi.Problem("pendulum", (("x", 2),), params=[1.3], field=driven)
    found = reference_solution(problem, np.array([0.5, 0.25]), 1.0)
    with mp.workdps(24):
        k, tenth = mp.mpf(1.3), mp.mpf(0.1)  # as float64 has them
        solution = mp.odefun(
            lambda t, y: [y[1], -k * mp.sin(y[0]) + tenth * mp.cos(t)], 0, [0.5, 0.25]
        )
        truth = np.array([float(v) for v in solution(1)])
    np.testing.assert_allclose(found.y, truth, rtol=2**-52, atol=0)


@pytest.mark.usefixtures("forget")
def test_exponential_forces_to_the_last_bit():
    """Morse's oscillator against its closed solution, in 50 digits."""
    problem = morse.problem(1.5, 0.75)  # products of parameters are exact
    found = reference_solution(problem, morse.INITIAL, 20.0)
    with mp.workdps(50):
        depth, a = (mp.mpf(x) for x in problem.params)
        q, p = (mp.mpf(x) for x in morse.INITIAL)
        u = mp.exp(a * q)
        h = p**2 / 2 + depth * (1 - 1 / u) ** 2
        omega, size = a * mp.sqrt(2 * (depth - h)), mp.sqrt(depth * h)
        angle = 20 * omega + mp.atan2(-a * u * p * (depth - h) / omega, u * (depth - h) - depth)
        u = (depth + size * mp.cos(angle)) / (depth - h)
        truth = [mp.log(u) / a, -omega * size * mp.sin(angle) / (depth - h) / (a * u)]
    np.testing.assert_allclose(found.y, [float(x) for x in truth], rtol=2**-52, atol=0)


def test_a_step_that_is_too_long_is_made_shorter(planted):
    tried = []

    def wrong(y, end, h):
        tried.append(h)
        if len(tried) < 4:
            raise gi.ConvergenceError(0.0, 0, 1.0, 1, "as a step that is too long")
        return y

    planted(wrong)
    found = reference_solution(CIRCLE, EAST, 3.0)
    assert found.steps == (tried[-2], tried[-1]) == (2.0 * tried[-1], tried[-1])
    assert tried[0] == 16.0 * tried[-1]


# On disk


def test_a_reference_and_its_confirmation_are_kept(planted, monkeypatch, tmp_path):
    """What is damaged or has no confirmation is made again."""
    first = reference_solution(CIRCLE, EAST, 3.0)
    assert first.agrees
    monkeypatch.setattr(reference, "confirm", lambda *a: pytest.fail("confirmed again"))
    planted(lambda y, end, h: pytest.fail("integrated again"))
    second = reference_solution(CIRCLE, EAST, 3.0)
    np.testing.assert_array_equal(first.y, second.y)
    assert (second.confirmation, second.steps) == (first.confirmation, first.steps)
    (file,) = tmp_path.rglob("*.json")
    assert file.name == name_of(CIRCLE, EAST, 3.0)
    dataclasses.replace(first, confirmation=None).store(file.name)
    assert stored(file.name).known == np.inf
    content = file.read_bytes()
    for damaged in (b"{not json", content[:-1], content[:40] + b"9" + content[41:], b""):
        file.write_bytes(damaged)
        assert stored(file.name) is None


def test_names_depend_on_everything():
    def make(**more):
        return gi.Problem("circle", (("x", 2),), **{"field": CIRCLE.field, **more})

    two = gi.Problem("circle", (("x", 1), ("y", 1)), field=CIRCLE.field)
    names = {
        name_of(make(), EAST, 1.0), name_of(make(), EAST, 2.0),
        name_of(make(), np.array([1.0, 1e-16]), 1.0), name_of(make(params=[1.0]), EAST, 1.0),
        name_of(make(field=driven), EAST, 1.0), name_of(two, EAST, 1.0), name_of(IN_TAU, EAST, 1.0),
    }  # fmt: skip
    assert len(names) == 7
    assert name_of(make(), EAST, 1.0) == name_of(CIRCLE, EAST, 1.0)


# What a reference may judge


def reference_with(error, second):
    return Reference(3.0, None, EAST, error, (0.2, 0.1), "gauss", second)


@pytest.mark.parametrize(
    ("error", "second", "known"),
    [
        (1e-25, GOOD, 1e-25),
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


@pytest.mark.parametrize(
    ("wrong", "told", "known"),
    [
        # Both steps are off by 0.0045 and say 0.
        (lambda y, end, h: y + EAST * 0.0045, ("double-double", "SciPy", "1e-05"), 0.0045),
        (lambda y, end, h: y + EAST * 0.14 * h, ("errs by",), None),
    ],
)
def test_a_reference_that_errs_is_refused(planted, wrong, told, known):
    """From disk too, in the same words."""
    planted(wrong)
    messages = []
    for _ in range(2):
        with pytest.raises(gi.UnknownReferenceError) as raised:
            reference_solution(CIRCLE, EAST, 3.0, judges=1e-5)
        messages.append(str(raised.value))
        planted(lambda y, end, h: pytest.fail("again"))
    assert messages[0] == messages[1]
    assert [word for word in told if word not in messages[0]] == []
    if known is not None:
        assert raised.value.known == pytest.approx(known, rel=0.05)


def test_by_default_a_reference_judges_what_float64_can_show(planted):
    planted(lambda y, end, h: y + np.array([1e-13 * h, 0.0]))
    with pytest.raises(gi.UnknownReferenceError):
        reference_solution(CIRCLE, EAST, 3.0)
    assert reference_solution(CIRCLE, EAST, 3.0, judges=1e-9).known < 1e-13


@pytest.mark.nightly
@pytest.mark.usefixtures("forget")
def test_a_reference_from_rest_is_right_or_refused():
    """Whatever Gauss does there: a piece that is exactly 0 has led its first step astray before."""
    problem, y0 = neumann.problem(), neumann.initial() * [1, 1, 1, 0, 0, 0]
    ends = [(problem, y0, end, None) for end in (1.0, 30.0, 300.0)]
    for problem, y0, end, right in [(PENDULUM, REST, 100.0, REST_AT_100), *ends]:
        try:
            found = reference_solution(problem, y0, end, judges=1e-5)
        except gi.UnknownReferenceError:
            continue
        assert found.agrees
        assert found.confirmation.own_end == end
        if right is not None:
            np.testing.assert_allclose(found.y, right, atol=1e-8)


def test_no_field_no_reference():
    action = gi.GroupAction(CIRCLE.field, gi.so3(1))
    problem = gi.Problem("action only", (("x", 3),), action=action)
    for find in (reference_solution, reference.confirm):
        with pytest.raises(gi.FormError, match="no field"):
            find(problem, np.ones(3), 1.0, *[on_circle] * (find is reference.confirm))
