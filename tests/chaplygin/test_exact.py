"""The exact flow: against integrations, itself, and what it must keep at any time."""

import numpy as np
import pytest
from support import DIMENSIONS, random_body, random_special

import chaplygin as ch
import geomint as gi
from chaplygin.exact.branch_points import separation_of

SEEDS = range(2)


def problems(n, seed=0):
    """Sphere and body, in τ and in t, of random parameters that are apart."""
    inertia = random_special(n, seed)
    sphere = ch.ChaplyginSphere(inertia=inertia)
    body = ch.Veselova(random_body(n, seed).a, inertia.D)
    return [sphere.hamiltonized(), sphere.reduced(), body.hamiltonized(), body.reduced()]


def turned(x):
    """Angles modulo 2π, in [−π, π]."""
    return x - 2 * np.pi * np.rint(x / (2 * np.pi))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("n", DIMENSIONS)
def test_it_begins_at_the_state_and_has_its_velocity(n, seed):
    for problem in problems(n, seed):
        y = problem.random_state(seed)
        exact, size = problem.exact(y), np.max(np.abs(y))
        allowed = 3e-14 * exact.condition * size
        np.testing.assert_allclose(exact.at_tau(0.0), y, rtol=0, atol=allowed)
        h = 1e-3 / np.max(np.abs(exact.frequencies))
        ahead = exact.at_tau(h * np.arange(-4, 5))
        weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
        rate = weights @ ahead / h
        expected = gi.derivative(problem, y)
        if problem.time == "t":
            u = y[:n] @ (y[:n] / np.array(problem.parameters["a"]))
            expected = expected * problem.parameters["D"] * np.sqrt(u)
        allowed = 1e-9 * np.max(np.abs(expected)) * exact.condition
        np.testing.assert_allclose(rate, expected, rtol=0, atol=allowed)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("n", DIMENSIONS)
def test_it_is_a_flow(n, seed):
    """exact(t₁ + t₂) = exact(exact(t₁), t₂), forwards and backwards."""
    for problem in problems(n, seed)[::2]:
        y = problem.random_state(seed)
        exact = problem.exact(y)
        period = 2 * np.pi / np.max(np.abs(exact.frequencies))
        first, second = 3.7 * period, -11.3 * period
        middle = problem.canonical(exact.at_tau(first))
        again = problem.exact(middle).at_tau(second)
        allowed = 3e-13 * exact.condition * np.max(np.abs(y))
        np.testing.assert_allclose(again, exact.at_tau(first + second), rtol=0, atol=allowed)


@pytest.mark.parametrize("n", DIMENSIONS)
def test_integrals_and_constraints_at_large_times(n):
    for problem in problems(n)[::2]:
        y = problem.random_state(1)
        for tau in (1e3, 1e9, -1e12):
            z = problem.exact(y).at_tau(tau)
            for name in problem.invariants:
                expected = gi.value(problem, name, y)
                size = max(abs(expected), 1e-2 * np.max(np.abs(y)) ** 2)
                assert abs(gi.value(problem, name, z) - expected) < 1e-11 * size, name
            for name in problem.constraints:
                assert abs(gi.value(problem, name, z)) < 1e-12 * max(1.0, np.max(np.abs(y)))


@pytest.mark.parametrize("n", DIMENSIONS)
def test_both_problems_are_linear_in_the_same_angles(n):
    """Theorem CH-VP (iii): the angles of one along the other, with frequencies of their own."""
    inertia = random_special(n, 2)
    sphere = ch.ChaplyginSphere(inertia=inertia).hamiltonized()
    body = ch.Veselova(inertia.a, inertia.D).hamiltonized()
    y = sphere.random_state(3)
    one, other = sphere.exact(y), body.exact(y)
    np.testing.assert_allclose(turned(one.start - other.start), 0.0, atol=1e-12)
    assert np.max(np.abs(one.frequencies - other.frequencies)) > 1e-3
    for tau in 10.0 / np.max(np.abs(one.frequencies)) * np.array([0.3, 1.7, -4.1]):
        found = other.angles(one.at_tau(tau))
        expected = one.start + one.frequencies * tau
        allowed = 1e-12 * one.condition
        np.testing.assert_allclose(turned(found - expected), 0.0, atol=allowed)


@pytest.mark.slow
@pytest.mark.parametrize("n", [3, 4, 5])
def test_against_integration(n):
    """gauss-8 with small steps, at τ = 1, 10², 10⁴ of the fastest angle's turns."""
    for problem in problems(n)[::2]:
        y = problem.random_state(5)
        exact = problem.exact(y)
        turn = 1.0 / np.max(np.abs(exact.frequencies))
        for turns, allowed in ((1.0, 1e-13), (1e2, 1e-12), (1e4, 1e-10)):
            tau = turns * turn
            run = gi.solve(
                problem, y, tau_end=tau, step=0.05 * turn, method="gauss-8", progress=False
            )
            np.testing.assert_allclose(
                exact.at_tau(tau), run.y[-1], rtol=0, atol=allowed * exact.condition
            )


