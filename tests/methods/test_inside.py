"""What a Gauss step has added on the way: how well it is known, and how far that is told."""

from __future__ import annotations

import numpy as np
import pytest

import geomint as gi
from geomint.tableaux import gauss_legendre

EIGHTHS = np.arange(1, 9) / 8
DOUBT = 16.0  # as events take it


@pytest.mark.parametrize("stages", range(1, 17))
def test_polynomials_are_integrated_exactly(stages: int) -> None:
    """By interpolation of degree 2s − 1, by the collocation polynomial of degree s − 1."""
    table = gauss_legendre(stages)
    A, B, U = table.inside(EIGHTHS)
    for k in range(2 * stages if stages <= 8 else stages + 4):
        exact = EIGHTHS ** (k + 1) / (k + 1)
        ahead, behind = table.b * table.c**k, table.b * (table.c - 1) ** k
        np.testing.assert_allclose(A @ ahead + B @ behind, exact, rtol=0, atol=1e-13)
        if k < stages:
            np.testing.assert_allclose(U @ ahead, exact, rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    "stages",
    [pytest.param(s, marks=[pytest.mark.nightly] * (s not in (3, 8, 12))) for s in range(1, 17)],
)
def test_the_estimate_is_an_upper_bound(stages: int) -> None:
    """Of how far interpolation is from real steps; over all numbers also without doubt."""
    problem = gi.load_scene("sphere-n3").problem
    y0 = problem.random_state(stages)
    h = 0.06 * (stages + 2) * gi.Gauss(8).default_step(problem, y0, 1.0)
    run = {"step": h, "method": gi.Gauss(stages), "compiled": False}
    motion = gi.Integrator(problem, y0, gi.Gauss(stages), step=h, compiled=False)
    dense = gi.solve(problem, y0, t_end=2 * h, dense=True, **run)
    memories = []
    for _ in range(2):
        motion.step()
        memories.append(motion.restart.memory.copy())
    stepper, rows, block = motion.stepper, problem.rows, type(motion.stepper.memory)
    between, found = stepper.flow.between, np.zeros(16 * rows)
    between.inside.function(
        block(memories[1]), block(memories[0]), between.places, rows, 0, rows, block(found)
    )
    better, plain = found.reshape(rows, 2, 8).transpose(1, 2, 0)
    truth = dense.sol(h + h * EIGHTHS) - memories[0][:rows]
    left, off = np.abs(better - plain).max(axis=0), np.abs(better - truth).max(axis=0)
    assert (off <= DOUBT * left + 1e-14).all()
    assert off.max() <= left.max() + 1e-14
