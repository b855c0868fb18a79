"""Angular velocities where moments differ by many powers of ten: no digits lost to cancellation."""

import mpmath
import numpy as np
from hypothesis import given, strategies as st

import chaplygin as ch
from tests.chaplygin.support import flat_wedge, generator_of, seeds
from tests.rows import examples

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
@examples(20)
def test_no_cancellation(n, ratio, seed, turning):
    """Without momentum, k = γ∧p, n = 3, the sum of large terms was worst, by 2e-4 at 1e12.

    For n > 3 what roundings leave of momentum there matters as much as p.
    """
    rng = np.random.default_rng([n, seed])
    gamma, p = rng.normal(size=(2, n))
    gamma /= np.linalg.norm(gamma)
    k = rng.normal(size=n * (n - 1) // 2) if turning or n > 3 else flat_wedge(gamma, p)
    operator = inertia(n, ratio)
    right = exact_omega(operator, k, gamma)
    found = -generator_of(ch.ball_problem(operator, operator.D), np.concatenate([k, gamma]))
    assert np.max(np.abs(found - right)) < 8e-15 * np.max(np.abs(right))
    if n == 3:
        y = np.concatenate([vector_of(k), gamma])
        found = -generator_of(ch.classical_problem(operator, operator.D), y)
        assert np.max(np.abs(found - vector_of(right))) < 8e-15 * np.max(np.abs(right))


def vector_of(triangle):
    return np.array([-triangle[2], triangle[1], -triangle[0]])


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
