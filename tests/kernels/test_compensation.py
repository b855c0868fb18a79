"""Compensated sums: of all steps of a run no rounding is lost."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import given, strategies as st

import geomint as gi
from tests.rows import examples


@gi.field
def steady(params, t, y, out, work):
    for i in range(3):
        out[i] = params[i] + 0.0 * y[i]


def end(rates: list[float], start: list[float], steps: int, compiled: bool) -> np.ndarray:
    problem = gi.Problem("steady", (("x", 3),), rates, field=steady)
    run = {"step": 1.0, "method": "rk-4", "compiled": compiled, "progress": False}
    return gi.solve(problem, start, t_end=float(steps), **run).y[-1]


def check(rates: list[float], start: list[float], steps: int, compiled: bool) -> np.ndarray:
    """The end is the sum to half a unit in its last place, though it has as many terms as steps."""
    found = end(rates, start, steps, compiled)
    increments = end(rates, [0.0] * 3, 1, compiled)
    for x, y, first in zip(found, increments, start, strict=True):
        assert x == float(Fraction(first) + steps * Fraction(y))
    return found


@examples(4)
@given(st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3), st.integers(1, 30))
def test_what_is_lost_is_a_rounding_of_the_increments(rates: list[float], steps: int) -> None:
    """Not of the sum, which is a thousand times larger."""
    check(rates, [1e3, -1e3, 0.0], steps, False)


def test_compiled_code_keeps_the_compensation() -> None:
    """A compiler that reassociates would lose eight digits of these."""
    found = check([0.1, 0.7, -1e-9], [1e4, 0.0, 1.0], 20_000, True)
    assert found[1] != np.cumsum(np.full(20_000, 0.7))[-1]
