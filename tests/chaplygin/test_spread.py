"""Angular velocities where moments differ by many powers of ten: no digits lost to cancellation."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, strategies as st

import chaplygin as ch
from tests.chaplygin.support import generator_of, seeds

mp = mpmath.mp.clone()
mp.dps = 60
RATIOS = st.floats(0.0, 12.0).map(lambda power: 10.0**power)


def extended(values):
    return np.array([mp.mpf(float(v)) for v in values], dtype=object)


def inertia(n, ratio):
    a = ratio ** np.linspace(-0.5, 0.5, n) * (1.0 + 0.2 * np.sin(np.arange(n)))
    return ch.SpecialInertia(a, 2.0 * float(np.prod(np.sort(a)[-2:])))


def exact_omega(operator, k, gamma):
    """Solve k = Iω + D(ωγγᵀ + γγᵀω)/(γ, γ) in 60 digits."""
    n = operator.n
    pairs = [(i, j) for i in range(n) for j in range(i + 1, n)]
    a, g, D = extended(operator.a), extended(gamma), mp.mpf(operator.D)
    matrix = mp.matrix(len(pairs), len(pairs))
    for c, (p, q) in enumerate(pairs):
        v = {p: g[q], q: -g[p]}
        for r, (i, j) in enumerate(pairs):
            matrix[r, c] = D * (v.get(i, 0) * g[j] - g[i] * v.get(j, 0)) / sum(g * g)
        matrix[c, c] += a[p] * a[q] * D / (D - a[p] * a[q])
    return np.array([float(x) for x in mp.lu_solve(matrix, mp.matrix(list(extended(k))))])


@given(st.integers(2, 5), RATIOS, seeds, st.booleans())
def test_no_cancellation(n, ratio, seed, turning):
    """Without momentum, k = γ∧p, the sum of large terms was worst, by 2e-4 at 1e12."""
    rng = np.random.default_rng([n, seed])
    gamma, p = rng.normal(size=(2, n))
    gamma /= np.linalg.norm(gamma)
    i, j = np.triu_indices(n, 1)
    k = rng.normal(size=len(i)) if turning else gamma[i] * p[j] - p[i] * gamma[j]
    operator = inertia(n, ratio)
    right = exact_omega(operator, k, gamma)
    y = np.concatenate([k, gamma])
    found = -generator_of(ch.ball_problem(operator, operator.D), y)
    # The closed form serves up to some ratio, and loses a few digits there.
    assert np.max(np.abs(found - right)) < 4e-14 * np.max(np.abs(right))
    if n == 3:
        vectors = np.array([-k[2], k[1], -k[0]]), gamma
        problem = ch.classical_problem(operator, operator.D)
        found = -generator_of(problem, np.concatenate(vectors))
        expected = np.array([-right[2], right[1], -right[0]])
        assert np.max(np.abs(found - expected)) < 4e-14 * np.max(np.abs(right))


@pytest.mark.parametrize("ratio", [1e4, 1e12])
def test_no_digits_are_lost_at_a_large_spread(ratio):
    for n in (3, 4, 5):
        operator, rng = inertia(n, ratio), np.random.default_rng([n, 1])
        gamma, k = rng.normal(size=n), rng.normal(size=n * (n - 1) // 2)
        gamma /= np.linalg.norm(gamma)
        right = exact_omega(operator, k, gamma)
        found = -generator_of(ch.ball_problem(operator, operator.D), np.concatenate([k, gamma]))
        assert np.max(np.abs(found - right)) < 4e-15 * np.max(np.abs(right))


@given(RATIOS, st.sampled_from([0.0, 0.3]), seeds)
def test_veselova_without_cancellation(ratio, f1, seed):
    """ẏ = (k⃗ × w⃗, γ⃗ × w⃗), w⃗ = B(k⃗ + mγ⃗) with (w⃗, γ⃗) = (k⃗, γ⃗)."""
    rng = np.random.default_rng([3, seed])
    gamma, p = rng.normal(size=(2, 3))
    gamma /= np.linalg.norm(gamma)
    k = np.cross(gamma, p) + f1 * gamma
    body = ch.Veselova(ratio ** np.array([-0.5, 0.0, 0.5]) * np.array([1.1, 0.9, 1.2]))
    B, K, G = extended(np.prod(body.a) / body.a), extended(k), extended(gamma)
    m = (sum(K * G) - sum(G * B * K)) / sum(G * B * G)
    right = np.array([float(w) for w in B * (K + m * G)])
    found = -generator_of(body.classical(float(k @ gamma)), np.concatenate([k, gamma]))
    assert np.max(np.abs(found - right)) < 1e-14 * np.max(np.abs(right))
