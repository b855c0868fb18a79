"""Where no multiplier exists: the defects, and where they vanish."""

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from chaplygin.manifold import wedge
from tests.chaplygin.support import (
    DIMENSIONS,
    field_of,
    generator_of,
    random_diagonal,
    random_full,
    random_special,
    random_tangent,
    rng_for,
)

ZERO = 1e-12


def momentum(n, seed=0):
    return rng_for(n, seed + 7).normal(size=n * (n - 1) // 2)


def body(n, seed=0):
    return ch.GeneralInertia.from_mass_tensor(rng_for(n, seed).uniform(0.3, 2.0, n))


@pytest.mark.parametrize("n", range(2, 6))
@pytest.mark.parametrize("make", [random_special, random_diagonal, random_full])
def test_the_bracket_gives_the_field(make, n):
    """Π ∂H/∂y is the ball with momentum; H = ½⟨k, ω⟩, differentiated by complex steps."""
    from chaplygin.controls import _omega

    inertia = make(n)
    D, gamma = getattr(inertia, "D", 1.3), random_tangent(n)[0]
    y = np.concatenate([momentum(n), gamma])
    size = len(y) - n

    def energy(z):
        return 0.5 * z[:size] @ _omega(inertia, D, z)

    slope = np.array([energy(y + 1e-30j * e).imag / 1e-30 for e in np.eye(len(y))])
    tensor = ch.almost_poisson_tensor(inertia, D, y)
    np.testing.assert_allclose(tensor, -tensor.T, atol=1e-14)
    expected = field_of(ch.ball_problem(inertia, D), y)
    np.testing.assert_allclose(tensor @ slope, expected, atol=1e-11 * np.max(np.abs(expected)))


@pytest.mark.parametrize("n", range(3, 6))
def test_the_special_operator_without_momentum(n):
    """Not Hamiltonian as it stands, but with the multiplier that the measure prescribes."""
    inertia, (gamma, p) = random_special(n), random_tangent(n)
    defects = ch.multiplier_defects(inertia, inertia.D, gamma, wedge(gamma, p))
    assert defects.dimension == 2 * n - 2
    assert defects.jacobi > 1e-2
    assert defects.closedness < ZERO
    assert defects.measure < ZERO


@pytest.mark.parametrize("make", [random_special, random_diagonal, random_full])
def test_every_ball_in_three_dimensions(make):
    inertia, gamma = make(3), random_tangent(3)[0]
    defects = ch.multiplier_defects(inertia, getattr(inertia, "D", 1.3), gamma, momentum(3))
    assert (defects.closedness < ZERO, defects.measure < ZERO) == (True, True)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("n", [4, 5])
def test_controls(n, seed):
    """The special operator with momentum, and a rigid body without: no multiplier removes dw."""
    inertia, (gamma, p) = random_special(n, seed), random_tangent(n, seed)
    defects = ch.multiplier_defects(inertia, inertia.D, gamma, momentum(n, seed))
    assert defects.measure >= defects.closedness > 1e-2
    defects = ch.multiplier_defects(body(n, seed), 1.3, gamma, wedge(gamma, p))
    assert defects.measure >= defects.closedness > 1e-5


@pytest.mark.parametrize("n", [4, 5])
def test_the_homogeneous_ball(n):
    inertia, (gamma, p) = ch.SpecialInertia.homogeneous(n, 1.3, 2.0), random_tangent(n)
    assert ch.multiplier_defects(inertia, 2.0, gamma, wedge(gamma, p)).jacobi < ZERO


@pytest.mark.parametrize("n", [4, 5])
def test_lagranges_body_is_special(n):
    """With its physical mass tensor: no control, but a case of the theorem."""
    J = np.append(np.full(n - 1, 0.5), 0.9)
    sphere = ch.ChaplyginSphere.from_tensor(J, 1.2, 1.0)
    np.testing.assert_allclose(sphere.inertia.mass_tensor(), J, rtol=1e-13)
    gamma, p = random_tangent(n)
    defects = ch.multiplier_defects(sphere.inertia, sphere.D, gamma, wedge(gamma, p))
    assert defects.closedness < ZERO
    assert {"f-1-2", "r1"} <= set(sphere.reduced().invariants)


@pytest.mark.parametrize("n", [3, 4, 5])
def test_where_lagranges_integrals_hold(n):
    """ω_ij √U, i, j of equal a: constant without momentum; with momentum at n = 3 only (Routh)."""
    a = np.append(np.full(n - 1, 0.8), 1.1)
    problem, (gamma, p) = ch.ChaplyginSphere(a, 4.0).ball(), random_tangent(n)

    def integral(y):
        omega = np.zeros((n, n))
        omega[np.triu_indices(n, 1)] = -generator_of(problem, y)
        direction = y[-n:]
        return omega[0, 1] * np.sqrt(direction @ (direction / a))

    def rate(y):
        h, velocity = 1e-3, gi.derivative(problem, y)
        weights = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
        ends = [
            (integral(y + k * h * velocity), integral(y - k * h * velocity)) for k in range(1, 5)
        ]
        return sum(w * (x - z) for w, (x, z) in zip(weights, ends, strict=True)) / h

    assert abs(rate(problem.state(gamma=gamma, p=p))) < 1e-11
    moving = abs(rate(problem.state(gamma=gamma, k=momentum(n))))
    assert moving < 1e-11 if n == 3 else moving > 1e-3


def test_mass_tensors():
    """J exists in the Lagrange case only, and with its condition; at n = 3 with the triangle's."""
    for n in DIMENSIONS:
        a = np.append(np.full(n - 1, 0.8), 1.1)
        J = ch.SpecialInertia(a, 4.0).mass_tensor()
        again = ch.GeneralInertia.from_mass_tensor(J)
        np.testing.assert_allclose(again.diagonal, ch.SpecialInertia(a, 4.0).diagonal, rtol=1e-12)
        assert again.special(4.0) is not None
    with pytest.raises(gi.DomainError, match="all equal but one"):
        ch.SpecialInertia([0.7, 0.9, 1.2, 1.5], 4.0).mass_tensor()
    a1, D = 1.2, 4.0
    edge = a1 * D / (2 * D - a1 * a1)  # 2a_nD = a_1²a_n + a_1D
    assert ch.SpecialInertia([a1, a1, a1, 1.001 * edge], D).mass_tensor()[-1] > 0.0
    with pytest.raises(gi.DomainError, match=r"positive J; J\[3\]"):
        ch.SpecialInertia([a1, a1, a1, 0.999 * edge], D).mass_tensor()


def test_nothing_to_test():
    with pytest.raises(gi.DomainError, match="not zero"):
        ch.multiplier_defects(random_special(3), random_special(3).D, [0, 0, 1], np.zeros(3))
