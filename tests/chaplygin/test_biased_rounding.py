"""Roundings of a field are as often up as down: what is kept walks at random, and does not drift."""

import numpy as np
import pytest

import chaplygin as ch
from tests.chaplygin.support import Rows

STATES = 20_000


@pytest.mark.parametrize("a", [(0.8, 1.1, 1.5), (0.7, 1.2, 1.4)], ids=str)
def test_the_hamiltonized_field_keeps_tangency_in_the_mean(a):
    """D U − a_i, rounded, is off by 1.7e-16 in the mean for the second of these operators."""
    problem = ch.ChaplyginSphere(a=a, D=4.0).hamiltonized()
    rng = np.random.default_rng(7)
    gamma, p = rng.normal(size=(2, 3, STATES))
    gamma /= np.linalg.norm(gamma, axis=0)
    p -= gamma * np.sum(gamma * p, axis=0)
    p *= 2.0 ** rng.uniform(size=STATES) / np.linalg.norm(p, axis=0)
    out, y = np.empty((6, STATES)), np.concatenate([gamma, p])
    problem.field(problem.params.view(Rows), 0.0, y.view(Rows), out.view(Rows), None)
    wide = out.astype(np.longdouble)
    rates = np.sum(wide[:3] * p + wide[3:] * gamma, axis=0).astype(float)
    assert np.std(rates) < 2e-15
    assert abs(np.mean(rates)) < 4.0 * np.std(rates) / STATES**0.5
