"""Geodesics of the ellipsoid: their forms, integrals, states, and their Gauss map."""

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from chaplygin.commuting_integrals import coefficient_tables
from chaplygin.related.ellipsoid import chasles_integral
from geomint.kernels.numbers.blocks import Block
from tests.chaplygin.support import (
    DIMENSIONS,
    extended,
    field_of,
    gradients_of,
    mp,
    quiet_state,
    random_body,
    random_geodesic,
    rate,
    rng_for,
    value_of,
)


def close(x, y, size=1.0):
    np.testing.assert_allclose(np.array(x, float), np.array(y, float), rtol=0, atol=4e-14 * size)


def start(n, seed=0):
    a = random_body(n, seed).a
    x, p = random_geodesic(a, seed)
    problem = ch.ellipsoid_problem(a)
    return a, problem, quiet_state(problem, x=x, p=p)


@pytest.mark.parametrize("n", DIMENSIONS)
def test_field_is_the_newtonian_one(n):
    """ẍ is normal, and the motion stays on the ellipsoid: (x, A⁻¹x)˙˙ = 0."""
    a, problem, y = start(n)
    x, p = y[:n], y[n:]
    out = field_of(problem, y)
    close(out[:n], p, 10)
    force, normal = out[n:], x / a
    close(force - (force @ normal) / (normal @ normal) * normal, 0.0 * x, 10)
    assert abs(p @ (p / a) + normal @ force) < 1e-12


@pytest.mark.parametrize("n", DIMENSIONS)
def test_hamiltonian_form_gives_the_field(n):
    a, problem, y = start(n)
    form = problem.hamiltonian
    assert form.separable
    assert form.constraints == 1
    dq, dp = gradients_of(problem, y)
    out, normal = field_of(problem, y), y[:n] / a
    close(dq, np.zeros(n))
    close(dp, out[:n], 10)
    rest = -dq - out[n:]
    close(rest - (rest @ normal) / (normal @ normal) * normal, np.zeros(n), 10)
    q, g, jacobian = rng_for(n, 51).normal(size=n), np.zeros(1), np.zeros(n)
    empty = Block(np.zeros(0))
    form.constraint(Block(problem.params), Block(q), Block(g), Block(jacobian), empty)
    assert g[0] == pytest.approx(0.5 * (q @ (q / a) - 1.0), rel=1e-14)
    close(jacobian, q / a)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("n", DIMENSIONS)
def test_gauss_map_takes_geodesics_to_the_veselova_problem(n, seed):
    """γ = A⁻¹x/|A⁻¹x|, p = ẋ, dt = U^(3/2) ds, with 1/a_i for the a_i of the body."""
    a, problem, y = start(n, seed)
    body = ch.Veselova(1.0 / a).reduced()

    def gauss(state):
        normal = state[:n] / extended(a)
        return np.concatenate([normal / mp.sqrt(normal @ normal), state[n:]])

    h, exact = mp.mpf("1e-15"), extended(y)
    velocity = field_of(problem, exact)
    pushed = (gauss(exact + h * velocity) - gauss(exact - h * velocity)) / (2 * h)
    image = gauss(exact)
    u = image[:n] @ (image[:n] * extended(a))
    close(pushed, field_of(body, image) * u ** mp.mpf("1.5"), 100)
    double = float(2 * value_of(body, "energy", image))
    assert double == pytest.approx(value_of(problem, "joachimsthal", y), rel=1e-12)
    square = float(value_of(body, "K", image))
    assert square == pytest.approx(2 * value_of(problem, "energy", y), rel=1e-12)


def coefficients(a, problem, y):
    """Return F_0, …, F_(n−1)."""
    n = len(a)
    tables = coefficient_tables(a, range(n), 0)
    params = np.concatenate([1.0 / a, tables])
    other = gi.Problem(name="all", pieces=problem.pieces, params=params, field=problem.field)
    return [value_of(other, chasles_integral(n, k), y) for k in range(n)]


