"""Recorded functions at many states at once, compiled."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arguments import Array
from ..kernels.compiling.bound import bind
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import FIELD
from ..kernels.numbers.blocks import Block, scalar_block
from ..kernels.solve.sample import sampler
from ..methods.stepper import filled_block
from ..problems.problem import Problem
from ..problems.spaces.conditions import written

__all__ = ["Values", "evaluator", "values_at", "writer"]

Values = Callable[[Array, Array], Array]  # of times and states, one a row


def evaluator(problem: Problem, function: Recorded, compiled: bool = True) -> Values:
    """Return what evaluates a function ``f(params, t, y, work)`` at times and states, one a row."""
    values = writer(problem, written(function), 1, compiled)
    return lambda times, states: values(times, states)[:, 0]


def writer(problem: Problem, function: Recorded, width: int, compiled: bool = True) -> Values:
    """Return what a function ``f(params, t, y, out, work)`` writes at states, `width` numbers a row."""
    sizes = {"params": len(problem.params), "y": problem.rows}
    sample = sampler().call(
        compiled,
        values=(bind(function, FIELD, **sizes, out=width),),
        functions=1,
        params=filled_block(problem.params),
        rows=problem.rows,
        stride=problem.rows,
        work=scalar_block(problem.work),
        width=width,
    )

    def values(times: Array, states: Array) -> Array:
        out = scalar_block(len(times) * width)
        given = {"times": Block(np.ascontiguousarray(times)), "count": len(times)}
        sample(states=Block(np.ascontiguousarray(states).reshape(-1)), out=out, **given)
        return np.asarray(out.data).reshape(len(times), width)

    return values


def values_at(
    problem: Problem, function: Recorded, states: Array, times: Array | None = None
) -> Array:
    """Return a function at states, one a row, and times, by default 0."""
    return evaluator(problem, function)(np.zeros(len(states)) if times is None else times, states)
