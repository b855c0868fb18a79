"""Accepted means solved: the equations of implicit steps, evaluated again outside of the kernels.

A residual is measured in ε times the size of its piece of the state: the largest of the piece before the
step, after it, and of h times its rate.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from first_steps import KINDS, problems, states
from scipy.integrate import solve_ivp

import geomint as gi
from geomint.kernels import fixed_point, signatures
from geomint.kernels.blocks import Block, LaneBlock, scalar_block
from geomint.kernels.compile import LANE, compile_function
from geomint.kernels.gauss import aligned
from geomint.kernels.lanes import LANES, Lanes
from geomint.kernels.status import NOT_CONVERGED, OK
from geomint.methods import Start, find_method
from geomint.methods.gauss import lane_positions
from geomint.methods.stepper import Stepper
from geomint.tableaux import gauss_legendre
from geomint.testproblems import neumann, spherical_pendulum
from geomint.timeline import default_step

Array = Any
EPSILON = 2.0**-52
# Rounding of a stage is carried on by the iteration: 1/(1 − κ) times, κ its contraction.
BOUND = 64.0
LENGTHS = (1.0, 1.0, 0.1, 1e-3, 1e-8)  # of steps, in default ones
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

    def __init__(self, problem: gi.Problem, stages: int, h: float) -> None:
        self.problem, self.stages, self.h = problem, stages, h
        self.stepper = gi.Gauss(stages).start(Start(problem, np.ones(problem.rows), T0, h))
        self.accepted: list[tuple[Array, ...]] = []
        self.failed: list[tuple[Array, float]] = []
        self.lanes = lane_positions(stages, 8 * (1 if stages <= LANES else 2))

    def take(self, y: Array, h: float) -> None:
        rows = self.problem.rows
        stepper = self.stepper.restarted(y, T0, h)
        result = stepper.advance(0, 1, 2, Block(np.zeros(0)))
        if result.status == OK:
            width = len(self.lanes) > LANES
            numbers = stepper.memory.data[aligned(2 * rows) :][: LANES * (1 + width) * rows]
            L = np.concatenate(list(numbers.reshape(1 + width, rows, LANES)), axis=1)
            self.accepted.append((y, stepper.state.copy(), h, L.T[self.lanes]))
        elif np.isfinite(derivatives(self.problem, np.array([T0]), y[None])).all():
            self.failed.append((y, h))

    def worst(self) -> float:
        y0, y1, h, L = (np.array(column) for column in zip(*self.accepted, strict=True))
        return float(residuals(self.problem, self.stages, y0, y1, h, L).max())


def first_steps(kind: str, stages: int, count: int, few: bool) -> tuple[int, int]:
    """Take first steps; all that are accepted are solved. Return how many were, and how many failed."""
    taken = failed = 0
    for problem, start in problems("field", few):
        h0 = default_step(problem, gi.Gauss(8), start)
        rng = np.random.default_rng([stages, problem.rows])
        steps = Steps(problem, stages, h0)
        for y in states(problem, start, kind, count, seed=stages):
            try:
                shortest = min(h0, default_step(problem, gi.Gauss(8), y))
            except gi.DomainError:  # the derivative is so large that no time is left
                continue
            steps.take(y, shortest * rng.choice(LENGTHS))
        if steps.accepted:
            assert steps.worst() <= BOUND, (problem.name, kind, steps.worst())
        taken, failed = taken + len(steps.accepted), failed + len(steps.failed)
    return taken, failed


@pytest.mark.parametrize("kind", KINDS)
def test_an_accepted_step_is_solved(kind: str) -> None:
    """Default steps and shorter ones; hardly one fails."""
    taken, failed = first_steps(kind, 8, 30, few=True)
    assert taken > 100
    assert failed <= 0.02 * taken


@pytest.mark.slow
@pytest.mark.parametrize("stages", [2, 8, 12])
@pytest.mark.parametrize("kind", KINDS)
def test_a_hundred_thousand_accepted_steps_are_solved(kind: str, stages: int) -> None:
    """Of all systems and test problems; over all kinds and numbers of stages together."""
    taken, failed = first_steps(kind, stages, 120, few=False)
    print(kind, stages, taken, failed)
    assert taken > 3000
    assert failed <= 0.02 * taken
