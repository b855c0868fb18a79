"""The exact flow: against integrations, itself, and what it must keep at any time.

Every test runs over all patterns of equal a_i, sphere and body, in τ and in t.
"""

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from tests.chaplygin.exact_support import (
    PATTERNS,
    TAU_AND_T,
    WEIGHTS,
    flow_of,
    parameters,
    patterns,
    problem_of,
    special_states,
    turn_of,
    turned,
)


def assert_exact(problem, y):
    """It begins at the state, has its velocity everywhere, and is a flow."""
    n = problem.rows // 2
    exact, size = problem.exact(y), np.max(np.abs(y))
    allowed = 3e-14 * exact.condition * size
    np.testing.assert_allclose(exact.at_tau(0.0), y, rtol=0, atol=allowed)
    turn = turn_of(exact)
    for tau in (0.0, 4.3 * turn, -211.7 * turn):
        z = exact.at_tau(tau)
        rate = WEIGHTS @ exact.at_tau(tau + 1e-3 * turn * np.arange(-4, 5)) / (1e-3 * turn)
        expected = gi.derivative(problem, z)
        if problem.time == "t":
            u = z[:n] @ (z[:n] / np.array(problem.parameters["a"]))
            expected = expected * problem.parameters["D"] * np.sqrt(u)
        allowed = 1e-10 * np.max(np.abs(expected)) * exact.condition
        np.testing.assert_allclose(rate, expected, rtol=0, atol=allowed)
    first, second = 3.7 * turn, -11.3 * turn
    middle = problem.canonical(exact.at_tau(first))
    again = problem.exact(middle).at_tau(second)
    allowed = 3e-14 * exact.condition * size
    np.testing.assert_allclose(again, exact.at_tau(first + second), rtol=0, atol=allowed)


@pytest.mark.parametrize("kind", TAU_AND_T)
@patterns
def test_it_is_the_flow(pattern, kind):
    problem = problem_of(pattern, kind, 1)
    assert_exact(problem, problem.random_state(1))


@pytest.mark.parametrize("kind", TAU_AND_T[::2])
@patterns
def test_planes_lines_and_origins(pattern, kind):
    """Within coordinate planes; a group of equal a_i along a line, and through its origin."""
    problem = problem_of(pattern, kind)
    for y in special_states(problem).values():
        assert_exact(problem, y)


@patterns
def test_integrals_and_constraints_at_large_times(pattern):
    for kind in TAU_AND_T[::2]:
        problem = problem_of(pattern, kind)
        y = problem.random_state(1)
        for tau in (1e3, 1e9, -1e12):
            z = problem.exact(y).at_tau(tau)
            for name in problem.invariants:
                expected = gi.value(problem, name, y)
                size = max(abs(expected), 1e-2 * np.max(np.abs(y)) ** 2)
                assert abs(gi.value(problem, name, z) - expected) < 1e-12 * size, name
            for name in problem.constraints:
                assert abs(gi.value(problem, name, z)) < 1e-12 * max(1.0, np.max(np.abs(y)))


@patterns
def test_both_problems_are_linear_in_the_same_angles(pattern):
    """Theorem CH-VP (iii): the angles of one along the other, with frequencies of their own."""
    a, D, _ = parameters(pattern)
    sphere, body = ch.ChaplyginSphere(a, D).hamiltonized(), ch.Veselova(a, D).hamiltonized()
    y = sphere.random_state(3)
    one, other = sphere.exact(y), body.exact(y)
    np.testing.assert_allclose(turned(one.start - other.start), 0.0, atol=1e-12)
    assert np.max(np.abs(one.frequencies - other.frequencies)) > 1e-3
    for tau in 10.0 * turn_of(one) * np.array([0.3, 1.7, -4.1]):
        found = other.angles(one.at_tau(tau))
        expected = one.start + one.frequencies * tau
        np.testing.assert_allclose(turned(found - expected), 0.0, atol=1e-12 * one.condition)


@pytest.mark.parametrize("pattern", ["2", "3", "5", "lagrange", "two-pairs", "circle-4"])
def test_the_error_estimate(pattern):
    """A rounding of the state turns phases by no more than is estimated, and not by much less."""
    n = sum(PATTERNS[pattern])
    rng, worst = np.random.default_rng(n), 0.0
    for kind in TAU_AND_T[::2]:
        problem = problem_of(pattern, kind)
        y = problem.random_state(6)
        exact = problem.exact(y)
        tau = 1e6 * turn_of(exact)
        for _ in range(3):
            near = problem.exact(problem.canonical(y * (1 + 2.0**-52 * rng.choice([-1, 1], 2 * n))))
            phase = np.max(np.abs(near.frequencies - exact.frequencies)) * tau
            worst = max(worst, phase / float(exact.phase_error(tau)))
    assert 1e-3 < worst < 4.0


