"""How far states are apart, and states that are off by a little: each piece in its own unit.

What a state is made of may have sizes that differ by any factor, so that differences of a piece are
given relative to the largest number of that piece.
"""

import dataclasses
import functools
from collections.abc import Mapping

import numpy as np

from ..arguments import Array, Integers
from .problem import Problem
from .spaces.pieces import Pieces


def pieces_of(problem: Problem, y: Array) -> dict[str, Array]:
    """Return the pieces of a flat state by name."""
    return {name: y[rows] for name, rows in problem.slices.items()}


def sizes_of(problem: Problem, y: Array) -> Array:
    """Return for each number of a state the largest of its piece; of the state, where that is 0."""
    starts, lengths = _places(problem.pieces)
    largest = np.maximum.reduceat(np.abs(y), starts)
    if not largest.all():
        largest[largest == 0.0] = largest.max() or 1.0
    return largest.repeat(lengths)


@functools.lru_cache(maxsize=256)
def _places(pieces: Pieces) -> tuple[Integers, Integers]:
    """Return where pieces begin, and how long they are."""
    lengths = np.array([rows for _, rows in pieces])
    return np.cumsum(lengths) - lengths, lengths


def shifted(problem: Problem, y0: Array, seed: int, shift: float) -> tuple[Problem, Array]:
    """Return parameters and state off by that; parameters upwards, as some are counts.

    A piece that is 0 stays so, and so do parameters of the space, which is another one without.
    """
    rng = np.random.default_rng(seed)
    y = y0.copy()
    for rows in problem.slices.values():
        size = float(np.max(np.abs(y[rows])))
        y[rows] += shift * size * rng.choice([-1.0, 1.0], rows.stop - rows.start)
    moves = rng.choice([0.0, 1.0], len(problem.params))
    moves[: 0 if problem.space is None else len(problem.space.params)] = 0.0
    params = problem.params * (1.0 + shift * moves)
    return dataclasses.replace(problem, params=params), y


def relative_error(found: Mapping[str, Array], right: Mapping[str, Array]) -> float:
    """Return the largest difference of a piece, relative to the largest number of that piece.

    A piece that is 0 is measured against the whole state. What is not finite is infinitely far.
    """
    whole = max(float(np.max(np.abs(value))) for value in right.values())
    return max(_relative(found[name], value, whole) for name, value in right.items())


def _relative(found: Array, right: Array, whole: float) -> float:
    off, size = float(np.max(np.abs(found - right))), float(np.max(np.abs(right)))
    if off == 0.0:
        return 0.0
    ratio = off / (size or whole or 1.0)
    return ratio if ratio == ratio else np.inf
