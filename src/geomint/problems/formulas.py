"""A function's source, run once on symbols: formulas as others see them, and whether there are any."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import FormError, raised
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import Signature
from ..kernels.numbers.blocks import Block
from ..kernels.numbers.traced import ANYTHING, Algebra, Traced, symbol
from .problem import Problem


def is_formula(problem: Problem, f: Recorded, signature: Signature, rows: dict[str, int]) -> bool:
    """Tell whether a function reads the same rows at every state and time.

    In compiled code, which checks no row, it may then be called far off the motion. Branches on
    numbers, ``int`` of them, and whatever symbols cannot do, say no.
    """
    sizes = {**rows, "work": problem.work}
    given: dict[str, Any] = {k: Block(np.full(n, ANYTHING)) for k, n in sizes.items()}
    given["params"] = Block(problem.params)
    parts = 1 if problem.splitting is None else problem.splitting.parts
    try:
        for k in range(parts):
            given["k"] = k
            f(*(given.get(name, ANYTHING) for name, _ in signature.arguments))
    except Exception:  # whatever the source makes of symbols
        return False
    return True


def traced_field(problem: Problem, algebra: Algebra, time: Any, state: Sequence[Any]) -> list[Any]:
    """Return dy/dt in symbols of time and state.

    Raises
    ------
    FormError
        For a problem without a field, or one that does more with its numbers than formulas do.
    """
    if problem.field is None:
        raise FormError("the problem has no field")
    y = Block(np.array([Traced(symbol, algebra) for symbol in state], dtype=object))
    out, work = (Block(np.empty(rows, dtype=object)) for rows in (len(y), problem.work))
    try:
        problem.field(Block(problem.params), Traced(time, algebra), y, out, work)
    except Exception as error:  # whatever the source makes of such numbers
        what = f"its field is no formula: {raised(error)}"
        raise FormError(what) from error
    return [symbol(rate) for rate in out.data]
