"""Accepted means solved: the equations of implicit steps, evaluated again outside of the kernels.

A residual is measured in ε times the size of its piece of the state: the largest of the piece before
the step, after it, and of h times its rate. RATTLE's multipliers are left free: what is along the
normals of the constraint is their business, only the rest of an equation for p is a residual.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import neumann
from geomint.tableaux import gauss_legendre
from tests.methods.first_steps import KINDS, problems, states
from tests.methods.stage_increments import increments
from tests.methods.textbook import constraint, gradients

Array = Any
EPSILON = 2.0**-52
# Rounding of a stage is carried on by the iteration: 1/(1 − κ) times, κ its contraction.
BOUND = 80.0
LENGTHS = (1.0, 0.5, 0.1, 1e-3, 1e-8)  # of steps, in default ones of another state
# Where those are too long for many states: they fail, and that is all they may do.
TOO_LONG = {"nearly at rest": 0.4, "other sizes": 0.4}
T0 = 0.25


def taken(motion: gi.Integrator, y: Array, h: float) -> bool:
    """Whether one step from there was accepted."""
    motion.reset(y, T0)
    motion.h = h
    try:
        motion.step()
    except gi.StepError:
        return False
    return True


def stage_residual(motion: gi.Integrator, stages: int, y0: Array, h: float) -> float:
    """The largest residual of L_i = h b_i f(t + c_i h, y + Σ μ_ij L_j)."""
    problem, table, L = motion.problem, gauss_legendre(stages), increments(motion.stepper, stages)
    Y = y0 + table.mu @ L
    times = T0 + table.c * h
    F = h * np.array([gi.derivative(problem, y, t, "field") for y, t in zip(Y, times, strict=True)])
    defect, worst = np.abs(table.b[:, None] * F - L), 0.0
    for piece in problem.slices.values():
        parts = (x[..., piece] for x in (F, y0, motion.state))
        size = max(1e-300, *(np.abs(x).max() for x in parts))
        worst = max(worst, defect[:, piece].max() / (EPSILON * size))
    return worst


def first_steps(
    kind: str, stages: int, count: int, few: bool, tolerance: float = 0.0
) -> tuple[int, int]:
    """Take first steps; all that are accepted are solved. Return how many were, and how many failed."""
    bound = max(BOUND, 4.0 * tolerance / EPSILON)
    accepted = failed = 0
    for problem, start in problems("field", few)[:: 2 if few else 1]:
        h0 = gi.Gauss(8).default_step(problem, start, 1.0)
        rng = np.random.default_rng([stages, problem.rows])
        method = gi.Gauss(stages, iteration="fixed-point", iteration_tolerance=tolerance)
        motion = gi.Integrator(problem, start, method, step=h0, compiled=not few)
        for y in states(problem, start, kind, count, seed=stages):
            h = h0 * rng.choice(LENGTHS)
            if taken(motion, y, h):
                accepted += 1
                worst = stage_residual(motion, stages, y, h)
                assert worst <= bound, (problem.name, kind, y, h, worst)
            else:
                failed += bool(np.isfinite(gi.derivative(problem, y, T0, "field")).all())
    return accepted, failed


@pytest.mark.parametrize(
    ("kind", "tolerance", "stages"),
    [
        *((kind, 0.0, 8) for kind in KINDS),
        *(("generic", 1e-10, 8), ("other sizes", 1e-10, 8)),
        *(pytest.param(k, 0.0, s, marks=pytest.mark.nightly) for k in KINDS for s in (2, 8, 12)),
    ],
)
def test_an_accepted_step_is_solved(
    kind: str, tolerance: float, stages: int, request: pytest.FixtureRequest
) -> None:
    """To rounding, or a few times the tolerance, though it was only predicted; few steps fail.

    At night of all systems and test problems, a hundred thousand steps together.
    """
    few = request.node.get_closest_marker("nightly") is None
    accepted, failed = first_steps(kind, stages, 2 if few else 180, few, tolerance)
    assert accepted > (1 if few else 1000)
    assert failed <= TOO_LONG.get(kind, 0.05) * accepted


# --- RATTLE ---------------------------------------------------------------------------------------


def tangential(G: Array, v: Array) -> Array:
    return v - G.T @ np.linalg.lstsq(G.T, v, rcond=None)[0]


def half_step(motion: gi.Integrator, y: Array, h: float) -> Array:
    """Return P out of memory: behind the state and its carry its increment, or multipliers."""
    problem, n = motion.problem, len(y) // 2
    q, p, kept = y[:n], y[n:], motion.stepper.memory.data[4 * n :]
    if not problem.hamiltonian.separable:
        return p + kept[n : 2 * n]
    force = constraint(problem, q)[1].T @ kept[: problem.hamiltonian.constraints]
    return p - 0.5 * h * (gradients(problem, T0, q, p)[0] + force)


def rattle_residual(motion: gi.Integrator, y: Array, h: float) -> float:
    """The largest residual of Hairer, Lubich, Wanner, VII.1 (1.26)."""
    problem, n, half = motion.problem, len(y) // 2, 0.5 * h
    q, p, q1, p1 = y[:n], y[n:], motion.state[:n], motion.state[n:]
    P = half_step(motion, y, h)
    (dq0, dp0), (dq1, dp1) = gradients(problem, T0, q, P), gradients(problem, T0 + h, q1, P)
    end = gradients(problem, T0 + h, q1, p1)[1]
    (_, G0), (g1, G1) = constraint(problem, q), constraint(problem, q1)
    q_size = max(np.abs(x).max() for x in (q, q1, h * dp0, h * dp1))
    p_size = max(np.abs(x).max() for x in (p, p1, P, h * dq0, h * dq1, 1e-300 + 0.0 * p))
    pushed = gradients(problem, T0 + h, q1, p1 - h * dq1)[1]  # by forces alone, without multipliers
    rates = max(np.abs(v).max() for v in (end, dp0, pushed, 1e-300 + 0.0 * end))
    found = (
        np.abs(q1 - q - half * (dp0 + dp1)).max() / q_size,
        np.abs(tangential(G0, P - p + half * dq0)).max() / p_size,
        np.abs(g1).max() / (np.abs(G1).max() * q_size),
        np.abs(tangential(G1, p1 - P + half * dq1)).max() / p_size,
        np.abs(G1 @ end).max() / (np.abs(G1).max() * rates),
    )
    return float(max(found)) / EPSILON


def on_spheres(few: bool) -> list[tuple[gi.Problem, Array]]:
    """Separable or not."""
    found = []
    for problem, y0 in problems("hamiltonian", few):
        if few and problem.name not in ("spherical-pendulum", "neumann-3"):
            continue
        if problem.admit is not None:
            found.append((problem, y0))
        if problem.admit is not None and problem.hamiltonian.separable:
            form = dataclasses.replace(problem.hamiltonian, separable=False)
            found.append((dataclasses.replace(problem, hamiltonian=form), y0))
    return found


@pytest.mark.parametrize(
    ("few", "count"), [(True, 5), pytest.param(False, 150, marks=pytest.mark.nightly)]
)
@pytest.mark.parametrize("kind", KINDS)
def test_an_accepted_rattle_step_is_solved(kind: str, few: bool, count: int) -> None:
    """Of few problems in plain Python, which has the same bits; at night of all systems on spheres."""
    accepted = failed = 0
    method = gi.find_method("rattle-2")
    for problem, start in on_spheres(few):
        rng = np.random.default_rng(problem.rows)
        motion = gi.Integrator(problem, start, method, step=1.0, compiled=not few)
        h0 = method.default_step(problem, start, 1.0)
        for y in states(problem, start, kind, count, seed=1):
            if np.abs(y[: len(y) // 2]).max() == 0.0:
                continue
            h = min(h0, method.default_step(problem, y, 1.0)) * rng.choice([1.0, 0.1, 1e-3, 1e-6])
            if not taken(motion, y, h):
                failed += 1
                continue
            worst = rattle_residual(motion, y, h)
            assert worst <= 64.0, (problem.name, problem.hamiltonian.separable, y, h, worst)
            accepted += 1
    assert accepted > 0.7 * count
    assert failed <= 0.02 * accepted


# --- where there is nothing to do -----------------------------------------------------------------


def iterations(
    problem: gi.Problem, y: Array, name: str, h: float, steps: int = 4
) -> tuple[int, Array]:
    """How many iterations steps took, and where they lead."""
    motion = gi.Integrator(problem, y, name, step=h, compiled=False)
    motion.step(steps)
    return motion.iterations, motion.state


@pytest.mark.parametrize("name", ["gauss-1", "gauss-8", "rattle-2", "lobatto-3", "lobatto-8"])
def test_what_rests_stays_at_rest_at_once(name: str) -> None:
    """At the poles of Neumann's system and on a free sphere no iteration is left after the first.

    What rounding leaves of g(q) = 0 on the sphere pushes nothing.
    """
    free = gi.load_scene("hamiltonized-n3").problem
    poles = np.eye(6)[:3] if "lobatto" not in name else ()
    resting = [(neumann.problem(), y, 0.3) for y in poles]
    resting += [(free, free.random_state(k) * [1, 1, 1, 0, 0, 0], 0.01) for k in range(2)]
    for problem, y, h in resting:
        count, end = iterations(problem, y, name, h)
        assert count <= (4 if name == "rattle-2" and problem is free else 8), (name, problem.name)
        np.testing.assert_array_equal(end, y)


def test_steady_rotations_stop_soon() -> None:
    """An increment that is the same in every stage and step is found again: a few iterations."""
    problem = gi.load_scene("sphere-n3").problem
    y = np.array([1.0, 0.0, 0.0, 0.0, 1.0, 0.0])  # a great circle along two principal axes
    h = gi.Gauss(8).default_step(problem, y, 1.0)
    count, end = iterations(problem, y, "gauss-8", h, 10)
    assert count < 250
    assert np.max(np.abs(end[[2, 5]])) == 0.0
