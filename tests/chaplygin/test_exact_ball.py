"""The exact motion of the ball in R³ at any area constant, its attitude and contact point."""

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from tests.chaplygin.exact_support import turned
from tests.chaplygin.support import random_special


@pytest.mark.parametrize("seed", range(3))
def test_the_ball_at_any_area_constant(seed):
    """Against integration in physical time, both ways; energy, K and area at t = 10⁹."""
    inertia = random_special(3, seed)
    problem = ch.ChaplyginSphere(inertia=inertia).classical()
    y = problem.random_state(seed)
    exact = problem.exact(y)
    np.testing.assert_allclose(exact(0.0), y, rtol=0, atol=1e-13 * exact.condition)
    turn = 1.0 / np.max(np.abs(exact.mean_frequencies))
    for t in (30 * turn, -7 * turn):
        run = gi.solve(problem, y, t_end=t, step=0.02 * turn, method="dop853", progress=False)
        np.testing.assert_allclose(exact(t), run.y[-1], rtol=0, atol=1e-14 * exact.condition)
    far = exact(1e9)
    for name in problem.invariants:
        expected = gi.value(problem, name, y)
        assert gi.value(problem, name, far) == pytest.approx(expected, rel=1e-11, abs=1e-12)
    middle = problem.canonical(exact(3.0))
    np.testing.assert_allclose(
        problem.exact(middle)(4.0), exact(7.0), rtol=0, atol=1e-12 * exact.condition
    )
    np.testing.assert_allclose(
        turned(exact.angles(middle) - exact.angles(exact(3.0))), 0, atol=1e-11
    )


def test_momenta_of_any_size():
    problem = ch.ChaplyginSphere(inertia=random_special(3, 1)).classical()
    y = problem.random_state(1)
    exact = problem.exact(y)
    for unit in (1e-100, 1e100):
        other = problem.exact(np.concatenate([unit * y[:3], y[3:]]))(3.0 / unit)
        np.testing.assert_allclose(other[3:], exact(3.0)[3:], atol=1e-14 * exact.condition)


def test_all_but_parallel_vectors_are_refused():
    problem = ch.ChaplyginSphere(inertia=random_special(3, 1)).classical()
    gamma = np.array([0.48, 0.6, 0.64])
    for apart in (1e-6, 1e-8, 0.0):
        with pytest.raises(gi.DomainError, match="parallel"):
            problem.exact(np.r_[3 * gamma + apart * np.cross(gamma, [0, 0, 1]), gamma])


@pytest.mark.parametrize("momentum", [True, False])
def test_attitude_and_contact_point(momentum):
    """Against the reconstruction that is integrated, (k, γ, g, r), with and without area constant."""
    sphere, rho = ch.ChaplyginSphere(inertia=random_special(3, 1)), 0.7
    contact, classical = sphere.contact(rho=rho), sphere.classical()
    y = contact.random_state(4)
    if not momentum:
        g = y[6:15].reshape(3, 3)
        y = contact.state(g=g, p=np.cross(g[2], [0.3, -0.8, 0.5]), r=y[15:])
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
