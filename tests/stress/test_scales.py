"""What stress has found: scales at which methods and defaults stopped working, and no longer do."""

import warnings

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.compare.reference import reference_solution
from geomint.problems.evaluate import rounding_scale
from geomint.problems.time_scale import characteristic_time

SPHERE = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)
GAMMA = np.array([1.0, 2.0, 2.0]) / 3.0
P = np.array([2.0, -1.0, 0.0])


@pytest.mark.parametrize("power", [-500, -60, 40, 60, 251, 500])
@pytest.mark.parametrize("method", ["rattle-2", "verlet-2", "gauss-4"])
def test_methods_know_no_unit_of_momentum(method, power):
    """p times a power of two is the same motion in another unit of time, to the last bit."""
    problem, ends = SPHERE.hamiltonized(), []
    for size in (1.0, 2.0**power):
        y0 = problem.state(gamma=GAMMA, p=size * P)
        run = {"tau_end": 0.05 / size, "step": 0.01 / size, "clock": False, "progress": False}
        y = gi.solve(problem, y0, method=method, **run).y[-1]
        ends.append(np.concatenate([y[:3], y[3:] / size]))
    np.testing.assert_array_equal(ends[0], ends[1])


@pytest.mark.parametrize("power", [-500, 500])
def test_scales_of_quantities_know_no_unit(power):
    problem, size = SPHERE.hamiltonized(), 2.0**power
    energy = problem.invariants["energy"]
    one, other = (
        rounding_scale(problem, energy, problem.state(gamma=GAMMA, p=factor * P))
        for factor in (1.0, size)
    )
    assert other / size / size == one


@pytest.mark.parametrize("power", [-500, -400, 500])
@pytest.mark.nojit
def test_characteristic_time_of_any_size(power):
    problem = SPHERE.reduced()
    one = characteristic_time(problem, problem.state(gamma=GAMMA, p=P))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        other = characteristic_time(problem, problem.state(gamma=GAMMA, p=2.0**power * P))
    assert other == pytest.approx(one / 2.0**power, rel=1e-14)


@pytest.mark.nojit
def test_no_default_step_where_the_derivative_overflows():
    problem = SPHERE.reduced()
    y0 = problem.state(gamma=GAMMA, p=2.0**600 * P)
    with pytest.raises(gi.DomainError, match="finite derivative"):
        gi.solve(problem, y0, t_end=1.0)


def test_reference_at_tiny_times():
    """The steps of the reference were rounded as float32, which has no number below 1e-45."""
    problem, size = SPHERE.reduced(), 2.0**200
    one = reference_solution(problem, problem.state(gamma=GAMMA, p=P), 1.0)
    other = reference_solution(problem, problem.state(gamma=GAMMA, p=size * P), 1.0 / size)
    np.testing.assert_array_equal(other.y[:3], one.y[:3])
    np.testing.assert_array_equal(other.y[3:], size * one.y[3:])
