"""Physical time on the torus: against integration, in every pattern of equal a_i, and far away."""

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from tests.chaplygin.exact_support import parameters, problem_of, turn_of

LATE = ["2 sphere", "two-pairs body", "4 body", "5 sphere"]
LATE += ["triple-and-pair sphere", "circle-4 sphere"]
FAST = ["3 sphere", "lagrange body"]


@pytest.mark.parametrize(
    "which", [*FAST, *(pytest.param(x, marks=pytest.mark.nightly) for x in LATE)]
)
def test_physical_time(which):
    """Against dt/dτ = D√U integrated with the motion, and back; the reduced problem by t alone."""
    pattern, system = which.split()
    flow, reduced = (problem_of(pattern, f"{system}-{time}") for time in ("tau", "t"))
    y = flow.random_state(2)
    exact = flow.exact(y)
    turn = turn_of(exact)
    run = gi.solve(
        flow, y, tau_end=60 * turn, step=0.05 * turn, method="gauss-8", clock=True, save_every=100,
        progress=False,
    )  # fmt: skip
    end = abs(run.t[-1])
    np.testing.assert_allclose(exact.time(run.tau), run.t, rtol=0, atol=1e-14 * end)
    np.testing.assert_allclose(exact.tau(run.t), run.tau, rtol=0, atol=1e-14 * 60 * turn)
    np.testing.assert_allclose(exact(run.t), run.y, rtol=0, atol=1e-12 * exact.condition)
    start = ch.converted(y, flow, reduced)
    states = reduced.exact(start)(run.t)
    for state, other in zip(states, run.y, strict=True):
        expected = ch.converted(other, flow, reduced)
        np.testing.assert_allclose(state, expected, atol=1e-12 * exact.condition)
    far = exact.tau(np.array([1e9, -1e9]))
    np.testing.assert_allclose(exact.time(far), [1e9, -1e9], rtol=1e-15)
    assert exact.clock.edge < 1e-14


def test_a_resonant_torus():
    """m·ω = 0, or all but: the series has a divisor of 0, and time is right nonetheless."""
    a, D, _ = parameters("3")
    problem = ch.ChaplyginSphere(a, D).hamiltonized()
    y = problem.random_state(1)

    def ratio(x):
        z = problem.state(gamma=y[:3], p_tilde=y[3:] + x * np.cross(y[:3], y[3:]))
        return problem.exact(z)

    low, high = -0.5, 0.5
    omega = [ratio(x).frequencies for x in (low, high)]
    values = sorted(w[1] / w[0] for w in omega)
    p, q = next(
        (p, q)
        for q in range(1, 60)
        for p in range(-6 * q, 6 * q + 1)
        if values[0] < p / q < values[1] and np.gcd(p, q) == 1
    )
    rising = omega[1][1] / omega[1][0] > omega[0][1] / omega[0][0]
    for _ in range(60):
        middle = 0.5 * (low + high)
        w = ratio(middle).frequencies
        low, high = (middle, high) if (w[1] / w[0] < p / q) == rising else (low, middle)
    exact = ratio(0.5 * (low + high))
    assert abs(q * exact.frequencies[1] - p * exact.frequencies[0]) < 1e-13
    turn = turn_of(exact)
    run = gi.solve(
        problem, exact.at_tau(0.0), tau_end=100 * turn, step=0.05 * turn, method="gauss-8",
        clock=True, save_every=400, progress=False,
    )  # fmt: skip
    np.testing.assert_allclose(exact.time(run.tau), run.t, rtol=0, atol=1e-13 * run.t[-1])
    np.testing.assert_allclose(exact.tau(run.t), run.tau, rtol=0, atol=1e-13 * run.tau[-1])