@pytest.mark.parametrize("n", DIMENSIONS)
def test_the_error_estimate(n):
    """A rounding of the state turns phases by no more than is estimated, and not by much less."""
    rng, worst = np.random.default_rng(n), 0.0
    for problem in problems(n)[::2]:
        y = problem.random_state(6)
        exact = problem.exact(y)
        tau = 1e6 / np.max(np.abs(exact.frequencies))
        for _ in range(3):
            near = problem.exact(problem.canonical(y * (1 + 2.0**-52 * rng.choice([-1, 1], 2 * n))))
            phase = np.max(np.abs(near.frequencies - exact.frequencies)) * tau
            worst = max(worst, phase / float(exact.phase_error(tau)))
    assert 1e-3 < worst < 4.0


@pytest.mark.parametrize("n", [2, 3])
def test_physical_time(n):
    """Against dt/dτ = D√U integrated with the motion, and back; the reduced problem by t alone."""
    flow, reduced, *_ = problems(n, 1)
    y = flow.random_state(2)
    exact = flow.exact(y)
    turn = 1.0 / np.max(np.abs(exact.frequencies))
    run = gi.solve(
        flow, y, tau_end=60 * turn, step=0.05 * turn, method="gauss-8", clock=True, save_every=100,
        progress=False,
    )  # fmt: skip
    end = abs(run.t[-1])
    np.testing.assert_allclose(exact.time(run.tau), run.t, rtol=0, atol=1e-13 * end)
    np.testing.assert_allclose(exact.tau(run.t), run.tau, rtol=0, atol=1e-13 * 60 * turn)
    np.testing.assert_allclose(exact(run.t), run.y, rtol=0, atol=1e-10)
    start = ch.converted(y, flow, reduced)
    states = reduced.exact(start)(run.t)
    for state, other in zip(states, run.y, strict=True):
        np.testing.assert_allclose(ch.converted(other, flow, reduced), state, atol=1e-10)
    far = exact.tau(np.array([1e9, -1e9]))
    np.testing.assert_allclose(exact.time(far), [1e9, -1e9], rtol=1e-15)


@pytest.mark.slow
def test_physical_time_in_four_dimensions():
    flow = problems(4, 1)[0]
    exact = flow.exact(flow.random_state(2))
    run = gi.solve(
        flow, exact.at_tau(0.0), tau_end=20.0, step=0.02, method="gauss-8", clock=True,
        progress=False,
    )  # fmt: skip
    assert float(exact.time(20.0)) == pytest.approx(run.t[-1], rel=1e-12)
    assert float(exact.tau(run.t[-1])) == pytest.approx(20.0, rel=1e-12)


@pytest.mark.parametrize("n", [3, 5])
def test_starts_on_coordinate_planes_and_at_turning_points(n):
    """γ_i = 0 with p̃_i ≠ 0: λ turns there, and the sign of γ_i is that with which it leaves."""
    problem = problems(n)[0]
    for i in range(n):
        for sign in (1.0, -1.0):
            y = problem.random_state(i)
            gamma, p = y[:n].copy(), y[n:].copy()
            gamma[i] = 0.0
            gamma /= np.linalg.norm(gamma)
            p[i] = sign * (1.0 + abs(p[i]))
            p -= (gamma @ p) * gamma
            p[i] = sign * (1.0 + abs(y[n + i]))
            state = problem.state(gamma=gamma, p_tilde=p)
            exact = problem.exact(state)
            np.testing.assert_allclose(exact.at_tau(0.0), state, atol=2e-13 * exact.condition)
            tau = 1e-4 / np.max(np.abs(exact.frequencies))
            moved = exact.at_tau(np.array([-tau, tau]))[:, i]
            rate = gi.derivative(problem, state)[i]
            np.testing.assert_allclose(moved, [-rate * tau, rate * tau], rtol=1e-3)


@pytest.mark.parametrize("seed", range(4))
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
        np.testing.assert_allclose(exact(t), run.y[-1], rtol=0, atol=1e-10 * exact.condition)
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
        path.attitude(run.t).reshape(-1, 9), run.y[:, 6:15], rtol=0, atol=1e-8
    )
    np.testing.assert_allclose(path.contact(run.t), run.y[:, 15:], rtol=0, atol=1e-8 * end)
    vectors = np.array([ch.converted(z, contact, classical) for z in run.y[:20]])
    found = ch.attitude(vectors[:, :3], vectors[:, 3:], y[6:15])
    np.testing.assert_allclose(found.reshape(-1, 9), run.y[:20, 6:15], rtol=0, atol=1e-8)
    far = path.contact(1e7) - path.contact(0.0)
    np.testing.assert_allclose(far / 1e7, path.drift, atol=1e-5)
    with pytest.raises(gi.DomainError, match="parallel"):
        ch.attitude([0.0, 0.0, 2.0], [0.0, 0.0, 1.0])
    with pytest.raises(gi.DomainError, match="E_3"):
        ch.ContactPath(path.exact, rho, np.eye(3))


