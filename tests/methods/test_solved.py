"""Accepted means solved: the equations of implicit steps, evaluated again outside of the kernels.

A residual is measured in ε times the size of its piece of the state: the largest of the piece before
the step, after it, and of h times its rate.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import geomint as gi
from geomint.kernels.numbers.blocks import Block, LaneBlock
from geomint.kernels.numbers.lanes import LANES, Lanes
from geomint.kernels.solve.gauss import gauss_memory
from geomint.kernels.solve.status import OK
from geomint.methods import Start
from geomint.methods.gauss import lane_positions
from geomint.problems.testproblems import neumann
from geomint.tableaux import gauss_legendre
from tests.methods.first_steps import KINDS, problems, states

Array = Any
EPSILON = 2.0**-52
# Rounding of a stage is carried on by the iteration: 1/(1 − κ) times, κ its contraction.
BOUND = 80.0
LENGTHS = (1.0, 0.5, 0.1, 1e-3, 1e-8)  # of steps, in default ones of another state
# Where those are too long for many states: they fail, and that is all they may do.
TOO_LONG = {"nearly at rest": 0.4, "other sizes": 0.4}
T0 = 0.25


def derivatives(problem: gi.Problem, t: Array, Y: Array) -> Array:
    """Return ẏ at many states at once, by the field's source in plain numpy; states are rows."""
    flat = Y.reshape(-1, problem.rows)
    out = LaneBlock(np.full(flat.shape[::-1], np.nan))
    work = LaneBlock(np.zeros((problem.work, len(flat))))
    state = LaneBlock(np.ascontiguousarray(flat.T))
    with np.errstate(all="ignore"):
        problem.field(Block(problem.params), Lanes(t.ravel()), state, out, work)
    return out.data.T.reshape(Y.shape)


def residuals(problem: gi.Problem, stages: int, y0: Array, y1: Array, h: Array, L: Array) -> Array:
    """Return for each step the largest residual of ``L_i = h b_i f(t + c_i h, y + Σ μ_ij L_j)``."""
    table = gauss_legendre(stages)
    Y = y0[:, None, :] + np.einsum("ij,mjr->mir", table.mu, L)
    F = derivatives(problem, T0 + h[:, None] * table.c, Y)
    defect = np.abs(h[:, None, None] * table.b[:, None] * F - L)
    worst = np.zeros(len(h))
    for piece in problem.slices.values():
        moves = np.max(np.abs(h[:, None, None] * F[..., piece]), axis=(1, 2))
        ends = np.maximum(np.abs(y0[:, piece]), np.abs(y1[:, piece])).max(axis=1)
        size = np.maximum(np.maximum(moves, ends), 1e-300)
        worst = np.maximum(worst, defect[..., piece].max(axis=(1, 2)) / (EPSILON * size))
    return worst


class Steps:
    """First steps of one problem: what was accepted, and what failed though it need not."""

    def __init__(self, problem: gi.Problem, stages: int, h: float, tolerance: float = 0.0) -> None:
        self.problem, self.stages = problem, stages
        given = {"iteration": "fixed-point", "iteration_tolerance": tolerance}
        self.stepper = gi.Gauss(stages, **given).start(Start(problem, np.ones(problem.rows), T0, h))
        self.accepted: list[tuple[Array, ...]] = []
        self.failed: list[tuple[Array, float]] = []
        self.lanes = lane_positions(stages, 8 * (1 if stages <= LANES else 2))

    def take(self, y: Array, h: float) -> None:
        rows = self.problem.rows
        stepper = self.stepper.restarted(y, T0, h)
        result = stepper.advance(0, 1, 2, Block(np.zeros(0)))
        if result.status == OK:
            width = len(self.lanes) > LANES
            numbers = gi.section(stepper.memory, gauss_memory(rows, 1 + width), "stages").data
            L = np.concatenate(list(numbers.reshape(1 + width, rows, LANES)), axis=1)
            self.accepted.append((y, stepper.state.copy(), h, L.T[self.lanes]))
        elif np.isfinite(derivatives(self.problem, np.array([T0]), y[None])).all():
            self.failed.append((y, h))

    def worst(self) -> float:
        y0, y1, h, L = (np.array(column) for column in zip(*self.accepted, strict=True))
        return float(residuals(self.problem, self.stages, y0, y1, h, L).max())


def first_steps(
    kind: str, stages: int, count: int, few: bool, tolerance: float = 0.0
) -> tuple[int, int]:
    """Take first steps; all that are accepted are solved. Return how many were, and how many failed."""
    bound = max(BOUND, 4.0 * tolerance / EPSILON)
    taken = failed = 0
    for problem, start in problems("field", few):
        h0 = gi.Gauss(8).default_step(problem, start, 1.0)
        rng = np.random.default_rng([stages, problem.rows])
        steps = Steps(problem, stages, h0, tolerance)
        for y in states(problem, start, kind, count, seed=stages):
            steps.take(y, h0 * rng.choice(LENGTHS))
        if steps.accepted:
            assert steps.worst() <= bound, (problem.name, kind, steps.worst())
        taken, failed = taken + len(steps.accepted), failed + len(steps.failed)
    return taken, failed