@pytest.mark.parametrize("n", [3, 5])
def test_starts_on_coordinate_planes_and_at_turning_points(n):
    """γ_i = 0 with p̃_i ≠ 0: λ turns there, and the sign of γ_i is that with which it leaves."""
    problem = problem_of(str(n), "sphere-tau")
    for i in range(n):
        for sign in (1.0, -1.0):
            y = problem.random_state(i)
            gamma, p = y[:n].copy(), y[n:].copy()
            gamma[i] = 0.0
            p[i] = sign * (1.0 + abs(p[i]))
            state = flow_of(problem, gamma, p)
            assert state[n + i] == p[i]
            exact = problem.exact(state)
            np.testing.assert_allclose(exact.at_tau(0.0), state, atol=2e-13 * exact.condition)
            tau = 1e-4 * turn_of(exact)
            moved = exact.at_tau(np.array([-tau, tau]))[:, i]
            rate = gi.derivative(problem, state)[i]
            np.testing.assert_allclose(moved, [-rate * tau, rate * tau], rtol=1e-3)


def test_arrays_and_shapes():
    problem = problem_of("3", "sphere-tau")
    exact = problem.exact(problem.random_state(1))
    assert exact.at_tau(1.0).shape == (6,)
    assert exact.at_tau([1.0, 2.0]).shape == (2, 6)
    np.testing.assert_array_equal(exact.at_tau([1.0, 2.0])[1], exact.at_tau(2.0))
    assert exact(np.zeros((2, 0))).shape == (2, 0, 6)
    assert exact.frequencies.shape == exact.mean_frequencies.shape == (2,)
    lagrange = problem_of("triple-and-pair", "sphere-tau")
    assert lagrange.exact(lagrange.random_state(1)).frequencies.shape == (4,)


def test_refusals():
    sphere = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)
    problem = sphere.hamiltonized()
    exact = problem.exact(problem.random_state(1))
    small = ch.ChaplyginSphere(a=[1e-6, 1.0, 1.9], D=4.0).hamiltonized()
    for call, text in (
        (lambda: problem.exact([0.6, 0.0, 0.8, 0.0, 0.0, 0.0]), "at rest"),
        (lambda: exact.at_tau("abc"), "real numbers"),
        (lambda: exact.at_tau(10**400), "real numbers"),
        (lambda: exact.at_tau([[1.0], [1.0, 2.0]]), "real numbers"),
        (lambda: exact.at_tau([np.nan]), "finite times"),
        (lambda: exact.angles([1.0, 2.0]), "6 numbers"),
        (lambda: exact.at_angles([1.0, 2.0, 3.0]), "no more than 2 angles"),
        (lambda: exact.at_angles([np.inf]), "finite angles"),
        (lambda: small.exact(small.random_state(1)), r"condition 1e\+06"),  # 0 is near to an oval
    ):
        with pytest.raises(gi.DomainError, match=text):
            call()
    with pytest.raises(gi.FormError, match="no exact flow"):
        sphere.ball().exact(sphere.ball().random_state(1))


def test_angles_are_found_wherever_they_are():
    """Next to a separatrix the map from θ to φ is far from linear: Newton's method alone cycles."""
    problem = ch.ChaplyginSphere(a=[0.8, 1.15, 1.5], D=4.0).hamiltonized()
    times = np.array([-50.0, 317.7, 1000.0])
    rng, strips = np.random.default_rng(3), []
    for size in (0.1, 0.03, 0.03, 0.02, 0.02):
        gamma = np.eye(3)[0] + size * rng.normal(size=3)
        y = flow_of(problem, gamma, np.eye(3)[2] + size * rng.normal(size=3))
        exact = problem.exact(y)
        strips.append(np.min(exact.torus.strips))
        for tau, z in zip(times, exact.at_tau(times), strict=True):
            found, expected = exact.angles(z), exact.start + exact.frequencies * tau
            np.testing.assert_allclose(turned(found - expected), 0, atol=1e-12 * exact.condition)
    assert min(strips) < 0.03


def test_units():
    """Parameters and momenta of any size, whose squares may be no numbers: the same path."""
    plain = ch.Veselova([0.8, 1.1, 1.5], 4.0).hamiltonized()
    y = plain.random_state(1)
    expected = plain.exact(y).at_tau(3.0)
    for unit in (1e-150, 1e-60, 1e60, 1e100):
        scaled = ch.Veselova(np.array([0.8, 1.1, 1.5]) * unit, 4.0).hamiltonized()
        found = scaled.exact(y).at_tau(3.0 / unit)[:3]
        np.testing.assert_allclose(found, expected[:3], rtol=0, atol=1e-13)
    for unit in (1e-250, 1e-170, 1e-60, 1e60, 1e170):
        far = plain.exact(np.concatenate([y[:3], unit * y[3:]])).at_tau(3.0 / unit)
        np.testing.assert_allclose(far[:3], expected[:3], rtol=0, atol=1e-13)
        np.testing.assert_allclose(far[3:] / unit, expected[3:], rtol=0, atol=1e-13)


def test_components_that_are_all_but_zero():
    problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
    for size in (1e-300, 1e-160, 1e-20, 1e-9):
        assert_exact(problem, flow_of(problem, [size, 0.5, 0.7], [0.9, -0.8, 1.1]))


def test_next_to_a_separatrix():
    """Near a steady turn about the middle axis: right, with the condition, or refused with it."""
    problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
    assert_exact(problem, flow_of(problem, [1.0, 0.0, 1e-2], [0.0, 1e-2, 0.2]))
    for distance in (1e-4, 1e-6, 1e-8):
        with pytest.raises(gi.DomainError, match=r"condition \d"):
            problem.exact(flow_of(problem, [1.0, 0.0, distance], [0.0, distance, 0.2]))
