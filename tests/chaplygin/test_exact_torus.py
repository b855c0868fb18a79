"""The frequencies of a torus against mpmath, to 30 digits.

The truth shares nothing with what it judges: F is evaluated by its definition, with every index on its
own, its polynomial is interpolated, the differentials are those of powers of λ, and all of that has
120 digits and more.
"""

import numpy as np
import pytest
from mpmath import mp, mpf

import chaplygin as ch
import geomint as gi
from tests.chaplygin.exact_support import flow_of, problem_of

DIGITS = 36
ALLOWED = 1e-31  # of the fastest frequency


def normalised(x):
    """Return x/|x| with the roundings of the package: what has 30 digits is that vector's motion."""
    scaled = x / np.max(np.abs(x))
    return x / (np.max(np.abs(x)) * np.sqrt(scaled @ scaled))


def wanted(exact, y, at_zero, at_infinity):
    """Return ω and Ω over 4π in mpmath numbers, for H = ½ (x F(0) + y (p̃, Ap̃))."""
    n = len(exact.a)
    mp.dps = 120 + 30 * n
    unit, unit_p = mpf(exact.unit), mpf(exact.unit_p)
    a = [mpf(x) / unit for x in exact.a.tolist()]
    gamma = [mpf(x) for x in (normalised(y[:n])).tolist()]
    p = [mpf(x) / unit_p for x in y[n:].tolist()]
    size = mp.sqrt(mp.fsum(x * x for x in gamma))
    gamma = [x / size for x in gamma]
    along = mp.fsum(x * z for x, z in zip(gamma, p, strict=True))
    p = [z - along * x for x, z in zip(gamma, p, strict=True)]
    at_zero, at_infinity = mpf(at_zero) * unit_p / unit, mpf(at_infinity) * unit_p * unit
    groups = [np.flatnonzero(m).tolist() for m in exact.axes.members]
    alpha = [a[group[0]] for group in groups]
    pairs = np.flatnonzero(exact.axes.paired).tolist()
    ell = {}
    for g in pairs:
        minors = [(gamma[i] * p[j] - gamma[j] * p[i]) ** 2 for i in groups[g] for j in groups[g]]
        ell[g] = mp.sqrt(mp.fsum(minors) / 2)
    inside = [i for group in groups for i in group]

    def polynomial(x):  # T
        momentum = mp.fsum(p[i] ** 2 for i in inside)
        value = -momentum * mp.fsum(gamma[i] ** 2 / (x - a[i]) for i in inside)
        for i in inside:
            for j in inside:
                minor = (gamma[i] * p[j] - gamma[j] * p[i]) ** 2
                value += x * minor / ((x - a[i]) * (x - a[j])) / 2
        return value * mp.fprod(x - b for b in [*alpha, *(alpha[g] for g in pairs)])

    d, degree = len(alpha) - 1, len(alpha) + len(pairs) - 2
    omega, means = [], mp.matrix(d, d + len(pairs))
    if d:
        at = [mpf(2 + k) / (degree + 1) for k in range(degree + 1)]
        table = mp.matrix([[x**k for k in range(degree + 1)] for x in at])
        c = mp.lu_solve(table, mp.matrix([polynomial(x) for x in at]))
        companion = mp.matrix(degree, degree)
        for k in range(degree):
            companion[k, degree - 1] = -c[k] / c[degree]
            if k:
                companion[k, k - 1] = 1
        roots = mp.eig(companion, left=False, right=False) if degree else []
        single = [x for g, x in enumerate(alpha) if g not in pairs]
        points = sorted([*single, *(mp.re(e) for e in roots)])
        for k in range(d):
            lower, upper = points[2 * k : 2 * k + 2]
            others = [mpf(0), *points[: 2 * k], *points[2 * k + 2 :]]
            middle, radius = (lower + upper) / 2, (upper - lower) / 2
            singular = [*others, *(alpha[g] for g in pairs)]
            strip = min(mp.acosh(abs(b - middle) / radius) for b in singular)
            half = int(2.4 * DIGITS / (2 * strip)) + 12
            for i in range(half + 1):
                lam = middle - radius * mp.cos(mp.pi * i / half)
                root = mp.sqrt(abs(c[degree] * mp.fprod(lam - b for b in others)))
                share = mpf(1 if i in (0, half) else 2) / (2 * half)
                for j in range(d):
                    means[k, j] -= share * lam**j / (4 * root)
                for j, g in enumerate(pairs, start=d):
                    product = mp.fprod(lam - x for h, x in enumerate(alpha) if h != g)
                    share_g = share * ell[g] * alpha[g]
                    means[k, j] -= share_g * product / (2 * (lam - alpha[g]) * root)
        slopes = mp.matrix(d, 1)
        slopes[0] += at_zero / (2 * mp.fprod(-x for x in alpha))
        slopes[d - 1] += at_infinity / 2
        omega = list(mp.lu_solve(means[:, :d].T, slopes))
    for j, g in enumerate(pairs, start=d):
        turning = ell[g] * (at_zero / alpha[g] + at_infinity * alpha[g])
        omega.append(turning - mp.fsum(means[k, j] * omega[k] for k in range(d)))
    return [x / (4 * mp.pi) for x in omega]


