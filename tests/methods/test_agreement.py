"""Compiled code that gives other numbers than Python is refused before the first step."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import geomint as gi

SINGLE = np.float32(0.1)
SMALL = np.array([3, 5], dtype=np.uint8)
TEN, MINUS_THREE = 10, -3


@gi.field
def half_powers(params, t, y, out, work):
    s = 0.0
    for k in range(1, 4):
        s += 2**-k * y[1]
    out[0], out[1] = s, -y[0]


@gi.field
def global_power(params, t, y, out, work):
    out[0], out[1] = TEN**MINUS_THREE * y[1], -y[0]


@gi.field
def wrapping(params, t, y, out, work):
    k = 1
    for _ in range(70):
        k = 2 * k
    out[0], out[1] = 1e-21 * k * y[1], -y[0]


@gi.field
def single(params, t, y, out, work):
    out[0], out[1] = (SINGLE * 0.1) * y[1], -y[0]


@gi.field
def small(params, t, y, out, work):
    out[0], out[1] = (SMALL[0] - SMALL[1]) * y[1], -y[0]


@gi.field
def power_of_a_root(params, t, y, out, work):
    out[0], out[1] = TEN**MINUS_THREE * gi.sqrt(y[1]), 0.0


@gi.field
def whole_numbers(params, t, y, out, work):
    """Where they are right: powers with positive exponents, counts, quotients."""
    s = 0.0
    for k in range(1, 4):
        s += 2**k * y[1] / (k + 1)
    out[0], out[1] = s + TEN * y[1], -y[0]


def problem(f: Any) -> gi.Problem:
    return gi.Problem("two", (("y", 2),), field=f)


@pytest.mark.parametrize(
    ("f", "method"),
    [
        *((f, "rk-4") for f in (half_powers, global_power, wrapping, single, small)),
        *((f, "gauss-2") for f in (global_power, single)),
    ],
)
def test_other_numbers_are_refused(f: Any, method: str) -> None:
    with np.errstate(over="ignore"), pytest.raises(gi.DeclarationError, match="other numbers"):
        gi.solve(problem(f), [1.0, 0.5], t_end=1.0, step=0.1, method=method)


@pytest.mark.parametrize("method", ["rk-4", "dop853-adaptive"])
def test_a_run_that_fails_shows_nothing(method: str) -> None:
    """The next one is looked at."""
    two, states = problem(power_of_a_root), [[1.0, -1.0], [1.0, 1.0]]
    many = gi.solve_ensemble(two, states, t_end=1.0, step=0.1, method=method)
    assert [*map(type, many.errors.values())] == [gi.NonFiniteError, gi.DeclarationError]


def test_what_agrees_runs() -> None:
    for method in ("rk-4", "dop853-adaptive"):
        run = gi.solve(problem(whole_numbers), [1.0, 0.0], t_end=1.0, step=0.1, method=method)
        assert run.success
