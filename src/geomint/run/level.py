"""States where quantities have the values that they have at a given one, such as the energy."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arguments import Array, whole
from ..errors import DomainError, GeomintWarning, nearest
from ..problems.evaluate import value
from ..problems.problem import Problem

__all__ = ["states_on_level"]

NEAR_ENOUGH = 1e-11  # of the size of a quantity
ATTEMPTS = 8  # at a state, before there are none
MOST_ITERATIONS = 60
DIFFERENCE = 1e-6  # of the state's size


def states_on_level(
    problem: Problem, y0: Any, count: int, keep: Sequence[str] = ("energy",), seed: int = 0
) -> Array:
    """Return random states where quantities have the values that they have at y0.

    A random state of the problem is moved as little as will do by Newton's method, and put back onto
    the manifold. What is kept is kept to 1e-11 of its size, the constraints and what is 0 to 1e-11.

    Parameters
    ----------
    y0 : array_like
    count : int
        How many.
    keep : names of quantities
    seed : int

    Returns
    -------
    array, shape (count, rows)

    Raises
    ------
    DomainError
        For names that the problem does not have, or if no such states are found.
    """
    state, count = problem.canonical(y0), whole("count", count, 0)
    known = problem.diagnostics
    for name in keep:
        if name not in known:
            expected = f"quantities of {problem.name!r}.{nearest(name, known)}"
            raise DomainError("keep", name, expected)
    kept = (*keep, *(name for name in problem.constraints if name not in keep))
    wanted = np.array([value(problem, name, state) for name in kept])
    asked = np.array([name in keep for name in kept], dtype=bool)
    sizes = np.where(asked & (wanted != 0.0), np.abs(wanted), 1.0)
    rng = np.random.default_rng(whole("seed", seed, 0))
    found: list[Array] = []
    failed = 0
    while len(found) < count:
        moved = _moved(problem, _somewhere(problem, state, rng), kept, wanted, sizes)
        if moved is not None:
            found.append(moved)
        elif (failed := failed + 1) >= ATTEMPTS * (len(found) + 1):
            expected = (
                f"quantities with which other states of {problem.name!r} can be found: it has "
                f"{problem.rows} numbers, constraints: {', '.join(problem.constraints) or 'none'}; "
                "a representation of the system with fewer may have some (scene.model.problems)"
            )
            raise DomainError("keep", list(keep), expected)
    return np.array(found).reshape(count, problem.rows)


def _somewhere(problem: Problem, state: Array, rng: np.random.Generator) -> Array:
    if problem.make_random is not None:
        return problem.random_state(rng)
    size = np.sqrt(np.mean(state * state)) or 1.0
    return _displaced(problem, state, size * rng.normal(size=len(state)))


def _displaced(problem: Problem, z: Array, v: Array) -> Array:
    space = problem.space
    return z + v if space is None else space.retract(z, space.tangent(z, v))


def _moved(
    problem: Problem, z: Array, keep: tuple[str, ...], wanted: Array, sizes: Array
) -> Array | None:
    """Return a state near z where quantities are as wanted, or None: Newton's method, least changes."""

    def missing(y: Array) -> Array:
        return (np.array([value(problem, name, y) for name in keep]) - wanted) / sizes

    try:
        for _ in range(MOST_ITERATIONS):
            here = missing(z)
            if not np.isfinite(here).all():
                return None
            if np.abs(here).max() < NEAR_ENOUGH:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", GeomintWarning)
                    return problem.canonical(z)
            size = np.abs(z).max()
            moves = DIFFERENCE * size * np.eye(len(z))
            slopes = [missing(z + v) - missing(z - v) for v in moves]
            change = np.linalg.pinv(np.transpose(slopes) / (2.0 * DIFFERENCE * size), 1e-9) @ here
            longest = np.abs(change).max() / (0.5 * size)
            z = _displaced(problem, z, -change / max(1.0, longest))
    except (np.linalg.LinAlgError, DomainError):  # beyond the manifold on the way
        pass
    return None
