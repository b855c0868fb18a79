"""Whether a problem moves over its base, `Measure.base`, as is declared."""

from __future__ import annotations

import numpy as np

from ..arguments import Array
from ..errors import DeclarationError
from .evaluate import derivative
from .problem import Problem

__all__ = ["check_base"]

AGREES = 1e-6  # of the rates: those of actions are difference quotients


@np.errstate(all="ignore")
def check_base(problem: Problem, y: Array, t: float) -> None:
    """Raise `DeclarationError` unless the base moves by itself, and as the first rows of the state do.

    Looked at where a run begins, and there with other numbers for the fibre.
    """
    measure = problem.measure
    if measure is None or measure.base is None:
        return
    base: Problem = measure.base
    rows, other = base.rows, y.copy()
    other[rows:] = 0.5 * y[rows:] + 0.25 * np.cos(np.arange(problem.rows - rows))
    wanted = derivative(base, y[:rows].copy(), t)
    for state, says in ((y, "as the base does"), (other, "by themselves")):
        off = np.abs(derivative(problem, state, t)[:rows] - wanted)
        if np.isfinite(off).all() and off.max() > AGREES * np.abs(wanted).max():
            what = f"{base.name!r}: the first {rows} rows of the state do not move {says}"
            raise DeclarationError(problem.name, "measure.base", what, "y", int(off.argmax()), rows)
