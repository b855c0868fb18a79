"""Spheroconical coordinates: round trips, separation, involution, independence, degenerate input."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import chaplygin as ch
import geomint as gi
from chaplygin.integrable import separation_integral, special_parameters
from geomint.kernels.numbers.blocks import Block
from tests.chaplygin.support import DIMENSIONS, extended, mp, random_body, random_tangent

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


@pytest.mark.parametrize("n", DIMENSIONS)
def test_separation(n):
    """−4λPμ² = R(λ), with the r_k that the problems have as integrals."""
    a, (gamma, p) = random_body(n).a, random_tangent(n)
    chart = ch.Spheroconical(a)
    point, R = chart.point(gamma, p), chart.polynomial(gamma, p)
    size = np.polyval(np.abs(R[::-1]), point.lam)
    np.testing.assert_allclose(
        chart.separated(point), np.polyval(R[::-1], point.lam), rtol=0, atol=1e-13 * np.max(size)
    )
    assert R[-1] == pytest.approx(p @ (a * p), rel=1e-12)
    u = gamma @ (gamma / a)
    assert (-1) ** n * R[0] / np.prod(a) == pytest.approx(u * (p @ p), rel=1e-11)
    problem = ch.Veselova(a, 1.7).hamiltonized()
    y = problem.state(gamma=gamma, p_tilde=p)
    for k in range(1, n - 2):
        assert gi.value(problem, f"r{k}", y) == pytest.approx(R[k], rel=1e-11)


def all_integrals(a):
    """r_0, …, r_(n−2) as functions of (γ, p̃) in mpmath numbers."""
    n = len(a)
    from chaplygin.commuting_integrals import coefficient_tables

    tables = coefficient_tables(a, range(n - 1), 1)
    params = np.concatenate([[1.0], 1.0 / a, a, tables])
    fs = [separation_integral(n, 0, k, False) for k in range(n - 1)]
    work = Block(extended(np.zeros(1)))
    return lambda y: [f(Block(extended(params)), mp.mpf(0), Block(y), work) for f in fs]


@pytest.mark.parametrize("n", DIMENSIONS)
def test_involution_and_independence(n):
    """{r_j, r_k} = 0 by the Dirac bracket of T*S^(n−1), and n − 1 of them are independent."""
    a, (gamma, p) = random_body(n).a, random_tangent(n)
    y, h = extended(np.concatenate([gamma, p])), mp.mpf("1e-12")
    functions = all_integrals(a)
    slopes = np.array(
        [
            (np.array(functions(y + h * e)) - np.array(functions(y - h * e))) / (2 * h)
            for e in (extended(e) for e in np.eye(2 * n))
        ]
    ).T
    g, q = y[:n], y[n:]
    by_gamma, by_p = slopes[:, :n], slopes[:, n:]

    def bracket(f, k):
        """{f, k} − ({f, ψ₁}{k, ψ₂} − {f, ψ₂}{k, ψ₁})/{ψ₁, ψ₂}."""
        plain = by_gamma[f] @ by_p[k] - by_p[f] @ by_gamma[k]
        first = [-2 * (by_p[m] @ g) for m in (f, k)]
        second = [by_gamma[m] @ g - by_p[m] @ q for m in (f, k)]
        return plain - (first[0] * second[1] - second[0] * first[1]) / (2 * (g @ g))

    size = float(max(abs(slopes.ravel()))) ** 2
    for f in range(n - 1):
        for k in range(f):
            assert abs(float(bracket(f, k))) < 1e-14 * size
    tangents = np.array(slopes, float)
    normal = [np.concatenate([gamma, 0 * p]), np.concatenate([p, gamma])]
    for v in normal:
        tangents = tangents - np.outer(tangents @ v, v) / (v @ v)
    scaled = tangents / np.linalg.norm(tangents, axis=1)[:, None]
    assert np.linalg.svd(scaled, compute_uv=False)[-1] > 1e-6


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


def test_linear_integrals_of_equal_parameters():
    """Two pairs: f-1-2, f-3-4; four equal: neighbours and the sum of all squares."""
    _, found = special_parameters(np.array([1.0, 1.0, 2.0, 2.0]), 1.0, False)
    assert [name for name in found if name[0] == "f"] == ["f-1-2", "f-3-4"]
    _, found = special_parameters(np.array([2.0, 1.0, 1.0, 1.0, 1.0]), 1.0, False)
    names = [name for name in found if name[0] in "fc"]
    assert names == ["f-2-3", "f-3-4", "f-4-5", "casimir-2"]
