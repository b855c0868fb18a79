"""Actions, rotation numbers, resonances and critical values of the exact flow."""

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from tests.chaplygin.support import random_special


@pytest.mark.parametrize("n", [2, 3, 4])
def test_frequencies_are_the_derivatives_of_the_energy_by_the_actions(n):
    """ω = ∂H/∂J: along any change of the state, dH = ω·dJ."""
    problem = ch.ChaplyginSphere(inertia=random_special(n, 1)).hamiltonized()
    y = problem.random_state(2)
    exact = problem.exact(y)
    rng, h = np.random.default_rng(100 + n), 1e-3

    def at(state):
        admitted = problem.state(gamma=state[:n], p_tilde=state[n:])
        return gi.value(problem, "energy", admitted), ch.action_variables(problem.exact(admitted))

    direction = rng.normal(size=n)
    direction -= (direction @ y[:n]) * y[:n]
    change = np.concatenate([np.zeros(n), direction]) * np.linalg.norm(y[n:])
    weights = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
    dH, dJ = 0.0, 0.0
    for k, w in enumerate(weights, 1):
        (above, J_above), (below, J_below) = at(y + k * h * change), at(y - k * h * change)
        dH, dJ = dH + w * (above - below) / h, dJ + w * (J_above - J_below) / h
    assert exact.frequencies @ dJ == pytest.approx(dH, rel=1e-7)
    assert np.all(np.abs(dJ) > 1e-6)


def test_the_map_of_a_family():
    """States next to a separatrix are refused, one by one; steady ones have one frequency."""
    problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
    states = [problem.random_state(seed) for seed in range(3)]
    states += [np.concatenate([states[0][:3], 7.0 * states[0][3:]])]
    states += [problem.state(gamma=[1.0, 0, 0], p_tilde=[0, *p]) for p in ([1e-7, 0.2], [1.0, 0])]
    found = ch.frequency_map(problem, states)
    assert found.frequencies.shape == (6, 2)
    assert list(found.refused) == [4]
    assert np.isnan(found.frequencies[4]).all()
    np.testing.assert_array_equal(np.isnan(found.frequencies[5]), [False, True])
    np.testing.assert_allclose(found.rotation_numbers[3], found.rotation_numbers[0], rtol=1e-12)
    np.testing.assert_allclose(found.frequencies[3], 7.0 * found.frequencies[0], rtol=1e-12)


def test_resonances():
    assert ch.resonances([1.0, -2.0 / 3.0], 4) == [(2, 3)]
    assert ch.resonances([1.0, 1.0, 2.0], 1) == [(1, -1, 0), (1, 1, -1)]
    assert (2, 0, -1) in ch.resonances([1.0, 1.0, 2.0], 2)
    assert ch.resonances([1.0, np.sqrt(2.0)], 50) == []
    assert ch.resonances([1e200, 2e200], 2) == [(2, -1)]
    for omega in (1.0, [[1.0, 2.0]], [np.nan, 1.0], [0.0, 0.0]):
        with pytest.raises(gi.DomainError, match="omega"):
            ch.resonances(omega, 2)
    with pytest.raises(gi.DomainError, match="order"):
        ch.resonances([1.0, 2.0], 2.5)


def test_critical_energies():
    """Steady turns about the axes; all states lie between the least and the largest."""
    a, D = np.array([0.8, 1.1, 1.5]), 4.0
    sphere = ch.ChaplyginSphere(a, D)
    problem, found = sphere.reduced(), ch.critical_energies(a, D, 2.0)
    np.testing.assert_allclose(found, 2.0 / (2.0 * (sphere.inertia.moments + D)), rtol=1e-14)
    for i in range(3):
        gamma = np.roll([0.6, 0.8, 0.0], i + 1)
        p = np.sqrt(2.0) * np.roll([-0.8, 0.6, 0.0], i + 1)
        axis = int(np.flatnonzero((gamma == 0.0) & (p == 0.0))[0])
        y = problem.state(gamma=gamma, p=p)
        assert gi.value(problem, "energy", y) == pytest.approx(found[axis], rel=1e-13)
    for seed in range(30):
        y = problem.random_state(seed)
        level = gi.value(problem, "energy", y) / gi.value(problem, "K", y) * 2.0
        assert min(found) <= level <= max(found)
    with pytest.raises(gi.DomainError):
        ch.critical_energies([1.0, 2.0], 4.0)
