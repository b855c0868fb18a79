"""Compensated sums and small linear systems."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, strategies as st

import geomint as gi
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import LANE, SCALAR
from geomint.kernels.numbers.blocks import Block, LaneBlock
from geomint.kernels.numbers.lanes import LANES
from geomint.kernels.solve.compensated import add_compensated
from geomint.kernels.solve.rattle import contract, solve_small

pytestmark = pytest.mark.nojit


@gi.helper
def add_all(values, state, carry):
    for i in range(len(values)):
        add_compensated(state, carry, 0, values[i])


@given(st.lists(st.floats(-1e-3, 1e-3), min_size=1, max_size=60))
def test_what_is_lost_is_a_rounding_of_the_increments(increments: list[float]) -> None:
    """Not of the sum, which is a thousand times larger."""
    state, carry = Block(np.array([1.0])), Block(np.zeros(1))
    add_all(Block(np.array(increments)), state, carry)
    exact = 1 + sum(map(Fraction, increments))
    error = abs(Fraction(state.data[0]) + Fraction(carry.data[0]) - exact)
    assert error <= Fraction(2) ** -53 * sum(abs(Fraction(v)) for v in increments)
    assert abs(carry.data[0]) <= 0.5 * np.spacing(state.data[0])


def test_compiled_code_keeps_the_compensation() -> None:
    """A compiler that reassociates would add 10⁵ times one tenth to 10⁴ + 1.9e-8."""
    from numba.core import types

    values = np.full(10**5, 0.1)
    block = SCALAR.block
    entry = compile_function(add_all, types.void(block, block, block))
    state, carry = Block(np.zeros(1)), Block(np.zeros(1))
    entry(Block(values), state, carry)
    assert state.data[0] == math.fsum(values)
    assert np.cumsum(values)[-1] != math.fsum(values)

    block = LANE.block
    entry = compile_function(add_all, types.void(block, block, block))
    state, carry = (LaneBlock(np.zeros((1, LANES))) for _ in range(2))
    lanes = np.repeat(values[:, None], LANES, axis=1) * np.arange(1, 1 + LANES)
    entry(LaneBlock(lanes), state, carry)
    np.testing.assert_array_equal(state.data[0], [math.fsum(lanes[:, k]) for k in range(LANES)])


@pytest.mark.parametrize("m", [1, 2, 3, 6])
def test_small_systems(m: int) -> None:
    """Solved to rounding where the matrix is definite, also if it is not symmetric."""
    rng = np.random.default_rng(m)
    for _ in range(20):
        a = rng.standard_normal((m, m))
        a = a @ a.T + np.eye(m) + 0.1 * rng.standard_normal((m, m))
        x = rng.standard_normal(m)
        matrix, right = Block(a.ravel().copy()), Block(a @ x)
        solve_small(m, matrix, right)
        tolerance = 100 * np.linalg.cond(a) * 2.0**-52
        np.testing.assert_allclose(right.data, x, rtol=0, atol=tolerance)


def test_products_of_rows() -> None:
    """left rightᵀ."""
    rng = np.random.default_rng(5)
    left, right = rng.standard_normal((2, 3, 4))
    out = Block(np.zeros(9))
    contract(4, 3, Block(left.ravel()), Block(right.ravel()), out)
    np.testing.assert_allclose(out.data.reshape(3, 3), left @ right.T, rtol=0, atol=1e-14)