def assert_frequencies(problem, y):
    exact = problem.exact(y)
    D = problem.parameters["D"]
    energy = (D, -1.0) if problem.name.startswith("chaplygin") else (0.0, D * D)
    truth = wanted(exact, y, *energy)
    found = zip(exact.torus.turns.tolist(), exact.torus.turns_low.tolist(), strict=True)
    off = [abs(mpf(x) + mpf(z) - w) for (x, z), w in zip(found, truth, strict=True)]
    assert max(off) < ALLOWED * max(map(abs, truth))


@pytest.mark.parametrize("kind", ["sphere-tau", "body-tau"])
@pytest.mark.parametrize(
    "pattern", ["2", "3", "4", "5", "lagrange", "two-pairs", "pair-of-four", "circle-4"]
)
def test_random_motions(pattern, kind):
    problem = problem_of(pattern, kind, 1)
    assert_frequencies(problem, problem.random_state(2))


@pytest.mark.parametrize("gap", [1e-3, 1e-9, 1e-13, 2.0**-52])
def test_nearly_equal_parameters(gap):
    for a in ([0.8, 0.8 * (1 + gap), 1.5], [0.8, 1.1, 1.1 * (1 + gap), 1.5]):
        problem = ch.ChaplyginSphere(a=a, D=4.0).hamiltonized()
        assert_frequencies(problem, problem.random_state(1))


@pytest.mark.parametrize("size", [1.0, 1e-3, 1e-12, 1e-30, 1e-200])
def test_turning_points_planes_and_small_components(size):
    """γ_i = 0, of p̃ too, or both all but that, to the end of what can be told from a steady plane."""
    problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
    for i in range(3):
        scale = np.where(np.arange(3) == i, size, 1.0)
        gamma, p = np.array([0.48, 0.6, 0.64]), np.array([0.8, -1.0, 0.7])
        assert_frequencies(problem, flow_of(problem, gamma * scale, p))
        assert_frequencies(problem, flow_of(problem, gamma * (np.arange(3) != i), p))
        assert_frequencies(problem, flow_of(problem, gamma * (scale == 1.0), p * (scale == 1.0)))
        both = flow_of(problem, gamma * scale, p * scale)
        if size < 1e-32 or (i == 1 and size < 1.0):  # a separatrix
            with pytest.raises(gi.DomainError, match="condition"):
                problem.exact(both)
        else:
            assert_frequencies(problem, both)


@pytest.mark.parametrize("distance", [0.1, 0.03, 0.01, 3e-3])
def test_next_to_a_separatrix(distance):
    problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
    assert_frequencies(problem, flow_of(problem, [1.0, 0.0, distance], [0.0, distance, 0.2]))
    assert_frequencies(problem, flow_of(problem, [distance, 1.0, 0.3], [0.3, 0.0, distance]))
