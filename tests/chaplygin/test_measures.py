"""Invariant measures: the divergence of every field with respect to its own, in 40 digits."""

import numpy as np
import pytest

import chaplygin as ch
from tests.chaplygin.support import (
    CASES,
    DIMENSIONS,
    MADE,
    conditions_jacobian,
    conditions_of,
    divergence,
    extended,
    field_of,
    mp,
    quiet_state,
    random_diagonal,
    random_full,
    random_special,
    random_tangent,
    rng_for,
    tangent_basis,
    value_of,
)

MEASURED = [case for case in CASES if case.problem.measure]

# Parameters that are 1/a are rounded: the vector field is not quite that of a.
ROUNDING = 4e-15


def cheap(case):
    """Rotations are n² numbers: derivatives by all of them take a second from n = 5 on."""
    return case.problem.rows <= 30


@pytest.mark.parametrize("case", [c for c in MEASURED if cheap(c)], ids=str)
def test_the_measure_is_invariant(case):
    assert abs(divergence(case.problem, case.y)) < ROUNDING


@pytest.mark.nightly
@pytest.mark.parametrize("case", [c for c in MEASURED if not cheap(c)], ids=str)
def test_the_measure_is_invariant_in_high_dimensions(case):
    assert abs(divergence(case.problem, case.y)) < ROUNDING


def test_every_problem_of_the_paper_has_a_measure():
    assert all(case.problem.measure for case in MADE)


@pytest.mark.parametrize("case", MEASURED, ids=str)
def test_the_manifold_holds_the_states_and_the_field(case):
    y = extended(case.y)
    size = max(1.0, float(max(abs(case.y))))  # a condition is a sum of products of two numbers of y
    assert max(abs(conditions_of(case.problem, y))) < 3e-15 * size
    if cheap(case):
        jacobian = conditions_jacobian(case.problem, y)
        assert max(abs(jacobian @ field_of(case.problem, y))) < 1e-14
        independent = len(y) - len(tangent_basis(jacobian))
        assert independent == case.problem.measure.conditions == len(jacobian)


def power_of_u(a, exponent):
    """Return log U^exponent as a recorded function would."""

    def log_density(params, t, y, work):
        g = [y[i] for i in range(len(a))]
        return exponent * mp.log(sum(g[i] * g[i] / mp.mpf(float(a[i])) for i in range(len(a))))

    return log_density


@pytest.mark.parametrize("n", [3, 4, 5])
def test_other_exponents_fail(n):
    case = next(c for c in CASES if c.label == f"reduced-special-n{n}")
    inertia = case.sphere
    right = power_of_u(inertia.a, mp.mpf(2 - n) / 2)
    assert abs(divergence(case.problem, case.y, right)) < ROUNDING
    for exponent in (0, mp.mpf(1 - n) / 2, mp.mpf(n - 2) / 2):
        assert abs(divergence(case.problem, case.y, power_of_u(inertia.a, exponent))) > 1e-3


@pytest.mark.parametrize("make", [random_diagonal, random_full])
def test_the_special_density_fails_for_other_operators(make):
    """n = 4 without momentum: it is the measure of the special operator only."""
    inertia = make(4)
    gamma, p = random_tangent(4)
    problem = ch.reduced_problem(inertia, 1.7)
    y = quiet_state(problem, gamma=gamma, p=p)
    assert abs(divergence(problem, y)) < ROUNDING
    for seed in range(3):
        other = power_of_u(random_special(4, seed).a, mp.mpf(-1))
        assert abs(divergence(problem, y, other)) > 1e-3


def test_the_density_matters_for_the_ball():
    """The special operator with momentum, n = 4, and the others: ϱ = 1 is not invariant."""
    for label in ("ball-special-n4", "ball-diagonal-n4", "ball-full-n4", "classical-full-n3"):
        case = next(c for c in CASES if c.label == label)
        assert abs(divergence(case.problem, case.y, lambda params, t, y, work: mp.mpf(0))) > 1e-3


def test_the_hamiltonized_measure_is_that_of_its_own_time():
    """In τ the symplectic volume of (γ, p̃) is invariant, not U^(−(n−2)/2) times it."""
    case = next(c for c in CASES if c.label == "hamiltonized-special-n4")
    other = power_of_u(case.sphere.a, mp.mpf(-1))
    assert abs(divergence(case.problem, case.y, other)) > 1e-3


@pytest.mark.parametrize("n", DIMENSIONS)
@pytest.mark.parametrize("make", [random_special, random_diagonal, random_full])
def test_the_density_is_the_determinant(make, n):
    """ϱ = det(I + D pr)^(−1/2) up to a constant, from the matrix of order n(n−1)/2."""
    inertia = make(n)
    D = getattr(inertia, "D", 1.3)
    ball, reduced = ch.ball_problem(inertia, D), ch.reduced_problem(inertia, D)
    differences = []
    for seed in range(3):
        gamma, p = random_tangent(n, seed)
        metric = []
        for e in np.eye(n * (n - 1) // 2):
            full = np.zeros((n, n))
            full[np.triu_indices(n, 1)] = e
            full -= full.T
            pr = full @ np.outer(gamma, gamma) + np.outer(gamma, gamma) @ full
            metric.append(inertia.apply(e) + D * pr[np.triu_indices(n, 1)])
        expected = -0.5 * np.linalg.slogdet(np.array(metric))[1]
        for problem in (ball, reduced):
            y = quiet_state(problem, gamma=gamma, p=p)
            differences.append(value_of(problem, problem.measure.log_density, y) - expected)
    for one in (differences[::2], differences[1::2]):
        np.testing.assert_allclose(one, one[0], atol=1e-13)


def test_chaplygins_density():
    """Eq. (mu-ch), n = 3."""
    for make in (random_special, random_full):
        inertia, D = make(3), getattr(make(3), "D", 1.3)
        problem = ch.classical_problem(inertia, D)
        tensor = np.diag(inertia.moments) if make is random_special else inertia.tensor
        metric = tensor + D * np.eye(3)
        for seed in range(3):
            gamma, _ = random_tangent(3, seed)
            y = quiet_state(problem, gamma=gamma, k=rng_for(3, seed).normal(size=3))
            printed = 1.0 - D * gamma @ np.linalg.solve(metric, gamma)
            got = value_of(problem, problem.measure.log_density, y)
            assert got == pytest.approx(-0.5 * np.log(printed), abs=1e-13)
