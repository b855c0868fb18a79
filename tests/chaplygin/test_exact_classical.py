"""Exact motions in vectors, n = 3: the ball at any area constant and Veselova's problem at any f₁."""

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from tests.chaplygin.exact_support import turned
from tests.chaplygin.support import random_body, random_special


def problem_of(f1, seed, equal=0):
    """Return the ball, or the body at f₁ with so many equal a_i."""
    if f1 is None:
        return ch.ChaplyginSphere(inertia=random_special(3, seed)).classical()
    a = random_body(3, seed).a.copy()
    a[:equal] = a[0]
    return ch.Veselova(a, 1.3).classical(f1)


@pytest.mark.parametrize(
    ("f1", "equal"), [(None, 0), (0.0, 0), (0.4, 2), (-1.3, 3), (3.0, 0), (-0.4, 0)]
)
@pytest.mark.parametrize("seed", [1, pytest.param(0, marks=pytest.mark.nightly)])
def test_it_is_the_motion(f1, equal, seed):
    """Against integration in physical time, both ways; as a flow; what is kept, at t = 10⁹."""
    problem = problem_of(f1, seed, equal)
    y = problem.random_state(seed)
    exact = problem.exact(y)
    np.testing.assert_allclose(exact(0.0), y, rtol=0, atol=1e-14 * (1.0 + exact.condition))
    turn = 1.0 / np.max(np.abs(exact.mean_frequencies))
    allowed = 1e-13 * (1.0 + exact.condition)  # the integrator's: 2e-13
    for t in (30 * turn, -60 * turn):
        run = gi.solve(problem, y, t_end=t, step=0.02 * turn, method="dop853")
        np.testing.assert_allclose(exact(t), run.y[-1], rtol=0, atol=allowed)
    far = exact(np.array([1e9, -1e6]))
    for name in (*problem.invariants, *problem.constraints):
        expected = gi.value(problem, name, y)
        for z in far:
            assert gi.value(problem, name, z) == pytest.approx(expected, rel=1e-11, abs=1e-11)
    middle = problem.canonical(exact(3.0))
    again = problem.exact(middle)(4.0)
    np.testing.assert_allclose(again, exact(7.0), rtol=0, atol=1e-12 * (1.0 + exact.condition))
    moved = turned(exact.angles(middle) - exact.start - exact.frequencies * exact.tau(3.0))
    np.testing.assert_allclose(moved, 0, atol=1e-11)


def test_all_but_parallel_vectors_are_refused():
    problem = ch.ChaplyginSphere(inertia=random_special(3, 1)).classical()
    gamma = np.array([0.48, 0.6, 0.64])
    for apart in (1e-6, 1e-8, 0.0):
        with pytest.raises(gi.DomainError, match="parallel"):
            problem.exact(np.r_[3 * gamma + apart * np.cross(gamma, [0, 0, 1]), gamma])
    with pytest.raises(gi.DomainError, match="parallel"):
        problem_of(0.5, 1).exact([0.0, 0.0, 0.5, 0.0, 0.0, 1.0])


def test_attitude_and_contact_point():
    """Against the reconstruction that is integrated, (k, γ, g, r)."""
    sphere, rho = ch.ChaplyginSphere(inertia=random_special(3, 1)), 0.7
    contact, classical = sphere.contact(rho=rho), sphere.classical()
    y = contact.random_state(4)
    start = ch.converted(y, contact, classical)
    path = ch.ContactPath(classical.exact(start), rho, y[6:15], y[15:])
    np.testing.assert_allclose(path.attitude(0.0), y[6:15].reshape(3, 3), atol=1e-13)
    np.testing.assert_allclose(path.contact(0.0), y[15:], atol=1e-14)
    turn = 1.0 / np.max(np.abs(path.exact.mean_frequencies))
    end = 40 * turn
    run = gi.solve(
        contact, y, t_end=end, step=0.02 * turn, method="dop853", save_every=50, progress=False
    )
    np.testing.assert_allclose(
        path.attitude(run.t).reshape(-1, 9), run.y[:, 6:15], rtol=0, atol=1e-11
    )
    np.testing.assert_allclose(path.contact(run.t), run.y[:, 15:], rtol=0, atol=1e-12 * end)
    vectors = np.array([ch.converted(z, contact, classical) for z in run.y[:20]])
    found = ch.attitude(vectors[:, :3], vectors[:, 3:], y[6:15])
    np.testing.assert_allclose(found.reshape(-1, 9), run.y[:20, 6:15], rtol=0, atol=1e-11)
    far = path.contact(1e7) - path.contact(0.0)
    np.testing.assert_allclose(far / 1e7, path.drift, atol=1e-5)


def test_refusals():
    sphere = ch.ChaplyginSphere(inertia=random_special(3, 1))
    reduced, classical = sphere.reduced(), sphere.classical()
    exact = classical.exact(classical.random_state(4))
    for call, text in (
        (lambda: ch.attitude([0.0, 0.0, 2.0], [0.0, 0.0, 1.0]), "parallel"),
        (lambda: ch.attitude([np.nan, 0.0, 0.0], [0.0, 0.0, 1.0]), "finite vectors"),
        (lambda: ch.attitude([1.0, 0.0, 0.0], [0.0, 0.0, 0.0]), "not zero"),
        (lambda: ch.ContactPath(reduced.exact(reduced.random_state(1)), 1.0), r"classical\(\)"),
        (lambda: ch.ContactPath(exact, 0.7, np.eye(3)), "E_3"),
    ):
        with pytest.raises(gi.DomainError, match=text):
            call()
