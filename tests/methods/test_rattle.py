"""RATTLE with a separable Hamiltonian: the same map as without the flag, for less."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.numbers.blocks import Block, scalar_block
from geomint.kernels.solve.small_matrices import solve_small
from geomint.methods import Start
from geomint.problems.testproblems import neumann
from tests.problems import double_pendulum, frame_in_field, spherical_pendulum

FRAME = frame_in_field.problem()
CASES = {
    "one constraint": (spherical_pendulum.problem(), spherical_pendulum.INITIAL),
    "two": (double_pendulum.problem(), double_pendulum.INITIAL),
    "three": (FRAME, frame_in_field.initial(FRAME)),
    "depending on time": (neumann.problem(season=0.4), neumann.initial()),
}
each_case = pytest.mark.parametrize(
    "case", [pytest.param(case, marks=[pytest.mark.nightly] * (case == "two")) for case in CASES]
)


def flagged(problem: gi.Problem, separable: bool) -> gi.Problem:
    form = dataclasses.replace(problem.hamiltonian, separable=separable)
    return dataclasses.replace(problem, hamiltonian=form)


@each_case
@pytest.mark.parametrize("h", [0.02, 0.2])
def test_the_flag_does_not_change_the_map(case: str, h: float) -> None:
    """A hundred steps with and without it: the same states to rounding, for fewer iterations."""
    problem, y0 = CASES[case]
    assert problem.hamiltonian.separable
    runs = [
        gi.solve(flagged(problem, flag), y0, t_end=100 * h, step=h, method="rattle-2")
        for flag in (True, False)
    ]
    np.testing.assert_allclose(
        runs[0].y[-1], runs[1].y[-1], rtol=0, atol=2e-13 if h > 0.1 else 2e-14
    )
    assert runs[0].iterations < 0.8 * runs[1].iterations
    assert np.max(np.abs(runs[0].y[-1] - y0)) > 0.05


def test_no_rounding_is_the_same_in_every_step() -> None:
    """h²/2 rounded once, in the increment of q alone, makes the angular momentum drift at h = 0.2."""
    problem, y0 = CASES["one constraint"]
    sol = gi.solve(
        problem, y0, t_end=2e4, step=0.2, method="rattle-2", observe=["angular-momentum"]
    )
    drift = sol.drift["angular-momentum"]
    assert abs(drift.slope) <= 5 * drift.slope_stderr, drift
    assert drift.max_abs_error < 100 * 2.0**-52


@each_case
def test_any_size_is_served(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The stepper for any number of rows and constraints gives the bits of the unrolled one."""
    from geomint.methods import rattle

    problem, y0 = CASES[case]
    for flag in (True, False):
        ends = []
        for largest in (9, 0):
            monkeypatch.setattr(rattle, "MAX_UNROLLED_ROWS", largest)
            stepper = gi.find_method("rattle-2").start(Start(flagged(problem, flag), y0, 0.0, 0.05))
            assert stepper.advance(0, 50, 50, scalar_block(stepper.rows)).status == 0
            ends.append(stepper.memory.data.copy())
        np.testing.assert_array_equal(ends[0], ends[1])


def test_a_clock_row() -> None:
    """Physical time of a problem in τ: the trapezoidal rule, with and without the flag."""

    @gi.observable
    def rate(params, t, y, work):
        return 1.0 + y[2] * y[2] + 0.2 * t

    base, y0 = CASES["one constraint"]
    times = []
    for flag in (True, False):
        problem = dataclasses.replace(flagged(base, flag), time="tau", clock=rate)
        sol = gi.solve(problem, y0, tau_end=2.0, step=0.05, method="rattle-4", save_every=40)
        times.append(sol.t[-1])
    exact = gi.solve(
        dataclasses.replace(base, time="tau", clock=rate),
        y0,
        tau_end=2.0,
        step=0.05,
        method="gauss-8",
        save_every=40,
    ).t[-1]
    assert times[0] == pytest.approx(times[1], abs=1e-14)
    assert 1e-12 < abs(times[0] - exact) < 1e-6


