"""Recorded functions at many states at once, compiled."""

from collections.abc import Callable, Sequence

import numpy as np

from ..arguments import Array
from ..kernels.compiling.call import Call
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import FIELD
from ..kernels.numbers.blocks import Block, scalar_block
from ..kernels.solve.sample import sampler
from .bound import bound
from .declaration import kept_with
from .problem import Problem
from .spaces.conditions import written

Values = Callable[[Array, Array], Array]  # of times and states, one a row


def evaluator(problem: Problem, function: Recorded, compiled: bool = True) -> Values:
    """Return what evaluates a function ``f(params, t, y, work)`` at times and states, one a row."""
    values = writer(problem, [written(function)], 1, compiled)
    return lambda times, states: values(times, states)[0, :, 0]


def writer(
    problem: Problem, functions: Sequence[Recorded], width: int, compiled: bool = True
) -> Values:
    """Return what functions ``f(params, t, y, out, work)`` write at states, `width` numbers each.

    What it returns has shape (functions, states, width). Rows of states may have more numbers than
    those of the problem, after these.
    """

    def made() -> Call:
        return sampler().call(
            compiled,
            values=tuple(bound(problem, f, FIELD, out=width) for f in functions),
            functions=len(functions),
            params=Block(problem.params),
            rows=problem.rows,
            width=width,
        )

    of = (f.fingerprint for f in (sampler().recorded, *functions))
    sample = kept_with(problem, ("writer", width, compiled, *of), made).copy()
    sample.set(work=scalar_block(problem.work))

    def values(times: Array, states: Array) -> Array:
        (count, stride), m = states.shape, len(functions)
        out = np.zeros(m * count * width)
        given = {"states": Block(np.ascontiguousarray(states).reshape(-1)), "stride": stride}
        times = np.ascontiguousarray(times)
        sample(times=Block(times), **given, count=count, out=Block(out))
        return out.reshape(m, count, width)

    return values


def values_at(
    problem: Problem, function: Recorded, states: Array, times: Array | None = None
) -> Array:
    """Return a function at states, one a row, and times, by default 0."""
    return evaluator(problem, function)(np.zeros(len(states)) if times is None else times, states)
