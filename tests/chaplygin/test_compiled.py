"""Compiled functions give the bits of plain Python, single and in lanes.

Functions of the other problems are compiled in the fast row too, and their motions compared with exact
ones: `test_path.py`, `test_exact*.py`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import geomint as gi
from tests.chaplygin.support import evaluated, of_operator, of_parameters

FAST = ["lr-1-full-3", "clebsch-4", "body-multiplier-3"]


def chosen() -> list[Any]:
    """Return problems of all classes by name; most of them run at night."""
    found = {}
    for kind, n in (("special", 3), ("diagonal", 4), ("full", 3)):
        found |= {f"{name}-{kind}-{n}": p for name, p in of_operator(kind, n).items()}
    for n in (3, 4):
        found |= {f"{name}-{n}": p for name, p in of_parameters(n).items()}
    found |= {f"{name}-equal-4": p for name, p in of_parameters(4, equal=2).items()}
    late = [pytest.mark.nightly]
    return [
        pytest.param(problem, id=name, marks=late if name not in FAST else [])
        for name, problem in found.items()
    ]


def together(problem: gi.Problem) -> tuple[Any, int]:
    """Return all functions of a problem in one: each of its own would take long to compile."""
    values = [*problem.diagnostics.values(), *filter(None, [problem.clock])]
    values.append(problem.measure.log_density)
    written = {problem.field: problem.rows, problem.measure.manifold: problem.measure.conditions}
    if problem.action:
        written[problem.action.generator] = problem.action.group.algebra_rows
    space, lines, at = {"__name__": __name__, "part": gi.part}, [], 0
    for i, f in enumerate(values):
        space[f"v{i}"], at = f, at + 1
        lines.append(f"out[{at - 1}] = v{i}(params, t, y, work)")
    for i, (f, rows) in enumerate(written.items()):
        if f is not None:
            space[f"f{i}"] = f
            lines.append(f"f{i}(params, t, y, part(out, {at}, {rows}), work)")
            at += rows
    exec("def call(params, t, y, out, work):\n    " + "\n    ".join(lines), space)
    return gi.field(space["call"]), at


@pytest.mark.parametrize("problem", chosen())
def test_functions(problem: gi.Problem) -> None:
    f, rows = together(problem)
    states = np.array([problem.random_state(seed) for seed in range(3)])
    states[1:] *= np.linspace(0.9, 1.2, problem.rows)
    compiled = gi.pointwise(f, problem.params, states, rows, problem.work)
    plain = np.array([evaluated(problem, f, y, rows) for y in states])
    assert np.isfinite(plain).all()
    assert np.count_nonzero(plain[2]) > 0.9 * rows - 1
    np.testing.assert_array_equal(compiled, plain)


@pytest.mark.nightly
@pytest.mark.parametrize("problem", chosen())
@pytest.mark.filterwarnings("ignore::geomint.errors.GeomintWarning")
def test_steps_in_lanes(problem: gi.Problem) -> None:
    """Of the methods that take stages together, and those of groups and of Hamiltonian forms."""
    methods = [
        "gauss-2",
        *["cf-4"] * bool(problem.action),
        *["rattle-2"] * bool(problem.hamiltonian),
    ]
    y0, end = problem.random_state(1), "tau_end" if problem.time == "tau" else "t_end"
    for method in methods:
        run = {end: 0.05, "method": method, "step": 0.01, "clock": False}
        runs = [gi.solve(problem, y0, **run, compiled=compiled) for compiled in (True, False)]
        np.testing.assert_array_equal(runs[0].y, runs[1].y)
