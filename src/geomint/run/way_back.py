"""The way back to a level, along ways that are given, for many states at once."""

from collections.abc import Callable

import numpy as np

from ..arguments import Array, Booleans
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import FIELD
from ..kernels.numbers.blocks import Block, filled_block, scalar_block
from ..kernels.solve.back_along import BACK_ALONG, scratch_of
from ..problems.bound import bound
from ..problems.problem import Problem

WayBack = Callable[[Array, Array, Array, float], tuple[Array, Booleans]]


def way_back(
    problem: Problem, function: Recorded, wanted: Array, sizes: Array, compiled: bool = True
) -> WayBack:
    """Return what finds points where a function ``f(params, t, y, out, work)`` writes `wanted`.

    It takes states, ways, a beginning, and how near is near enough, see `Level.back`.
    """
    rows, conditions = problem.rows, len(wanted)
    scratch, matrix = scratch_of(rows, conditions)
    call = BACK_ALONG.call(
        compiled,
        values=bound(problem, function, FIELD, out=conditions),
        params=filled_block(problem.params),
        wanted=filled_block(wanted),
        sizes=filled_block(sizes),
        rows=rows,
        conditions=conditions,
        work=scalar_block(problem.work),
        scratch=scalar_block(scratch),
        matrix=scalar_block(matrix),
    )

    def back(ahead: Array, ways: Array, a: Array, on: float) -> tuple[Array, Booleans]:
        coefficients, found = filled_block(a.reshape(-1)), scalar_block(len(a))
        given = {"ahead": ahead, "ways": ways}
        blocks = {k: Block(np.ascontiguousarray(x).reshape(-1)) for k, x in given.items()}
        call(count=len(a), on=on, a=coefficients, found=found, **blocks)
        return coefficients.data.reshape(a.shape), found.data > 0.5

    return back
