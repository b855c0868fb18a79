"""Numbers that are integrated beside the state: physical time beside τ, and quadratures.

One number more is one row more, after the state: for the field its rate is the last component, for a
group that acts on the state translations move it.
"""

import functools
from dataclasses import replace
from typing import Any

from ..kernels.compiling.recorded import Recorded
from ..kernels.numbers.blocks import fixed_rows, part
from .forms import Group
from .groups import translations


def field_beside(f: Recorded, rate: Recorded, rows: int) -> Recorded:
    """Return a field of `rows` rows with one more, which moves at the rate of an observable."""
    return generator_beside(f, rate, rows, rows)


@functools.cache
def generator_beside(f: Recorded, rate: Recorded, rows: int, algebra_rows: int) -> Recorded:
    """Return a generator with one more row, by which the group of `group_beside` moves the number."""

    def beside(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        state = fixed_rows(part(y, 0, rows), rows)
        f(params, t, state, fixed_rows(part(out, 0, algebra_rows), algebra_rows), work)
        out[algebra_rows] = rate(params, t, state, work)

    return named_as(beside, f)


def group_beside(group: Group, rows: int) -> Group:
    """Return the group that moves states of `rows` rows, and a number after them."""
    return replace(group, rows=rows) * translations(1)


def named_as(function: Any, f: Recorded) -> Recorded:
    """Return a function recorded under the name of another one."""
    function.__name__ = function.__qualname__ = f.function.__name__
    return Recorded(function)
