"""RATTLE: with a separable Hamiltonian the same map for less; any kinetic energy, odd units."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.methods import rattle
from geomint.problems.testproblems import neumann
from tests.methods.textbook import step
from tests.problems import double_pendulum, frame_in_field, spherical_pendulum

Array = Any
FRAME = frame_in_field.problem()
CASES = {
    "one constraint": (spherical_pendulum.problem(), spherical_pendulum.INITIAL),
    "two": (double_pendulum.problem(), double_pendulum.INITIAL),
    "three": (FRAME, frame_in_field.initial(FRAME)),
    "depending on time": (neumann.problem(season=0.4), neumann.initial()),
}
each_case = pytest.mark.parametrize("case", CASES)


def flagged(problem: gi.Problem, separable: bool) -> gi.Problem:
    form = dataclasses.replace(problem.hamiltonian, separable=separable)
    return dataclasses.replace(problem, hamiltonian=form)


@each_case
@pytest.mark.parametrize("h", [0.02, 0.2])
def test_the_flag_does_not_change_the_map(case: str, h: float) -> None:
    """With and without it: the same states to rounding, for fewer iterations."""
    problem, y0 = CASES[case]
    assert problem.hamiltonian.separable
    run = {"t_end": 15 * h, "step": h, "method": "rattle-2", "compiled": False}
    runs = [gi.solve(flagged(problem, flag), y0, **run) for flag in (True, False)]
    limit = 1e-13 if h > 0.1 else 1e-14
    np.testing.assert_allclose(runs[0].y[-1], runs[1].y[-1], rtol=0, atol=limit)
    assert runs[0].iterations < 0.8 * runs[1].iterations
    assert np.max(np.abs(runs[0].y[-1] - y0)) > 0.05


def test_no_rounding_is_the_same_in_every_step() -> None:
    """h²/2 rounded once, in the increment of q alone, makes the angular momentum drift at h = 0.2."""
    run = {"step": 0.2, "method": "rattle-2", "observe": ["angular-momentum"]}
    drift = gi.solve(*CASES["one constraint"], t_end=2e4, **run).drift["angular-momentum"]
    assert abs(drift.slope) <= 5 * drift.slope_stderr, drift
    assert drift.max_abs_error < 100 * 2.0**-52


@each_case
def test_any_size_is_served(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The stepper for any number of rows and constraints gives the bits of the unrolled one."""
    problem, y0 = CASES[case]
    for flag in (True, False):
        ends = []
        for largest in (9, 0):
            monkeypatch.setattr(rattle, "MAX_UNROLLED_ROWS", largest)
            fresh = flagged(problem, flag)
            motion = gi.Integrator(fresh, y0, "rattle-2", step=0.05, compiled=False)
            motion.step(10)
            ends.append(motion.restart.memory)
        np.testing.assert_array_equal(ends[0], ends[1])


def test_a_clock_row() -> None:
    """Physical time of a problem in τ: the trapezoidal rule, with and without the flag."""

    @gi.observable
    def rate(params, t, y, work):
        return 1.0 + y[2] * y[2] + 0.2 * t

    base, y0 = CASES["one constraint"]
    timed = dataclasses.replace(base, time="tau", clock=rate)
    run = {"tau_end": 2.0, "compiled": False}
    times = [
        gi.solve(flagged(timed, flag), y0, step=0.05, method="rattle-4", **run).t[-1]
        for flag in (True, False)
    ]
    exact = gi.solve(timed, y0, step=0.1, method="gauss-8", **run).t[-1]
    assert times[0] == pytest.approx(times[1], abs=1e-14)
    assert 1e-12 < abs(times[0] - exact) < 1e-6


@pytest.mark.parametrize("speed", [1e-150, 1e-8, 1e8])
def test_any_scale_of_momenta(speed: float) -> None:
    """A free point on the sphere: the same orbit at any speed, in steps of the same angle."""
    problem, y0 = spherical_pendulum.problem(0.0), spherical_pendulum.INITIAL
    ends = []
    for unit in (1.0, speed):
        scale = np.repeat([1.0, unit], 3)
        run = {"t_end": 5.0 / unit, "step": 0.05 / unit, "method": "rattle-2", "compiled": False}
        ends.append(gi.solve(problem, y0 * scale, **run).y[-1] / scale)
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=1e-12)


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


# --- energies and units ---------------------------------------------------------------------------

Q0, P0 = np.array([0.6, 0.0, 0.8]), np.array([0.8, 1.0, -0.6])


def kinetic(velocity: Any) -> Any:
    """The gradients of H = T(p) + q₃, whose ∂T/∂p is p times a function of |p|²."""
    of = gi.helper(velocity)

    @gi.helper
    def gradients(params, t, q, p, dq, dp, work):
        s = of(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
        for i in range(3):
            dq[i] = 0.0 * q[i]
            dp[i] = s * p[i]
        dq[2] = 1.0 + 0.0 * q[2]

    return gradients


KINDS = {
    "quartic": kinetic(lambda square: 1.0 + 0.1 * square),
    "relativistic": kinetic(lambda square: 1.0 / gi.sqrt(1.0 + square)),
    "plain": kinetic(lambda square: 1.0 + 0.0 * square),
}


@gi.helper
def scaled_sphere(params, q, g, G, work):
    g[0] = 0.5 * params[0] * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] - 1.0)
    for i in range(3):
        G[i] = params[0] * q[i]


def pendulum(energy: Any, scale: float = 1.0, separable: bool = False) -> gi.Problem:
    form = gi.Hamiltonian(energy, scaled_sphere, 1, separable=separable)
    return gi.Problem("top-of-a-rod", (("q", 3), ("p", 3)), params=[scale], hamiltonian=form)


@pytest.mark.parametrize("energy", ["quartic", "relativistic"])
@pytest.mark.parametrize("p0", [P0, 0.0 * P0], ids=["moving", "at rest"])
@pytest.mark.parametrize("name", ["rattle-2", "rattle-4", "lobatto-3"])
def test_any_kinetic_energy(energy: str, p0: Array, name: str) -> None:
    """Steps are those of the textbook, and p stays tangent: (q, ∂H/∂p) = 0 to rounding."""
    problem, y0 = pendulum(KINDS[energy]), np.concatenate([Q0, p0])
    motion = gi.Integrator(problem, y0, name, step=0.1, compiled=False)
    motion.step()
    y = motion.state
    np.testing.assert_allclose(y, step(motion.method, problem, 0.0, y0, 0.1), rtol=0, atol=2e-15)
    assert abs(y[:3] @ y[3:]) < 1e-15


@pytest.mark.parametrize("separable", [True, False])
@pytest.mark.parametrize("scale", [1e-300, 1e-160, 1e-100, 1e100, 1e152, 1e154, 1e160, 1e300])
def test_a_constraint_in_any_unit_holds_or_is_refused(scale: float, separable: bool) -> None:
    """Numbers that overflow or underflow are an error, never a motion without the constraint."""
    y0 = np.concatenate([Q0, P0])
    problem = pendulum(KINDS["plain"], scale, separable)
    try:
        run = gi.solve(problem, y0, t_end=0.2, step=0.02, method="rattle-2", compiled=False)
    except gi.StepError:
        assert not 1e-110 < scale < 1e110
        return
    assert np.linalg.norm(run.y[-1, :3]) == pytest.approx(1.0, abs=1e-14)
