"""What stress has found: scales at which methods and defaults stopped working, and no longer do."""

import warnings

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi

SPHERE = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)
GAMMA = np.array([1.0, 2.0, 2.0]) / 3.0
P = np.array([2.0, -1.0, 0.0])


@pytest.mark.parametrize("power", [-500, -60, 40, 251, 500])
@pytest.mark.parametrize("method", ["rattle-2", "verlet-2", "gauss-4"])
def test_methods_know_no_unit_of_momentum(method, power):
    """p times a power of two is the same motion in another unit of time, to the last bit."""
    problem, ends = SPHERE.hamiltonized(), []
    for size in (1.0, 2.0**power):
        y0 = problem.state(gamma=GAMMA, p=size * P)
        run = {"tau_end": 0.05 / size, "step": 0.01 / size, "clock": False, "compiled": False}
        sol = gi.solve(problem, y0, method=method, **run, observe=["energy"])
        y, scale = sol.y[-1], sol.drift["energy"].scale
        ends.append(np.concatenate([y[:3], y[3:] / size, [scale / size / size]]))
    np.testing.assert_array_equal(ends[0], ends[1])


@pytest.mark.parametrize("power", [-500, -400, 500])
@pytest.mark.nojit
def test_default_steps_know_no_unit(power):
    problem, method = SPHERE.reduced(), gi.find_method("rk-4")
    one = method.default_step(problem, problem.state(gamma=GAMMA, p=P), 1e9)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fast = problem.state(gamma=GAMMA, p=2.0**power * P)
        other = method.default_step(problem, fast, 1e9 / 2.0**power)
    assert other == pytest.approx(one / 2.0**power, rel=1e-14)


@pytest.mark.nojit
def test_no_default_step_where_the_derivative_overflows():
    problem = SPHERE.reduced()
    y0 = problem.state(gamma=GAMMA, p=2.0**600 * P)
    with pytest.raises(gi.DomainError, match="finite derivative"):
        gi.solve(problem, y0, t_end=1.0)
