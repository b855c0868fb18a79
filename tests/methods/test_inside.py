"""What a Gauss step has added on the way: how well it is known, and how far that is told."""

from __future__ import annotations

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.numbers.blocks import Block, scalar_block
from geomint.kernels.solve.orbit import DOUBT
from geomint.methods.started import Start
from geomint.tableaux import gauss_legendre

EIGHTHS = np.arange(1, 9) / 8


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


@pytest.mark.parametrize("stages", [1, 2, 3, 4, 6, 8, 9, 12, 16])
@pytest.mark.parametrize("seed", range(3))
def test_the_estimate_is_an_upper_bound(stages: int, seed: int) -> None:
    """Of how far interpolation is from real steps; over all numbers also without doubt."""
    problem = gi.load_scene("sphere-n3").problem
    y0 = problem.random_state(seed)
    h = 0.06 * (stages + 2) * gi.Gauss(8).default_step(problem, y0, 1.0)
    start = Start(problem, y0, 0.0, h, False)
    stepper, dense = (
        gi.Gauss(stages).start(start),
        gi.solve(
            problem, y0, t_end=2 * h, step=h, method=gi.Gauss(stages), dense=True, progress=False
        ),
    )
    rows, width = stepper.rows, len(stepper.memory)
    out = scalar_block(4 * width)
    assert stepper.advance(0, 2, 1, out, whole=True).status == 0
    memories = out.data[: 2 * width].reshape(2, width)
    between, found = stepper.between, scalar_block(16 * rows)
    between.inside.function(
        Block(memories[1]), Block(memories[0]), between.places, rows, 0, rows, found
    )
    better, plain = found.data.reshape(rows, 2, 8).transpose(1, 2, 0)
    truth = dense.sol(h + h * EIGHTHS) - memories[0, :rows]
    left, off = np.abs(better - plain).max(axis=0), np.abs(better - truth).max(axis=0)
    assert (off <= DOUBT * left + 1e-14).all()
    assert off.max() <= left.max() + 1e-14