@pytest.mark.parametrize("kind", KINDS)
def test_an_accepted_step_is_solved(kind: str) -> None:
    """Default steps and shorter ones; few fail: they are too long there."""
    taken, failed = first_steps(kind, 8, 30, few=True)
    assert taken > 60
    assert failed <= TOO_LONG.get(kind, 0.05) * taken


@pytest.mark.parametrize("kind", KINDS)
def test_a_tolerance_is_met(kind: str) -> None:
    """What is left is a few times the tolerance, though it was only predicted."""
    taken, failed = first_steps(kind, 8, 30, few=True, tolerance=1e-10)
    assert taken > 60
    assert failed <= TOO_LONG.get(kind, 0.05) * taken


@pytest.mark.nightly
@pytest.mark.parametrize("stages", [2, 8, 12])
@pytest.mark.parametrize("kind", KINDS)
def test_a_hundred_thousand_accepted_steps_are_solved(kind: str, stages: int) -> None:
    """Of all systems and test problems; over all kinds and numbers of stages together."""
    taken, failed = first_steps(kind, stages, 180, few=False)
    assert taken > 1500
    assert failed <= TOO_LONG.get(kind, 0.05) * taken


# --- where there is nothing to do -----------------------------------------------------------------


@pytest.mark.parametrize("name", ["gauss-1", "gauss-8", "rattle-2"])
def test_fixed_points_stop_at_once(name: str) -> None:
    """At the poles of Neumann's system, at rest, no iteration is left to do after the first."""
    problem = neumann.problem()
    for i in range(3):
        y = np.eye(6)[i]
        stepper = gi.find_method(name).start(Start(problem, y, 0.0, 0.3))
        result = stepper.advance(0, 10, 10, Block(np.zeros(6)))
        assert (result.status, result.steps) == (OK, 10)
        assert result.iterations <= 20
        np.testing.assert_array_equal(stepper.state, y)


def test_steady_rotations_stop_soon() -> None:
    """An increment that is the same in every stage and step is found again: a few iterations."""
    named = {problem.name: problem for problem, _ in problems("field", few=True)}
    problem, n = named["chaplygin-sphere-reduced"], 3
    y = np.eye(2 * n)[0] + np.eye(2 * n)[n + 1]  # a great circle along two principal axes
    h = gi.Gauss(8).default_step(problem, y, 1.0)
    stepper = gi.Gauss(8).start(Start(problem, y, 0.0, h))
    assert stepper.advance(0, 100, 100, Block(np.zeros(2 * n))).iterations < 2500
    assert np.max(np.abs(np.delete(stepper.state, [0, 1, n, n + 1]))) == 0.0


# --- from rest ------------------------------------------------------------------------------------


@gi.field
def pendulum(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -params[0] * gi.sin(y[0])


@gi.observable
def energy(params, t, y, work):
    return 0.5 * y[1] * y[1] - params[0] * gi.cos(y[0])


def pendulum_problem(g: float = 1.0, together: bool = False) -> gi.Problem:
    pieces = (("state", 2),) if together else (("angle", 1), ("momentum", 1))
    return gi.Problem("pendulum", pieces, params=[g], field=pendulum, invariants={"energy": energy})


def truth(g: float, y0: list[float], t: float) -> Array:
    """Return the state at t by SciPy."""
    run = solve_ivp(
        lambda t, y: [y[1], -g * np.sin(y[0])], (0.0, t), y0, "DOP853", rtol=1e-13, atol=1e-13
    )
    return run.y[:, -1]


@pytest.mark.parametrize(
    "name", ["gauss-1", "gauss-3", "gauss-8", "gauss-12", "gauss-1-suzuki-4", "gauss-1-yoshida-6"]
)
def test_a_pendulum_from_rest(name: str) -> None:
    """As two pieces and as one; to the order of the method, and its energy no worse."""
    exact = truth(1.0, [2.0, 0.0], 20.0)
    step = 0.01 if name == "gauss-1" else 0.05 if name.startswith("gauss-1-") else 0.2
    bound = {"gauss-1": 1e-3, "gauss-1-suzuki-4": 1e-4, "gauss-3": 1e-5}.get(name, 1e-7)
    for together in (False, True):
        problem = pendulum_problem(together=together)
        sol = gi.solve(problem, [2.0, 0.0], t_end=20.0, step=step, method=name, observe=["energy"])
        assert np.max(np.abs(sol.y[-1] - exact)) < (1e-10 if name == "gauss-8" else bound)
        assert sol.drift["energy"].max_abs_error < bound


@pytest.mark.parametrize("g", [1e-8, 1.0, 30.0, 100.0, 1e6])
@pytest.mark.parametrize("y0", [[2.0, 0.0], [0.5 * np.pi, 0.0], [1e-3, 0.0], [2.0, 1e-9]])
def test_the_default_step_from_rest(g: float, y0: list[float]) -> None:
    """The step is that of the motion in any unit of time, not of a momentum that is (nearly) 0."""
    scaled = [y0[0], y0[1] * g**0.5]
    t = 10.0 / g**0.5
    sol = gi.solve(pendulum_problem(g), scaled, t_end=t)
    assert 10 <= sol.steps <= 100
    errors = np.abs(sol.y[-1] - truth(1.0, y0, 10.0) * [1.0, g**0.5])
    assert np.max(errors / [1.0, g**0.5]) < 1e-9
