"""Where no multiplier exists: the defects, and where they vanish."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import chaplygin as ch
import geomint as gi
from tests.chaplygin.exact_support import WEIGHTS
from tests.chaplygin.support import (
    MAKERS,
    flat_wedge,
    generator_of,
    kinds,
    operator_of,
    random_special,
    random_tangent,
    random_triangle,
    rng_for,
    seeds,
)
from tests.rows import examples

ZERO = 1e-12


@given(st.integers(2, 5), kinds, seeds)
@examples(6)
def test_the_bracket_gives_the_field(n, kind, seed):
    """Π ∂H/∂y is the ball with momentum, H = ½⟨k, ω⟩."""
    inertia, D = operator_of(kind, n, seed)
    problem, (gamma, _) = ch.ball_problem(inertia, D), random_tangent(n, seed)
    y = np.concatenate([random_triangle(n, seed), gamma])
    tensor = ch.almost_poisson_tensor(inertia, D, y)
    np.testing.assert_allclose(tensor, -tensor.T, atol=1e-14)
    expected = gi.derivative(problem, y)
    found = tensor @ gi.gradient(problem, "energy", y)
    np.testing.assert_allclose(found, expected, atol=1e-11 * np.max(np.abs(expected)))


@pytest.mark.parametrize("n", range(3, 6))
def test_the_special_operator_without_momentum(n):
    """Not Hamiltonian as it stands, but with the multiplier that the measure prescribes."""
    inertia, (gamma, p) = random_special(n), random_tangent(n)
    defects = ch.multiplier_defects(inertia, inertia.D, gamma, flat_wedge(gamma, p))
    assert defects.dimension == 2 * n - 2
    assert defects.jacobi > 1e-2
    assert max(defects.closedness, defects.measure) < ZERO


@pytest.mark.parametrize("kind", MAKERS)
def test_every_ball_in_three_dimensions(kind):
    inertia, D = operator_of(kind, 3)
    defects = ch.multiplier_defects(inertia, D, random_tangent(3)[0], random_triangle(3))
    assert max(defects.closedness, defects.measure) < ZERO


@pytest.mark.parametrize("n", [4, pytest.param(5, marks=pytest.mark.nightly)])
def test_controls(n):
    """The special operator with momentum, and a rigid body without: no multiplier removes dw."""
    inertia, (gamma, p) = random_special(n), random_tangent(n)
    defects = ch.multiplier_defects(inertia, inertia.D, gamma, random_triangle(n))
    assert defects.measure >= defects.closedness > 1e-2
    body = ch.GeneralInertia.from_mass_tensor(rng_for(n).uniform(0.3, 2.0, n))
    defects = ch.multiplier_defects(body, 1.3, gamma, flat_wedge(gamma, p))
    assert defects.measure >= defects.closedness > 1e-5
    # Lagrange's body is no control, but a case of the theorem; of the homogeneous ball Jacobi holds.
    lagrange = ch.ChaplyginSphere.from_tensor(np.append(np.full(n - 1, 0.5), 0.9), 1.2, 1.0)
    defects = ch.multiplier_defects(lagrange.inertia, lagrange.D, gamma, flat_wedge(gamma, p))
    assert defects.closedness < ZERO
    assert {"f-1-2", "r1"} <= set(lagrange.reduced().invariants)
    even = ch.SpecialInertia.homogeneous(n, 1.3, 2.0)
    assert ch.multiplier_defects(even, 2.0, gamma, flat_wedge(gamma, p)).jacobi < ZERO


@pytest.mark.parametrize("n", [3, 4, 5])
def test_where_lagranges_integrals_hold(n):
    """ω_ij √U, i, j of equal a: constant without momentum; with momentum at n = 3 only (Routh)."""
    a = np.append(np.full(n - 1, 0.8), 1.1)
    problem, (gamma, p) = ch.ChaplyginSphere(a, 4.0).ball(), random_tangent(n)

    def rate(y):
        velocity, found = gi.derivative(problem, y), []
        for k in range(-4, 5):
            z = y + 1e-3 * k * velocity
            found.append(-generator_of(problem, z)[0] * np.sqrt(z[-n:] @ (z[-n:] / a)))
        return abs(WEIGHTS @ found) / 1e-3

    assert rate(problem.state(gamma=gamma, p=p)) < 1e-11
    moving = rate(problem.state(gamma=gamma, k=random_triangle(n)))
    assert moving < 1e-11 if n == 3 else moving > 1e-3


def test_nothing_to_test():
    with pytest.raises(gi.DomainError, match="not zero"):
        ch.multiplier_defects(random_special(3), random_special(3).D, [0, 0, 1], np.zeros(3))
