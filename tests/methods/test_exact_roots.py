"""Roots along pieces: every one, none else, whatever is looked at together."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from geomint.run.exact.polynomials import points_of
from geomint.run.exact.roots import Found, Roots

Function = Callable[[np.ndarray], np.ndarray]


def roots_of(f: Function, edges: np.ndarray, cuts: tuple[int, ...] = ()) -> Found:
    """Look between edges, some pieces after the other."""
    roots = Roots(float(np.abs(edges[1] - edges[0])))
    times, directions = [np.zeros(0)], [np.zeros(0)]
    for part in zip((0, *cuts), (*cuts, len(edges) - 1), strict=True):
        some = edges[part[0] : part[1] + 1]
        points = points_of(some[:-1], some[1:])
        found = roots.within(some, f(points.reshape(-1)).reshape(points.shape), f)
        times.append(found.times)
        directions.append(found.directions)
        if found.failure is not None:
            break
    return Found(np.concatenate(times), np.concatenate(directions), found.failure)


def waves(rng: np.random.Generator, fastest: float) -> Function:
    """A sum of waves of random frequencies."""
    w, size, phase = rng.uniform(0.1, fastest, 4), rng.normal(size=4), rng.uniform(0.0, 7.0, 4)
    level = 0.5 * rng.normal()
    return lambda t: np.sin(np.multiply.outer(t, w) + phase) @ size + level


@pytest.mark.parametrize("sign", [1, -1], ids=["forwards", "backwards"])
@pytest.mark.parametrize("fastest", [1.0, 6.0, 40.0])
def test_against_samples(fastest: float, sign: int) -> None:
    """Every change of sign of 40 000 samples is a root, and there are no others."""
    count = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        f, edges = waves(rng, fastest), sign * np.linspace(0.0, rng.uniform(10.0, 30.0), 31)
        found = roots_of(f, edges)
        assert found.failure is None
        samples = np.linspace(0.0, edges[-1], 40_001)
        values = f(samples)
        (changes,) = np.nonzero(values[1:] * values[:-1] < 0.0)
        assert len(found.times) == len(changes)
        assert (sign * samples[changes] <= sign * found.times).all()
        assert (sign * found.times <= sign * samples[changes + 1]).all()
        np.testing.assert_array_equal(found.directions, np.sign(values[changes + 1]))
        assert np.abs(f(found.times)).max(initial=0.0) < 1e-13 * fastest
        count += len(changes)
    assert count > 100


def test_what_is_looked_at_together_does_not_matter() -> None:
    """Not even to the last bit."""
    for seed in range(20):
        g, edges = waves(np.random.default_rng(seed), 3.0), np.arange(41.0)

        def f(t: np.ndarray, g: Function = g) -> np.ndarray:
            return np.array(
                [g(np.array([x]))[0] for x in t]
            )  # numpy's own bits depend on the place

        known = roots_of(f, edges)
        for cuts in ((1,), (1, 2, 3, 20), tuple(range(1, 40))):
            found = roots_of(f, edges, cuts)
            assert found.times.tobytes() == known.times.tobytes()
            assert found.directions.tobytes() == known.directions.tobytes()


@pytest.mark.parametrize(
    ("f", "expected"),
    [
        (lambda t: t - 3.0, [3.0]),  # where two pieces meet
        (lambda t: t, []),  # where it begins
        (lambda t: (t - 3.0) ** 2, []),
        (lambda t: (t - 3.3) ** 2 - 1e-8, [3.3 - 1e-4, 3.3 + 1e-4]),
        (lambda t: (t - 3.3) ** 3, [3.3]),
        (lambda t: 1e-200 * (t - 3.0) ** 5, [3.0]),
        (lambda t: -1e290 * (t - 2.71) ** 9, [2.71]),
        (lambda t: (t - 1.0) ** 2 * (t - 6.1) ** 5, [6.1]),
        (lambda t: np.where(t < 2.2, t - 2.2, np.where(t > 4.4, t - 4.4, 0.0)), [4.4]),
        (lambda t: 1.0 - 1e-10 - np.cos(t - 3.3), [3.3 - 2e-10**0.5, 3.3 + 2e-10**0.5]),
        (lambda t: (t - 4.0) * (t - 4.0 - 1e-3) * (t - 4.0 + 1e-3), [3.999, 4.0, 4.001]),
        (lambda t: 0.0 * t, []),
        (lambda t: 0.0 * t + 1e-300, []),
        (lambda t: 1e-300 * np.sin(t - 2.5), [2.5, 2.5 + math.pi]),
        (lambda t: 1e300 * np.sin(t - 2.5), [2.5, 2.5 + math.pi]),
        (lambda t: 1.0 + 1e-6 + np.sin(t), []),
        (lambda t: np.sin(20.0 * t), np.arange(1, 51) * math.pi / 20.0),
        (lambda t: t - 8.0, []),  # where it ends
    ],
)
def test_special_roots(f: Function, expected: list[float]) -> None:
    """At edges, touching ones, several close together, all sizes."""
    for count in (8, 5, 1):
        found = roots_of(f, np.linspace(0.0, 8.0, count + 1))
        assert found.failure is None
        assert len(found.times) == len(expected)
        atol = 1e-9 if len(expected) == 2 else 1e-13
        np.testing.assert_allclose(found.times, expected, rtol=0, atol=atol)


@pytest.mark.parametrize(
    ("f", "said"),
    [
        (lambda t: np.where(t > 5.3, 1.0, -1.0), "may jump"),
        (lambda t: np.where(t > 5.3, np.nan, 1.0), "not a finite number"),
        (lambda t: np.where(t > 5.3, np.inf, 1.0), "not a finite number"),
        (lambda t: np.where(t > 5.3, np.sin(1e5 * t), 1.0), "more than 64 times"),
    ],
)
def test_what_cannot_be_told(f: Function, said: str) -> None:
    """The first piece of which nothing can be told; what was before it is known."""
    found = roots_of(lambda t: f(t) * (t - 2.25), np.linspace(0.0, 8.0, 9))
    assert found.failure is not None
    assert found.failure.piece == 5
    assert said in found.failure.why
    np.testing.assert_allclose(found.times, [2.25], rtol=0, atol=1e-15)


@pytest.mark.parametrize("late", [1e6, 1e9, 1e12])
def test_late_times(late: float) -> None:
    """Where the spacing of times is coarse, roots are within it, and as many as there are."""
    found = roots_of(lambda t: np.sin(t - late), late + 1.0 + 1.5 * np.arange(41))
    assert found.failure is None
    known = late + math.pi * np.arange(1, 20)
    assert len(found.times) == len(known)
    np.testing.assert_allclose(found.times, known, rtol=0, atol=4.0 * math.ulp(late))


def test_touching_and_fast() -> None:
    """Pairs of roots next to each other, under waves that a polynomial shows only roughly."""
    rng = np.random.default_rng(5)
    for _ in range(300):
        w, c, near = rng.uniform(1.0, 14.0), rng.uniform(0.0, 6.3), 10.0 ** rng.uniform(-9.0, -1.0)
        for eps in (near, -near):

            def f(t: np.ndarray, w: float = w, c: float = c, eps: float = eps) -> np.ndarray:
                return (1.0 - np.cos(w * t - c) - eps) * (1.5 + np.sin(2.0 * w * t + 1.0))

            found = roots_of(f, np.linspace(0.0, 8.0, 9))
            assert found.failure is None
            turn = math.acos(1.0 - near) * (eps > 0.0)
            known = np.add.outer(2.0 * math.pi * np.arange(-3, 40) + c, [-turn, turn]).ravel() / w
            known = known[(known > 0.0) & (known < 8.0)] if eps > 0.0 else np.zeros(0)
            assert len(found.times) == len(known)
            np.testing.assert_allclose(found.times, known, rtol=0, atol=1e-6)


@pytest.mark.parametrize(
    ("middle", "depth"),
    [(3.595045920827844, 1.134625651436885), (4.405186754061489, 1.0816706690224909)],
)
def test_a_pulse_between_two_points(middle: float, depth: float) -> None:
    """That coefficients do not decay is what tells of it."""
    half = 0.07 * math.log(depth) ** 0.5
    found = roots_of(
        lambda t: 1.0 - depth * np.exp(-(((t - middle) / 0.07) ** 2)), np.linspace(0.0, 8.0, 9)
    )
    np.testing.assert_allclose(found.times, [middle - half, middle + half], rtol=0, atol=1e-9)