def test_windings_give_the_signs():
    """n = 2: γ goes round the circle, and comes back after 4π of the angle, not 2π."""
    problem = ch.ChaplyginSphere(a=[0.8, 1.3], D=4.0).hamiltonized()
    y = problem.state(gamma=[0.6, 0.8], p_tilde=[-0.8, 0.6])
    exact = problem.exact(y)
    half = 2 * np.pi / abs(exact.frequencies[0])
    np.testing.assert_allclose(exact.at_tau(half), -y, atol=1e-14)
    np.testing.assert_allclose(exact.at_tau(2 * half), y, atol=1e-14)


@pytest.mark.parametrize("n", [2, 4])
def test_equal_parameters_are_great_circles(n):
    """The homogeneous ball and its body, in both times, forwards and backwards."""
    sphere, body = ch.ChaplyginSphere.homogeneous(n, 1.5, 2.0), ch.Veselova(np.full(n, 0.8), 1.7)
    for problem in (sphere.hamiltonized(), sphere.reduced(), body.hamiltonized(), body.reduced()):
        y = problem.random_state(n)
        exact = problem.exact(y)
        np.testing.assert_allclose(exact.at_tau(0.0), y, atol=1e-15)
        end = {"tau_end" if problem.time == "tau" else "t_end": -3.0}
        run = gi.solve(problem, y, step=0.01, method="gauss-4", progress=False, **end)
        got = exact.at_tau(-3.0) if problem.time == "tau" else exact(-3.0)
        np.testing.assert_allclose(got, run.y[-1], rtol=0, atol=1e-12)
        np.testing.assert_allclose(exact.tau(exact.time([1.0, 2.0])), [1.0, 2.0])
        assert exact.at_tau([1.0, 2.0]).shape == (2, 2 * n)
        with pytest.raises(gi.DomainError, match="at rest"):
            problem.exact(np.concatenate([y[:n], 0.0 * y[n:]]))


def test_arrays_and_shapes():
    problem = problems(3)[0]
    exact = problem.exact(problem.random_state(1))
    assert exact.at_tau(1.0).shape == (6,)
    assert exact.at_tau([1.0, 2.0]).shape == (2, 6)
    np.testing.assert_array_equal(exact.at_tau([1.0, 2.0])[1], exact.at_tau(2.0))
    assert exact(np.zeros((2, 0))).shape == (2, 0, 6)
    assert exact.frequencies.shape == exact.mean_frequencies.shape == (2,)


def test_refusals():
    sphere = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)
    problem = sphere.hamiltonized()
    with pytest.raises(gi.DomainError, match="at rest"):
        problem.exact([0.6, 0.0, 0.8, 0.0, 0.0, 0.0])
    with pytest.raises(gi.DomainError, match="coordinate plane"):
        problem.exact([0.6, 0.8, 0.0, -0.8, 0.6, 0.0])
    with pytest.raises(gi.DomainError, match="finite times"):
        problem.exact(problem.random_state(1)).at_tau([np.nan])
    with pytest.raises(gi.FormError, match="no exact flow"):
        sphere.ball().exact(sphere.ball().random_state(1))
    equal = ch.ChaplyginSphere(a=[0.8, 0.8, 1.5], D=4.0).hamiltonized()
    with pytest.raises(gi.DomainError, match=r"a\[0\] = a\[1\]"):
        equal.exact(equal.random_state(1))
    six = problems(6)[0]
    with pytest.raises(gi.DomainError, match="n ≤ 4"):
        six.exact(six.random_state(1))(1.0)


@pytest.mark.parametrize("distance", [1e-2, 1e-4, 1e-6, 1e-8])
def test_next_to_a_separatrix(distance):
    """Near a steady turn about the middle axis: right, with the condition, or refused with it."""
    problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
    gamma, p = np.array([1.0, 0.0, distance]), np.array([0.0, distance, 0.2])
    gamma /= np.linalg.norm(gamma)
    y = np.concatenate([gamma, p - (gamma @ p) * gamma])
    if distance < 1e-3:
        with pytest.raises(gi.DomainError, match="condition"):
            problem.exact(problem.canonical(y))
        return
    exact = problem.exact(problem.canonical(y))
    run = gi.solve(problem, y, tau_end=10.0, step=0.01, method="gauss-8", progress=False)
    np.testing.assert_allclose(exact.at_tau(10.0), run.y[-1], atol=1e-14 * exact.condition)


def test_separation_constants():
    """r_0 and r_(n−2) are K and the Veselova energy; every oval has a λ of the state."""
    body = random_body(4)
    problem = body.hamiltonized()
    y = problem.random_state(7)
    found = separation_of(body.a, y[:4], y[4:])
    K = gi.value(problem, "K", y)
    assert float(found.r[0]) * body.D**2 / np.prod(body.a) == pytest.approx(K, rel=1e-13)
    energy = gi.value(problem, "energy", y)
    assert float(found.r[-1]) * body.D**2 / 2 == pytest.approx(energy, rel=1e-13)
    lam, _ = ch.Spheroconical(body.a).coordinates(y[:4])
    for x, oval in zip(lam, found.ovals, strict=True):
        assert float(oval.lower) - 1e-14 <= x <= float(oval.upper) + 1e-14
