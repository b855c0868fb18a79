"""Spheroconical coordinates: round trips, separation, degenerate input."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import chaplygin as ch
import geomint as gi

EPSILON = 2.0**-52


@st.composite
def points(draw):
    """Parameters, a direction and a tangent; components down to 1e-140."""
    n = draw(st.integers(2, 7))
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    a = rng.permutation(np.cumsum(10.0 ** rng.uniform(-4, 1, n)))
    gamma = rng.normal(size=n) * 10.0 ** -draw(
        st.lists(st.sampled_from([0, 0, 1, 8, 30, 140]), min_size=n, max_size=n).map(np.array)
    ).astype(float)
    gamma = gamma / np.max(np.abs(gamma))
    gamma /= np.sqrt(gamma @ gamma)
    p = rng.normal(size=n)
    for _ in range(3):
        p -= (gamma @ p) * gamma
    return a, gamma, p


@given(points())
def test_there_and_back(point):
    """γ to a relative rounding error, however small a component is."""
    a, gamma, p = point
    chart = ch.Spheroconical(a)
    there = chart.point(gamma, p)
    order = np.sort(a)
    assert np.all((order[:-1] <= there.lam) & (there.lam <= order[1:]))
    back, momentum = chart.state(there)
    np.testing.assert_allclose(back, gamma, rtol=64 * len(a) * EPSILON)
    np.testing.assert_allclose(momentum, p, atol=1e-11 * np.max(np.abs(p)))


@given(st.integers(2, 7), st.integers(0, 10**6))
def test_separation(n, seed):
    """−4λPμ² = R(λ), μ = ½Σ p̃_iγ_i/(λ − a_i), with the r_k that the problems have as integrals."""
    problem = ch.Veselova(np.random.default_rng(seed).uniform(0.4, 2.0, n), 1.7).hamiltonized()
    y, a = problem.random_state(seed), np.array(problem.parameters["a"])
    gamma, p = y[:n], y[n:]
    chart = ch.Spheroconical(a)
    point, R = chart.point(gamma, p), chart.polynomial(gamma, p)
    size = np.max(np.polyval(np.abs(R[::-1]), point.lam))
    mu = np.array([0.5 * np.sum(p * gamma / (lam - a)) for lam in point.lam])
    separated = [-4 * x * np.prod(x - a) * m * m for x, m in zip(point.lam, mu, strict=True)]
    np.testing.assert_allclose(np.polyval(R[::-1], point.lam), separated, rtol=0, atol=1e-10 * size)
    np.testing.assert_allclose(chart.separated(point), separated, rtol=0, atol=1e-10 * size)
    assert R[-1] == pytest.approx(p @ (a * p), rel=1e-12)
    u = gamma @ (gamma / a)
    assert (-1) ** n * R[0] / np.prod(a) == pytest.approx(u * (p @ p), rel=1e-11)
    for k in range(1, n - 2):
        assert gi.value(problem, f"r{k}", y) == pytest.approx(R[k], rel=1e-10)


def test_equal_parameters_are_refused():
    with pytest.raises(gi.DomainError, match=r"a\[0\] = a\[2\] = 1.0"):
        ch.Spheroconical([1.0, 2.0, 1.0])


def test_turning_points():
    """λ is a_i where γ_i = 0; μ is not a number there, and R is."""
    chart = ch.Spheroconical([0.8, 1.1, 1.5])
    lam, gaps = chart.coordinates([0.6, 0.0, 0.8])
    assert 1.1 in lam
    np.testing.assert_allclose(chart.gamma(gaps, [1, 1, 1]), [0.6, 0.0, 0.8], atol=1e-15)
    with pytest.raises(gi.DomainError, match=r"gamma\[1\] = 0.0"):
        chart.point([0.6, 0.0, 0.8], [0.8, 1.0, -0.6])
    assert np.isfinite(chart.polynomial([0.6, 0.0, 0.8], [0.8, 1.0, -0.6])).all()
