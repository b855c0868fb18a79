"""The exact motion of the classical Veselova problem, n = 3, at any f₁."""

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from tests.chaplygin.support import random_body


@pytest.mark.parametrize(("f1", "equal"), [(0.0, 0), (0.4, 2), (-1.3, 3), (3.0, 0), (-0.4, 0)])
def test_against_integration(f1, equal):
    """Linear in the angles of the ball's torus, after the ball's change of time."""
    for seed in range(2):
        a = random_body(3, seed).a.copy()
        a[:equal] = a[0]
        problem = ch.Veselova(a, 1.3).classical(f1)
        y = problem.random_state(seed)
        exact = problem.exact(y)
        np.testing.assert_allclose(exact(0.0), y, rtol=0, atol=1e-14 * exact.condition)
        turn = 1.0 / np.max(np.abs(exact.mean_frequencies))
        run = gi.solve(
            problem, y, t_end=-60 * turn, step=0.02 * turn, method="dop853", save_every=500,
            progress=False,
        )  # fmt: skip
        allowed = 1e-13 * (1.0 + exact.condition)  # the integrator's: 2e-13
        np.testing.assert_allclose(exact(run.t), run.y, rtol=0, atol=allowed)
        far = exact(np.array([1e9, -1e6]))
        for name in ("energy", "K", "norm", "constraint"):
            expected = gi.value(problem, name, y)
            for z in far:
                assert gi.value(problem, name, z) == pytest.approx(expected, rel=1e-11, abs=1e-11)
        middle = problem.canonical(exact(3.0))
        again = problem.exact(middle)(4.0)
        np.testing.assert_allclose(again, exact(7.0), rtol=0, atol=1e-12 * exact.condition)


def test_without_area_constant_it_is_the_reduced_problem():
    body = random_body(3, 1)
    vectors, reduced = body.classical(), body.reduced()
    y = vectors.random_state(3)
    one, other = vectors.exact(y), reduced.exact(ch.converted(y, vectors, reduced))
    for t in (0.7, -33.0, 1e4):
        expected = ch.converted(other(t), reduced, vectors)
        np.testing.assert_allclose(one(t), expected, rtol=0, atol=1e-11)
    np.testing.assert_allclose(
        np.sort(np.abs(one.mean_frequencies)), np.sort(np.abs(other.mean_frequencies)), rtol=1e-12
    )


def test_large_constants():
    """f₁ ≫ |k⃗|: right up to the estimate, or refused."""
    for f1 in (10.0, 100.0):
        problem = ch.Veselova([0.8, 1.1, 1.5], 4.0).classical(f1)
        y = problem.random_state(3)
        exact = problem.exact(y)
        turn = 1.0 / np.max(np.abs(exact.mean_frequencies))
        run = gi.solve(
            problem, y, t_end=30 * turn, step=0.02 * turn, method="dop853", progress=False
        )
        off = np.max(np.abs(exact(run.t[-1]) - run.y[-1])[3:])
        assert off < float(exact.phase_error(exact.tau(run.t[-1])))
    problem = ch.Veselova([0.8, 1.1, 1.5], 4.0).classical(1e4)
    with pytest.raises(gi.DomainError):
        problem.exact(problem.random_state(3))


def test_parallel_vectors_are_refused():
    problem = random_body(3, 1).classical(0.5)
    with pytest.raises(gi.DomainError, match="parallel"):
        problem.exact([0.0, 0.0, 0.5, 0.0, 0.0, 1.0])
