"""Which rows of a state a problem's conditions depend on, found by numbers that are not."""

from __future__ import annotations

import numpy as np

from ..arguments import Array
from ..kernels.compiling.recorded import Recorded
from ..problems.evaluate import vector
from ..problems.problem import Problem

__all__ = ["find_supports"]


def find_supports(problem: Problem, conditions: Recorded | None, m: int, y0: Array) -> list[Array]:
    """Return lows, pivots, ends, free rows and the most rows: `geomint.kernels.tangent.supports`.

    A piece that is NaN makes every condition NaN that depends on it. Conditions with pieces in common
    are one group, whose rows are all those from its first piece to its last.
    """
    lows, ends = np.zeros(m, dtype=int), np.full(m, problem.rows)
    if conditions is not None:
        lows, ends = _joined(*_ranges(problem, conditions, m, y0), problem.rows)
    before = [int(np.sum(lows[:a] == lows[a])) for a in range(m)]
    pivots = lows + np.array(before, dtype=int)
    free = np.setdiff1d(np.arange(problem.rows), pivots)
    return [lows, pivots, ends, free, np.array([np.max(ends - lows, initial=0)])]


def _ranges(problem: Problem, conditions: Recorded, m: int, y0: Array) -> tuple[Array, Array]:
    """Return the first row that each condition depends on, and that after the last: or all rows."""
    lows, ends = np.full(m, problem.rows), np.zeros(m, dtype=int)
    try:
        with np.errstate(all="ignore"):
            for piece in problem.slices.values():
                y = y0.copy()
                y[piece] = np.nan
                found = np.isnan(vector(problem, conditions, m, y))
                lows[found] = np.minimum(lows[found], piece.start)
                ends[found] = np.maximum(ends[found], piece.stop)
    except (ArithmeticError, ValueError):  # of functions that ask for whole numbers
        return np.zeros(m, dtype=int), np.full(m, problem.rows)
    unknown = lows >= ends
    return np.where(unknown, 0, lows), np.where(unknown, problem.rows, ends)


def _joined(lows: Array, ends: Array, rows: int) -> tuple[Array, Array]:
    """Return ranges, of which those that overlap are made one; all rows if one has too few."""
    for _ in lows:
        for a in range(len(lows)):
            meets = (lows < ends[a]) & (ends > lows[a])
            lows[meets], ends[meets] = lows[meets].min(), ends[meets].max()
    counts = np.array([np.sum(lows == low) for low in lows])
    if (counts > ends - lows).any():  # dependent ones: as they come
        return np.zeros_like(lows), np.full_like(ends, rows)
    return lows, ends
