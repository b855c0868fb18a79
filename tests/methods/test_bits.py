"""Bit for bit: compiled = plain Python, whatever the family; and evaluations are counted.

That steps know neither chunks nor restarts is the business of `tests.run.test_integrator`, that
eight at a time have the bits of single runs that of `tests.ensemble`.
"""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import geomint as gi
from tests.families import FAMILIES, PROBLEMS, pairs


def memory_after(name: str, problem: str, steps: int, **options: Any) -> Any:
    """All that a method remembers after some steps, predictors and carries, and its iterations."""
    motion = gi.Integrator(*PROBLEMS[problem], name, step=0.05, **options)
    motion.step(steps)
    assert np.isfinite(motion.state).all()
    return motion.restart.memory.tobytes(), motion.iterations


@pytest.mark.nojit
@pairs(FAMILIES, [pair for pair in FAMILIES if pair[0] != "rkmk-cayley-dop853-adaptive"])
@pytest.mark.parametrize("steps", [10, pytest.param(1000, marks=pytest.mark.nightly)])
def test_compiled_is_plain(name: str, problem: str, steps: int) -> None:
    runs = [memory_after(name, problem, steps, compiled=compiled) for compiled in (True, False)]
    assert runs[0] == runs[1]


def counted(f: Any, calls: deque[int]) -> Any:
    """A field that notes its calls, in plain Python."""

    def noting(*arguments: Any) -> None:
        calls.append(1)
        f.function(*arguments)

    return gi.field(noting)


def with_field(problem: gi.Problem, count: Callable[[Any], Any]) -> gi.Problem:
    return dataclasses.replace(problem, field=count(problem.field))


def with_flow(problem: gi.Problem, count: Callable[[Any], Any]) -> gi.Problem:
    flow = gi.helper(count(problem.splitting.flow).function)
    return dataclasses.replace(problem, splitting=gi.Splitting(flow, problem.splitting.parts))


def with_generator(problem: gi.Problem, count: Callable[[Any], Any]) -> gi.Problem:
    action = gi.GroupAction(count(problem.action.generator), problem.action.group)
    return dataclasses.replace(problem, action=action)


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("name", "on", "stages", "with_counted"),
    [
        *((name, "pulsating-body", k, with_field) for name, k in (("rk-4", 4), ("dop853", 12))),
        *((name, "pulsating-body", int(name[-1]), with_generator) for name in ("cf-4", "cf-3")),
        *(("rkmk-4", "pulsating-body", 4, with_generator), ("verlet-2", "abc-flow", 5, with_flow)),
        ("gauss-3", "pulsating-body", 3, with_field),
    ],
)
def test_evaluations_are_counted(name: str, on: str, stages: int, with_counted: Any) -> None:
    """What a solution reports is what was called: once a stage and iteration, or part."""
    calls: deque[int] = deque()
    problem = with_counted(PROBLEMS[on][0], lambda f: counted(f, calls))
    run = {"t_end": 0.3, "step": 0.1, "method": name, "compiled": False}
    for _ in range(2):  # the first one looks at what the problem declares, too
        calls.clear()
        sol = gi.solve(problem, PROBLEMS[on][1], **run)
    assert sol.steps == 3
    assert sol.evaluations == sol.iterations * stages
    # A Gauss method evaluates all its stages in one call, in lanes.
    assert len(calls) == (sol.iterations if name == "gauss-3" else sol.evaluations)
