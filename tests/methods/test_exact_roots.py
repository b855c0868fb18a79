"""Roots along exact motions: every one, none else, whatever is looked at together.

The state is the function itself, of time: its roots are the events of its only row.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

import geomint as gi
from tests.rows import examples

Function = Callable[[np.ndarray], np.ndarray]
EIGHT = tuple(8.0 / count for count in (8, 1))  # pieces of what is looked at until 8


@gi.field
def passing(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = 1.0 + 0.0 * y[0]


class Curve:
    """A motion whose only row is a function of time, to be looked at in pieces."""

    def __init__(self, f: Function, piece: float) -> None:
        self.f, self.mean_frequencies = f, np.array([0.5 * math.pi / piece])

    def __call__(self, t: Any) -> np.ndarray:
        return np.asarray(self.f(np.asarray(t, dtype=float)))[..., None]


def roots_of(f: Function, end: float, piece: float = 1.0, begin: float = 0.0, **more: Any) -> Any:
    """The roots of a function between two times, which comes along in pieces of no more than 1."""

    def shifted(t: np.ndarray) -> np.ndarray:
        return f(begin + t)

    problem = gi.Problem(
        "curve", (("x", 1),), field=passing, make_exact=lambda y0: Curve(shifted, piece)
    )
    y0 = [float(f(np.array([begin]))[0])]
    run = {"t0": begin, "t_end": end, "method": "exact", "events": "x", **more}
    return gi.solve(problem, y0, **run).events["x"]


@examples(5)
@given(
    st.sampled_from([1.0, 6.0, 40.0]), st.sampled_from([1, -1]), st.floats(10.0, 30.0), st.data()
)
def test_against_samples(fastest: float, sign: int, end: float, data: Any) -> None:
    """Every change of sign of 40 000 samples of some waves is a root, and there are no others."""
    rng = np.random.default_rng(data.draw(st.integers(0, 10**6)))
    w, size, phase = rng.uniform(0.1, fastest, 4), rng.normal(size=4), rng.uniform(0.0, 7.0, 4)
    level = 0.5 * rng.normal()

    def waves(t: np.ndarray) -> np.ndarray:
        return np.sin(np.multiply.outer(t, w) + phase) @ size + level

    found = roots_of(waves, sign * end, end / 30)
    samples = np.linspace(0.0, sign * end, 40_001)
    values = waves(samples)
    (changes,) = np.nonzero(values[1:] * values[:-1] < 0.0)
    assert len(found.t) == len(changes)
    assert (sign * samples[changes] <= sign * found.t).all()
    assert (sign * found.t <= sign * samples[changes + 1]).all()
    np.testing.assert_array_equal(found.directions, np.sign(values[changes + 1]))
    assert np.abs(waves(found.t)).max(initial=0.0) < 1e-13 * fastest


@pytest.mark.parametrize(
    ("f", "expected"),
    [
        (lambda t: t - 3.0, [3.0]),  # where two pieces meet
        (lambda t: t, []),  # where it begins
        (lambda t: t - 8.0, []),  # where it ends
        (lambda t: (t - 3.0) ** 2, []),
        (lambda t: (t - 3.3) ** 2 - 1e-8, [3.3 - 1e-4, 3.3 + 1e-4]),
        (lambda t: 1e-200 * (t - 3.0) ** 5, [3.0]),
        (lambda t: -1e290 * (t - 2.71) ** 9, [2.71]),
        (lambda t: (t - 1.0) ** 2 * (t - 6.1) ** 5, [6.1]),
        (lambda t: np.where(t < 2.2, t - 2.2, np.where(t > 4.4, t - 4.4, 0.0)), [4.4]),
        (lambda t: 1.0 - 1e-10 - np.cos(t - 3.3), [3.3 - 2e-10**0.5, 3.3 + 2e-10**0.5]),
        (lambda t: (t - 4.0) * (t - 4.0 - 1e-3) * (t - 4.0 + 1e-3), [3.999, 4.0, 4.001]),
        (lambda t: 0.0 * t, []),
        (lambda t: 0.0 * t + 1e-300, []),
        (lambda t: 1e300 * np.sin(t - 2.5), [2.5, 2.5 + math.pi]),
        (lambda t: 1.0 + 1e-6 + np.sin(t), []),
        (lambda t: np.sin(20.0 * t), np.arange(1, 51) * math.pi / 20.0),
    ],
)
def test_special_roots(f: Function, expected: list[float]) -> None:
    """At edges, touching ones, several close together, all sizes."""
    for piece in EIGHT:
        found = roots_of(f, 8.0, piece)
        atol = 1e-9 if len(expected) == 2 else 1e-13
        np.testing.assert_allclose(found.t, expected, rtol=0, atol=atol)


@pytest.mark.parametrize(
    ("f", "said"),
    [
        (lambda t: np.where(t > 5.3, 1.0, -1.0), "may jump"),
        (lambda t: np.where(t > 5.3, np.sin(1e5 * t), 1.0), "more than 64 times"),
    ],
)
def test_what_cannot_be_told(f: Function, said: str) -> None:
    """The first piece of which nothing can be told; what was before it is known."""
    with pytest.raises(gi.EventError, match=said) as caught:
        roots_of(lambda t: f(t) * (t - 2.25), 8.0)
    assert 5.0 <= caught.value.t <= 6.0
    np.testing.assert_allclose(caught.value.partial.t_events[0], [2.25], rtol=0, atol=1e-15)


@pytest.mark.parametrize("late", [1e6, 1e12])
def test_late_times(late: float) -> None:
    """Where the spacing of times is coarse, roots are within it, and as many as there are."""
    found = roots_of(lambda t: np.sin(t - late), late + 61.0, begin=late + 1.0)
    known = late + math.pi * np.arange(1, 20)
    np.testing.assert_allclose(found.t, known, rtol=0, atol=4.0 * math.ulp(late))


@given(st.floats(1.0, 14.0), st.floats(0.0, 6.3), st.floats(-9.0, -1.0), st.sampled_from([1, -1]))
def test_touching_and_fast(w: float, c: float, power: float, side: int) -> None:
    """Pairs of roots next to each other, under waves that a polynomial shows only roughly."""
    near = 10.0**power

    def f(t: np.ndarray) -> np.ndarray:
        return (1.0 - np.cos(w * t - c) - side * near) * (1.5 + np.sin(2.0 * w * t + 1.0))

    found = roots_of(f, 8.0)
    turn = math.acos(1.0 - near)
    known = np.add.outer(2.0 * math.pi * np.arange(-3, 40) + c, [-turn, turn]).ravel() / w
    known = known[(known > 0.0) & (known < 8.0)] if side > 0 else np.zeros(0)
    np.testing.assert_allclose(found.t, known, rtol=0, atol=1e-6)


@pytest.mark.parametrize(
    ("middle", "depth"),
    [(3.595045920827844, 1.134625651436885), (4.405186754061489, 1.0816706690224909)],
)
def test_a_pulse_between_two_points(middle: float, depth: float) -> None:
    """That coefficients do not decay is what tells of it."""
    half = 0.07 * math.log(depth) ** 0.5
    found = roots_of(lambda t: 1.0 - depth * np.exp(-(((t - middle) / 0.07) ** 2)), 8.0)
    np.testing.assert_allclose(found.t, [middle - half, middle + half], rtol=0, atol=1e-9)
