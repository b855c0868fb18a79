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

    And the rest by rates that are affine in it. Looked at where a run begins, and there with other
    numbers for the fibre.
    """
    measure = problem.measure
    if measure is None or measure.base is None:
        return
    base: Problem = measure.base
    rows = base.rows

    def rates(fibre: Array) -> Array:
        return derivative(problem, np.concatenate((y[:rows], fibre)), t)

    here, away = y[rows:], 0.25 * np.cos(np.arange(problem.rows - rows))
    at, beyond, other = rates(here), rates(here + 2.0 * away), rates(here + away)
    wanted = derivative(base, y[:rows].copy(), t)
    for found, right, says in (
        (at[:rows], wanted, "the first rows of the state do not move as the base does"),
        (other[:rows], wanted, "the first rows of the state do not move by themselves"),
        (at[rows:] + beyond[rows:], 2.0 * other[rows:], "rates of the fibre are not affine in it"),
    ):
        off, size = np.abs(found - right), max(np.abs(right).max(), np.abs(found).max())
        if np.isfinite(off).all() and off.max() > AGREES * size:
            what = f"{base.name!r}: {says}"
            raise DeclarationError(problem.name, "measure.base", what, "y", int(off.argmax()), rows)
