"""Angular velocities where moments differ by many powers of ten: no digits lost to cancellation."""

import mpmath
import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from chaplygin.ball.angular_velocity import omega_for, omega_work, special_omega, spread_omega
from chaplygin.veselova.classical import angular_velocity
from geomint.kernels.numbers.blocks import Block

mp = mpmath.mp.clone()
mp.dps = 60


def extended(values):
    return np.array([mp.mpf(float(v)) for v in values], dtype=object)


def written(omega, n, params, k, gamma):
    kind = k.dtype
    out, work = np.zeros(len(k), dtype=kind), np.zeros(omega_work(omega, n), dtype=kind)
    omega(n, Block(params), Block(k), Block(gamma), Block(out), Block(work))
    return out


def state(n, seed=0):
    rng = np.random.default_rng([n, seed])
    gamma = rng.normal(size=n)
    return gamma / np.linalg.norm(gamma), rng.normal(size=n * (n - 1) // 2)


def inertia(n, ratio):
    a = ratio ** np.linspace(-0.5, 0.5, n) * (1.0 + 0.2 * np.sin(np.arange(n)))
    return ch.SpecialInertia(a, 2.0 * float(np.prod(np.sort(a)[-2:])))


@pytest.mark.parametrize("n", range(2, 8))
@pytest.mark.nojit
def test_both_formulas_are_the_same_function(n):
    gamma, k = state(n)
    operator = inertia(n, 3.0)
    a = extended(operator.a)
    i, j = np.triu_indices(n, 1)
    moments = a[i] * a[j] * operator.D / (operator.D - a[i] * a[j])
    params = np.concatenate([extended([operator.D]), a, 1 / a, 1 / moments])
    gamma, k = 1.3 * extended(gamma), extended(k)
    one, other = (written(f, n, params, k, gamma) for f in (special_omega, spread_omega))
    assert max(abs(one - other)) < mp.mpf("1e-50")


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


@pytest.mark.parametrize("ratio", [10.0, 1e4, 1e8, 1e12])
@pytest.mark.parametrize("n", [3, 4, 5])
@pytest.mark.nojit
def test_no_cancellation(n, ratio):
    gamma, k = state(n, 1)
    operator = inertia(n, ratio)
    omega, params = omega_for(operator, operator.D)
    assert omega is spread_omega
    right = exact_omega(operator, k, gamma)
    found = written(omega, n, params, k, gamma)
    assert np.max(np.abs(found - right)) < 4e-15 * np.max(np.abs(right))


@pytest.mark.parametrize("ratio", [10.0, 1e4, 1e8, 1e12])
@pytest.mark.nojit
def test_no_cancellation_without_momentum(ratio):
    """k = γ∧p, n = 3: where the sum of large terms was worst, by 2e-4 at 1e12."""
    gamma, _ = state(3, 2)
    p = np.cross(gamma, [0.3, -1.0, 0.7])
    i, j = np.triu_indices(3, 1)
    k = gamma[i] * p[j] - p[i] * gamma[j]
    operator = inertia(3, ratio)
    omega, params = omega_for(operator, operator.D)
    right = exact_omega(operator, k, gamma)
    found = written(omega, 3, params, k, gamma)
    assert np.max(np.abs(found - right)) < 4e-15 * np.max(np.abs(right))


def test_ball_and_classical_ball_agree_at_any_spread():
    operator = inertia(3, 1e12)
    sphere = ch.ChaplyginSphere(inertia=operator)
    gamma, p = np.array([2.0, 1.0, 2.0]) / 3.0, np.array([1.0, -2.0, 0.0])
    ends = []
    for problem in (sphere.ball(), sphere.classical(), sphere.reduced()):
        components = {"k": np.cross(p, gamma)} if problem.name == "classical-ball" else {"p": p}
        y0 = problem.state(gamma=gamma, **components)
        y = gi.solve(problem, y0, t_end=1e4, method="dop853", step=1e3, progress=False).y[-1]
        ends.append(problem.physical_state(y)["gamma"])
    np.testing.assert_allclose(ends[0], ends[2], rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(ends[1], ends[2], rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("ratio", [1.0, 1e4, 1e12])
@pytest.mark.parametrize("f1", [0.0, 0.3])
@pytest.mark.nojit
def test_veselova_without_cancellation(ratio, f1):
    gamma, _ = state(3, 3)
    k = np.cross(gamma, [0.3, -1.0, 0.7]) + f1 * gamma
    b = ratio ** np.array([-0.5, 0.0, 0.5]) * np.array([1.1, 0.9, 1.2])
    params, y = np.concatenate([b, [f1]]), np.concatenate([k, gamma])
    found = np.array([float(w) for w in angular_velocity(Block(params), y)])
    B, K, G = extended(b), extended(k), extended(gamma)
    m = (sum(K * G) - sum(G * B * K)) / sum(G * B * G)
    right = np.array([float(w) for w in (*(B * (K + m * G)), m)])
    assert np.max(np.abs(found[:3] - right[:3])) < 4e-15 * np.max(np.abs(right[:3]))
    assert found[3] == pytest.approx(right[3], rel=1e-14)
