"""Accepted means solved, for RATTLE: its equations evaluated again, with the multipliers left free.

What is along the normals of the constraint is the multipliers' business, so that only the rest of
an equation for p is a residual. Residuals are in ε times the size of a piece, as in `test_solved`.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.numbers.blocks import Block
from geomint.kernels.solve.status import OK
from geomint.methods import Start
from geomint.methods.stepper import Stepper
from tests.methods.first_steps import KINDS, problems, states

Array = Any
EPSILON = 2.0**-52
BOUND = 64.0
T0 = 0.25
LENGTHS = (1.0, 0.1, 1e-3, 1e-6)


def gradients(problem: gi.Problem, t: float, q: Array, p: Array) -> tuple[Array, Array]:
    dq, dp, work = (Block(np.zeros(k)) for k in (len(q), len(q), problem.work))
    problem.hamiltonian.gradients(
        Block(problem.params), np.float64(t), Block(q), Block(p), dq, dp, work
    )
    return dq.data, dp.data


def constraint(problem: gi.Problem, q: Array) -> tuple[Array, Array]:
    m, n = problem.hamiltonian.constraints, len(q)
    g, G = Block(np.zeros(m)), Block(np.zeros(m * n))
    problem.hamiltonian.constraint(
        Block(problem.params), Block(q), g, G, Block(np.zeros(problem.work))
    )
    return g.data, G.data.reshape(m, n)


def tangential(G: Array, v: Array) -> Array:
    return v - G.T @ np.linalg.lstsq(G.T, v, rcond=None)[0]


def half_step(problem: gi.Problem, stepper: Stepper, y: Array, h: float) -> Array:
    """Return P out of the stepper's memory: its increment, or for separable H its multipliers."""
    n, m = problem.rows // 2, problem.hamiltonian.constraints
    q, p = y[:n], y[n:]
    kept = stepper.memory.data[4 * n :]
    if not problem.hamiltonian.separable:
        return p + kept[n : 2 * n]
    return p - 0.5 * h * (gradients(problem, T0, q, p)[0] + constraint(problem, q)[1].T @ kept[:m])


def residual(problem: gi.Problem, stepper: Stepper, y: Array, h: float) -> float:
    """Return the largest residual of Hairer, Lubich, Wanner, VII.1 (1.26)."""
    n = problem.rows // 2
    q, p, q1, p1 = y[:n], y[n:], stepper.state[:n], stepper.state[n:]
    P, half = half_step(problem, stepper, y, h), 0.5 * h
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


def of_spheres() -> list[tuple[gi.Problem, Array]]:
    found = []
    for problem, y0 in problems("hamiltonian"):
        if problem.admit is None:
            continue
        found.append((problem, y0))
        if problem.hamiltonian.separable:
            form = dataclasses.replace(problem.hamiltonian, separable=False)
            found.append((dataclasses.replace(problem, hamiltonian=form), y0))
    return found


def check(kind: str, count: int, few: bool) -> tuple[int, int]:
    """Take first steps, of few problems in plain Python, which has the same bits."""
    taken = failed = 0
    method = gi.find_method("rattle-2")
    for problem, start in of_spheres():
        if few and (problem.name not in ("spherical-pendulum", "neumann-3")):
            continue
        rng = np.random.default_rng(problem.rows)
        base = method.start(Start(problem, start, T0, 1.0, compiled=not few))
        h0 = method.default_step(problem, start, 1.0)
        for y in states(problem, start, kind, count, seed=1):
            n = problem.rows // 2
            if np.abs(y[:n]).max() == 0.0:
                continue
            h = min(h0, method.default_step(problem, y, 1.0)) * rng.choice(LENGTHS)
            stepper = base.restarted(y, T0, h)
            if stepper.advance(0, 1, 2, Block(np.zeros(0))).status != OK:
                failed += 1
                continue
            worst = residual(problem, stepper, y, h)
            assert worst <= BOUND, (problem.name, problem.hamiltonian.separable, y, h, worst)
            taken += 1
    return taken, failed


@pytest.mark.parametrize("kind", KINDS)
def test_an_accepted_rattle_step_is_solved(kind: str) -> None:
    """Separable or not, from rest and from generic states."""
    taken, failed = check(kind, 60, few=True)
    assert taken > 40
    assert failed <= 0.02 * taken


@pytest.mark.nightly
@pytest.mark.parametrize("kind", KINDS)
def test_accepted_rattle_steps_are_solved(kind: str) -> None:
    """Of all systems on spheres and their images."""
    taken, failed = check(kind, 150, few=False)
    assert taken > 150
    assert failed <= 0.02 * taken


def test_a_sphere_at_rest_stays_at_rest() -> None:
    """Wherever it is: what rounding leaves of g(q) = 0 pushes nothing, and one iteration sees it."""
    method = gi.find_method("rattle-2")
    free = [(x, y) for x, y in of_spheres() if x.name == "chaplygin-sphere-hamiltonized"]
    assert free
    for problem, start in free:
        for y in states(problem, start, "generic", 20, seed=2):
            y[problem.rows // 2 :] = 0.0
            stepper = method.start(Start(problem, y, T0, 0.01, compiled=False))
            assert stepper.advance(0, 10, 12, Block(np.zeros(0))).iterations == 10
            np.testing.assert_array_equal(stepper.state, y)