@pytest.mark.parametrize("n", DIMENSIONS)
def test_the_integrals_are_those_of_jacobi_and_chasles(n):
    """F(a_i)/P′(a_i) = p_i² + Σ_j m_ij²/(a_i − a_j); F_0 = 0, F_1 = (−1)ⁿ JΠa, F_(n−1) = 2H."""
    a, problem, y = start(n)
    x, p = y[:n], y[n:]
    F = coefficients(a, problem, y)
    size = np.max(np.abs(F))
    assert abs(F[0]) < 1e-13 * size
    assert F[n - 1] == pytest.approx(p @ p, rel=1e-13)
    J = value_of(problem, "joachimsthal", y)
    assert F[1] == pytest.approx((-1) ** n * J * np.prod(a), abs=1e-13 * size)
    for k in range(2, n - 1):
        assert value_of(problem, f"F{k}", y) == pytest.approx(F[k], rel=1e-13)
    for i in range(n):
        others = np.delete(np.arange(n), i)
        m = x[i] * p[others] - x[others] * p[i]
        derivative = np.prod(a[i] - a[others])
        expected = p[i] ** 2 + np.sum(m**2 / (a[i] - a[others]))
        value = np.polyval(F[::-1], a[i])
        assert value == pytest.approx(expected * derivative, abs=1e-12 * size)


def test_a_sphere_and_other_equal_axes():
    """All integrals are finite and constant; on the sphere of radius 2 geodesics are circles."""
    problem = ch.ellipsoid_problem([1.5, 1.5, 2.0, 2.0, 2.0])
    x, p = random_geodesic(np.array([1.5, 1.5, 2.0, 2.0, 2.0]))
    y = extended(quiet_state(problem, x=x, p=p))
    velocity = field_of(problem, y)
    for name in problem.invariants:
        assert np.isfinite(float(value_of(problem, name, y)))
        assert abs(rate(problem, name, y, velocity)) < 1e-14
    round_one = ch.ellipsoid_problem([4.0, 4.0, 4.0])
    y = quiet_state(round_one, x=[2.0, 0.0, 0.0], p=[0.0, 1.0, 0.0])
    end = gi.solve(round_one, y, t_end=4 * np.pi, method="gauss-8", progress=False).y[-1]
    np.testing.assert_allclose(end, y, atol=1e-12)


def test_states():
    problem = ch.ellipsoid_problem([1.0, 4.0, 9.0])
    with pytest.warns(gi.GeomintWarning, match=r"√\(x, x/a\) is 0.5, not 1"):
        y = problem.state(x=[0.0, 1.0, 0.0], p=[1.0, 0.0, 2.0])
    np.testing.assert_allclose(y, [0, 2, 0, 1, 0, 2])
    with pytest.warns(gi.GeomintWarning, match=r"\(normal, p\)/\|p\|"):
        y = problem.state(x=[0.0, 2.0, 0.0], p=[1.0, 0.5, 2.0])
    np.testing.assert_allclose(y, [0, 2, 0, 1, 0, 2])
    for scale in (1e-140, 1e140):
        with pytest.warns(gi.GeomintWarning):
            far = problem.state(x=scale * np.array([1.0, 1.0, 1.0]), p=[0.0, 0.0, 0.0])
        assert abs(value_of(problem, "ellipsoid", far)) < 1e-15
    np.testing.assert_array_equal(problem.canonical(y), y)
    with pytest.warns(gi.GeomintWarning, match="of the state"):
        repaired = problem.canonical(y * (1 + 1e-8))
    assert abs(value_of(problem, "ellipsoid", repaired)) < 1e-15
    for bad in (y * 1.001, y + np.array([0, 0, 0, 0, 0.01, 0])):
        with pytest.raises(gi.DomainError):
            problem.canonical(bad)


@pytest.mark.parametrize(
    ("a", "state", "text"),
    [
        ([1.0], {}, "n ≥ 2"),
        ([1.0, 0.0], {}, r"a\[1\] is not"),
        ([1.0, float("nan")], {}, "finite"),
        ([1.0, 4.0], {"x": [0.0, 0.0], "p": [1.0, 0.0]}, "not zero"),
        ([1.0, 4.0], {"x": [1.0, 0.0], "p": [1.0, 0.0]}, "parallel to normal"),
        ([1.0, 4.0], {"x": [1.0, 0.0]}, "p is missing"),
        ([1.0, 4.0], {"x": [1.0], "p": [1.0, 0.0]}, "x = "),
    ],
)
def test_bad_input_is_named(a, state, text):
    with pytest.raises(gi.DomainError, match=text):
        ch.ellipsoid_problem(a).state(**state)


def test_methods_of_both_forms_agree():
    problem = ch.ellipsoid_problem([1.0, 4.0, 9.0])
    y = quiet_state(problem, x=[0.0, 0.0, 3.0], p=[0.8, 0.6, 0.0])
    gauss = gi.solve(problem, y, t_end=5.0, method="gauss-8", step=0.1, progress=False).y[-1]
    rattle = gi.solve(problem, y, t_end=5.0, method="rattle-6", step=0.02, progress=False).y[-1]
    np.testing.assert_allclose(rattle, gauss, atol=1e-8)
