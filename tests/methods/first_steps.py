"""States to take a first step from, generic and not, of all systems and test problems.

A kind makes a state of a random one: pieces at rest, single rows that are zero, equal numbers, axes
(fixed points, steady rotations, separatrices), any of them nearly, and pieces of other sizes. What a
problem does not admit is projected as `Problem.state` does it, or left out.
"""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np

import geomint as gi
from tests.problems import examples

Array = Any
Make = Callable[[gi.Problem, Array, np.random.Generator], Array]
FEW = {
    *("seasonal-lotka-volterra", "spherical-pendulum", "neumann-3", "sphere-metric-3"),
    *("chaplygin-sphere-hamiltonized", "chaplygin-sphere-reduced", "classical-ball"),
}


@cache
def problems(form: str, few: bool = False) -> list[tuple[gi.Problem, Array]]:
    """Return problems of a form with up to 24 rows, each with a state: no two of one name and size.

    Of all scenes and test problems; or a few of them.
    """
    scenes = ("hamiltonized-n3", "sphere-n3", "ball-3d") if few else gi.scene_names()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gi.GeomintWarning)
        models = [gi.load_scene(name).model for name in scenes]
    of_scenes = [(p, m.states[name]) for m in models for name, p in m.problems.items()]
    found: dict[tuple[str, int], tuple[gi.Problem, Array]] = {}
    for p, y in (*of_scenes, *examples()):
        found.setdefault((p.name, p.rows), (p, np.asarray(y)))
    chosen = [(p, y) for p, y in found.values() if form in p.forms and p.rows <= 24]
    return [(p, y) for p, y in chosen if not few or p.name in FEW]


def generic(problem: gi.Problem, y0: Array, rng: np.random.Generator) -> Array:
    if problem.make_random is not None and rng.random() < 0.7:
        return problem.random_state(rng)
    size = np.max(np.abs(y0))
    return y0 * (1.0 + 0.3 * rng.normal(size=len(y0))) + 0.05 * size * rng.normal(size=len(y0))


def at_rest(problem: gi.Problem, y: Array, rng: np.random.Generator) -> Array:
    """Some pieces are zero, or all."""
    pieces = list(problem.slices.values())
    for piece in rng.permutation(len(pieces))[: rng.integers(1, len(pieces) + 1)]:
        y[pieces[piece]] = 0.0
    return y


def zero_rows(problem: gi.Problem, y: Array, rng: np.random.Generator) -> Array:
    y[rng.permutation(len(y))[: rng.integers(1, 3)]] = 0.0
    return y


def equal_rows(problem: gi.Problem, y: Array, rng: np.random.Generator) -> Array:
    for piece in problem.slices.values():
        if rng.random() < 0.6:
            y[piece] = y[piece][0]
    return y


def on_axes(problem: gi.Problem, y: Array, rng: np.random.Generator) -> Array:
    """Pieces lie on axes: fixed points, steady rotations, separatrices."""
    for piece in problem.slices.values():
        y[piece] = 0.0
        y[rng.integers(piece.start, piece.stop)] = rng.choice([1.0, -1.0, 0.5])
    return y


def other_sizes(problem: gi.Problem, y: Array, rng: np.random.Generator) -> Array:
    for piece in problem.slices.values():
        if rng.random() < 0.5:
            y[piece] *= 10.0 ** rng.choice([-150, -20, -8, -3, 2])
    return y


def nearly(make: Make) -> Make:
    def near(problem: gi.Problem, y0: Array, rng: np.random.Generator) -> Array:
        y = make(problem, y0, rng)
        return y + 10.0 ** rng.choice([-3, -6, -9, -12, -15, -17, -100]) * rng.normal(size=len(y))

    return near


KINDS: dict[str, Make] = {
    "generic": lambda problem, y, rng: y,
    "at rest": at_rest,
    "zero rows": zero_rows,
    "equal rows": equal_rows,
    "on axes": on_axes,
    "nearly at rest": nearly(at_rest),
    "nearly equal rows": nearly(equal_rows),
    "nearly on axes": nearly(on_axes),
    "other sizes": other_sizes,
}


def admitted(problem: gi.Problem, y: Array) -> Array | None:
    """Return the state, if need be projected, or None."""
    with contextlib.suppress(gi.GeomintError):
        return problem.canonical(y)
    with contextlib.suppress(gi.GeomintError, TypeError):  # made of other components
        return problem.state(**{name: y[piece] for name, piece in problem.slices.items()})
    return None


def states(problem: gi.Problem, y0: Array, kind: str, count: int, seed: int) -> Iterator[Array]:
    """Yield up to `count` admitted states of a kind with finite derivatives."""
    rng = np.random.default_rng([seed, list(KINDS).index(kind), len(y0)])
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", gi.GeomintWarning)
        for _ in range(count):
            y = admitted(problem, KINDS[kind](problem, generic(problem, y0, rng).copy(), rng))
            if y is not None and np.isfinite(gi.derivative(problem, y)).all():
                yield y