@pytest.mark.parametrize("speed", [1e-150, 1e-8, 1e8])
def test_any_scale_of_momenta(speed: float) -> None:
    """A free point on the sphere: the same orbit at any speed, in steps of the same angle."""
    problem = spherical_pendulum.problem(0.0)
    y0 = spherical_pendulum.INITIAL
    scale = np.repeat([1.0, speed], 3)
    slow = gi.solve(problem, y0, t_end=5.0, step=0.05, method="rattle-2").y[-1]
    fast = gi.solve(problem, y0 * scale, t_end=5.0 / speed, step=0.05 / speed, method="rattle-2").y[
        -1
    ]
    np.testing.assert_allclose(fast / scale, slow, rtol=0, atol=1e-12)


@pytest.mark.nojit
@pytest.mark.parametrize("h", [9.0, 40.0])
def test_a_step_without_solution(h: float) -> None:
    """The line along the normal misses the sphere: a typed error, and the start is kept."""
    problem, y0 = CASES["one constraint"]
    with pytest.raises(gi.ConvergenceError, match="too large") as caught:
        gi.solve(problem, y0, t_end=10 * h, step=h, method="rattle-2", compiled=False)
    np.testing.assert_array_equal(caught.value.partial.y[-1], y0)
    assert caught.value.iterations == 200


@gi.field
def hole(params, t, q, p, dq, dp, work):
    for i in range(3):
        dq[i] = gi.sqrt(q[2] + 0.85) if i == 2 else 0.0 * q[i]
        dp[i] = 1.0 * p[i]


@pytest.mark.nojit
def test_a_force_that_ends() -> None:
    """NaN of ∂V/∂q, met only after the multipliers have been found, is never a state."""
    base = spherical_pendulum.problem()
    form = dataclasses.replace(base.hamiltonian, gradients=hole)
    problem = dataclasses.replace(base, hamiltonian=form)
    y0 = [0.6, 0.0, -0.8, 0.0, 0.2, 0.0]
    told = pytest.warns(gi.GeomintWarning, match="field and hamiltonian .* are not one motion")
    with told, pytest.raises(gi.NonFiniteError) as caught:
        gi.solve(problem, y0, t_end=9.0, step=0.05, method="rattle-2", save_every=1, compiled=False)
    assert 0.0 < caught.value.t < 9.0
    assert np.isfinite(caught.value.partial.y).all()


@pytest.mark.nojit
def test_options() -> None:
    """Fewer iterations for a tolerance; the cap is a typed error."""
    problem, y0 = CASES["three"]
    kwargs = {"t_end": 2.0, "step": 0.1, "compiled": False}
    exact = gi.solve(problem, y0, method=gi.Rattle(), **kwargs)
    rough = gi.solve(problem, y0, method=gi.Rattle(iteration_tolerance=1e-6), **kwargs)
    assert rough.iterations < exact.iterations
    assert 1e-15 < np.max(np.abs(rough.y[-1] - exact.y[-1])) < 1e-4
    with pytest.raises(gi.ConvergenceError) as caught:
        gi.solve(problem, y0, method=gi.Rattle(max_iterations=1), **kwargs)
    assert caught.value.iterations == 1


@pytest.mark.nojit
@pytest.mark.parametrize("m", [1, 2, 3, 5])
def test_small_systems(m: int) -> None:
    """Elimination without exchanges, for definite matrices that need not be symmetric."""
    rng = np.random.default_rng(m)
    factor = rng.normal(size=(m, m))
    matrix = factor @ factor.T + np.eye(m) + 0.1 * rng.normal(size=(m, m))
    right = rng.normal(size=m)
    solution = Block(right.copy())
    solve_small(m, Block(matrix.ravel().copy()), solution)
    np.testing.assert_allclose(matrix @ solution.data, right, atol=1e-12)
