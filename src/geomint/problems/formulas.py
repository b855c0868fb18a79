"""A function's source, run once on symbols: formulas as others see them, and whether there are any."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arguments import Array
from ..errors import FormError, raised
from ..kernels.compiling.bound import Bound
from ..kernels.compiling.signatures import FIELD
from ..kernels.numbers.blocks import Block
from ..kernels.numbers.traced import ANYTHING, Algebra, Traced, symbol
from .bound import given_at
from .problem import Problem


def is_formula(problem: Problem, f: Bound) -> bool:
    """Tell whether a function reads the same rows at every state and time.

    In compiled code, which checks no row, it may then be called far off the motion. Branches on
    numbers, ``int`` of them, and whatever symbols cannot do, say no.
    """
    given: dict[str, Any] = {**dict(f.rows), "params": problem.params, "work": problem.work}
    parts = 1 if problem.splitting is None else problem.splitting.parts
    try:
        for k in range(parts):
            f.signature.run(f.recorded, _of_anything, **given, k=k, t=ANYTHING, h=ANYTHING)
    except Exception:  # whatever the source makes of symbols
        return False
    return True


def _of_anything(numbers: Array) -> Block:
    return Block(np.full(len(numbers), ANYTHING))


def traced_field(problem: Problem, algebra: Algebra, time: Any, state: Sequence[Any]) -> list[Any]:
    """Return dy/dt in symbols of time and state.

    Raises
    ------
    FormError
        For a problem without a field, or one that does more with its numbers than formulas do.
    """
    if problem.field is None:
        raise FormError("the problem has no field")
    y = np.array([Traced(symbol, algebra) for symbol in state], dtype=object)
    given = given_at(problem, y, t=Traced(time, algebra))
    try:
        (out,) = FIELD.run(problem.field, lambda x: Block(x.astype(object)), **given)
    except Exception as error:  # whatever the source makes of such numbers
        what = f"its field is no formula: {raised(error)}"
        raise FormError(what) from error
    return [symbol(rate) for rate in out]
