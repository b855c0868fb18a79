"""A problem's functions with their arguments: what blocks they take, by names, and of how many rows."""

from typing import Any

import numpy as np

from ..arguments import Array
from ..kernels.compiling.bound import Bound
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import BLOCK, OUT, PARAMS, Signature
from ..kernels.numbers.blocks import Block, scalar_block
from .problem import Problem


def _sizes(problem: Problem) -> dict[str, int]:
    """Return how many rows blocks of those names have."""
    rows, half = problem.rows, problem.rows // 2
    m = 0 if problem.hamiltonian is None else problem.hamiltonian.constraints
    return {
        "params": len(problem.params),
        **dict.fromkeys(("y", "u", "v", "out"), rows),
        **dict.fromkeys(("q", "p", "dq", "dp"), half),
        "g": m,
        "G": m * half,
        "work": problem.work,
    }


def given_at(problem: Problem, y: Array, /, **others: Any) -> dict[str, Any]:
    """Return what `Signature.laid_out` takes at a state, t = 0: arrays, and rows of what is written."""
    half = len(y) // 2
    arrays = {"params": problem.params, "q": y[:half], "p": y[half:]}
    return {**_sizes(problem), **arrays, **dict.fromkeys("yuv", y), "t": np.float64(0.0), **others}


def bound(problem: Problem, f: Recorded, signature: Signature, **others: int) -> Bound:
    """Return a function of the problem that knows how many rows its blocks have."""
    sizes = {**_sizes(problem), **others}
    known = (name for name, kind in signature.arguments if kind in (PARAMS, BLOCK, OUT))
    return Bound(f, signature, tuple((name, sizes[name]) for name in known))


def called(problem: Problem, f: Bound, compiled: bool = True) -> tuple[Any, ...]:
    """Return a bound function as Python calls it, and the arrays that its blocks are.

    Its time is 0 until it is set.
    """
    blocks = {name: scalar_block(count) for name, count in f.rows if name != "params"}
    call = f.call(compiled)
    call.set(params=Block(problem.params), work=scalar_block(problem.work), **blocks)
    return call, *(block.data for block in blocks.values())
