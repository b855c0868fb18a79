"""Whether a problem moves over its base, `Measure.base`, as is declared."""

from __future__ import annotations

import numpy as np

from ..arguments import Array
from .evaluate import derivative
from .problem import Problem

__all__ = ["off_base"]

AGREES = 1e-6  # of the rates: those of actions are difference quotients


@np.errstate(all="ignore")
def off_base(problem: Problem, base: Problem, y: Array, t: float) -> str:
    """Return in words what is not as it is over a base, at a state; an empty string if all is.

    The first rows of the state are to move as the base does, whatever the fibre, and the fibre by
    rates that are affine in it.
    """
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
        size = max(float(np.abs(right).max()), float(np.abs(found).max()))
        if not np.abs(found - right).max() <= AGREES * size:
            return says
    return ""
