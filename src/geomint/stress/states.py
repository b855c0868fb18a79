"""Special states of a problem, made of a usual one: pieces at rest, rows zero or equal, axes.

They are those where formulas divide by nothing. What a problem does not admit is projected as
`Problem.state` does it; where that is refused as well, there is none.
"""

import functools
from collections.abc import Callable, Sequence
from itertools import combinations, islice

import numpy as np

from ..arguments import Array
from ..errors import Gathered, GeomintError
from ..kernels.numbers.blocks import Block
from ..problems.evaluate import derivative, on_constraints, value, vector
from ..problems.problem import Problem
from ..problems.spaces.conditions import brought_back
from .case import Names

Make = Callable[[Problem, Array, np.random.Generator], Array]

UNCHANGED = 1e-14  # relative: generators that differ by less are the same
ON = 1e-13  # what is on a constraint
TURNS = (0.3, 1.7, 4.0)  # of the largest row of the generator
TRIES = 40  # random choices until one is admitted


def zero_rows(problem: Problem, y0: Array, rng: np.random.Generator) -> Array:
    """Return the state with one or two zero rows."""
    y = y0.copy()
    y[rng.permutation(len(y))[: rng.integers(1, 3)]] = 0.0
    return y


def equal_rows(problem: Problem, y0: Array, rng: np.random.Generator) -> Array:
    """Return the state with pieces whose rows are all the same."""
    y = y0.copy()
    for piece in problem.slices.values():
        if rng.random() < 0.6:
            y[piece] = y[piece][0]
    return y


def on_axes(problem: Problem, y0: Array, rng: np.random.Generator) -> Array:
    """Return a state whose pieces lie on axes: fixed points, steady rotations, separatrices."""
    y = y0.copy()
    for name, piece in problem.slices.items():
        rows = piece.stop - piece.start
        n = round(rows**0.5)
        if name == "g" and n * n == rows:
            rotation = np.eye(n)[rng.permutation(n)]
            rotation[0] *= np.linalg.det(rotation)
            y[piece] = rotation.ravel()
        else:
            y[piece] = 0.0
            y[piece.start + rng.integers(rows)] = rng.choice([1.0, -1.0, 0.5])
    return y


def resting(problem: Problem, y0: Array, names: Sequence[str]) -> Array:
    """Return the state with those pieces zero."""
    y = y0.copy()
    for name in names:
        y[problem.slices[name]] = 0.0
    return y


def resting_pieces(problem: Problem, y0: Array) -> list[Names]:
    """Return the single pieces that may be zero in a state, and all that may be so together."""

    def may(names: Sequence[str]) -> bool:
        y = allowed(problem, resting(problem, y0, names))
        return y is not None and not any(y[problem.slices[name]].any() for name in names)

    names = list(problem.slices)
    sets = [s for k in range(len(names), 0, -1) for s in combinations(names, k) if may(s)]
    return list(dict.fromkeys([*sets[:1], *(s for s in sets if len(s) == 1)]))


@np.errstate(all="ignore")
def allowed(problem: Problem, y: Array) -> Array | None:
    """Return the state, if need be projected to its manifold, or None."""
    bare, space = problem.admit is None, problem.space
    with Gathered(quiet=True):
        if bare and problem.hamiltonian is not None:  # of which any state is admitted
            y = on_constraints(problem, y, projected=True)
        try:
            state = problem.canonical(y)
        except GeomintError:
            try:
                state = problem.state(**{name: y[rows] for name, rows in problem.slices.items()})
            except (GeomintError, TypeError):  # TypeError: its state is made of other components
                return None
    if space is not None and "g" not in problem.slices:  # what is admitted may be off by more
        return brought_back(space.defects, space.normals, state)
    off = [value(problem, f, state) for f in problem.constraints if bare]
    return state if np.max(np.abs(off), initial=0.0) <= ON else None


@np.errstate(all="ignore")
def is_steady(problem: Problem, y0: Array) -> bool:
    """Tell whether y(t) = exp(tξ)·y0 solves ẏ = ξ(t, y)·y with one ξ, to rounding.

    It does if ξ(t, exp(tξ)·y0) = ξ for all t: looked at for some.
    """
    if problem.action is None:
        return False
    group, generator = problem.action.group, problem.action.generator
    xi_at = functools.partial(vector, problem, generator, group.algebra_rows)
    xi = xi_at(y0)
    size = float(np.max(np.abs(xi)))
    for t in np.array(TURNS) / (size or 1.0):
        increment, work = np.zeros(problem.rows), Block(np.zeros(group.work))
        group.act(Block(group.layout), Block(t * xi), Block(y0), Block(increment), work)
        if not np.max(np.abs(xi_at(y0 + increment, t) - xi)) <= UNCHANGED * size:
            return False
    return True


def first(problem: Problem, y0: Array, make: Make) -> list[Array]:
    """Return the first state of a kind that is admitted and moves at a finite velocity; or none."""
    rng = np.random.default_rng(1)
    tries = (allowed(problem, make(problem, y0, rng)) for _ in range(TRIES))
    good = (y for y in tries if y is not None and np.isfinite(derivative(problem, y)).all())
    return list(islice(good, 1))
