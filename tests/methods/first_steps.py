"""States to take a first step from, generic and not, of all systems and test problems.

A kind makes a state of a random one: pieces at rest, single rows that are zero, equal numbers, axes
(fixed points, steady rotations, separatrices), any of them nearly, and pieces of other sizes. What a
problem does not admit is projected as `Problem.state` does it, or left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

import geomint as gi
from geomint.stress import step_cases
from geomint.stress.state_cases import (
    Make,
    admitted,
    equal_rows,
    on_axes,
    zero_rows,
)
from tests.problems import examples

Array = Any
FEW = {
    ("seasonal-lotka-volterra", 2),
    ("spherical-pendulum", 6),
    ("neumann-3", 6),
    ("sphere-metric-3", 6),
    ("chaplygin-sphere-hamiltonized", 6),
    ("chaplygin-sphere-reduced", 6),
    ("classical-ball", 6),
}


@cache
def problems(form: str, few: bool = False) -> list[tuple[gi.Problem, Array]]:
    """Return problems of a form with up to 24 rows, each with a state: no two of one name and size.

    Of all scenes and test problems; or a few of them, which other tests compile too.
    """
    found: dict[tuple[str, int], tuple[gi.Problem, Array]] = {}
    for _, build in step_cases.sources(examples):
        model = build()
        for name, problem in model.problems.items():
            found.setdefault((problem.name, problem.rows), (problem, model.states[name]))
    chosen = [(p, y) for p, y in found.values() if form in p.forms and p.rows <= 24]
    return [(p, y) for p, y in chosen if not few or (p.name, p.rows) in FEW]


def generic(problem: gi.Problem, y0: Array, rng: np.random.Generator) -> Array:
    if problem.make_random is not None and rng.random() < 0.7:
        return problem.random_state(rng)
    size = np.max(np.abs(y0))
    return y0 * (1.0 + 0.3 * rng.normal(size=len(y0))) + 0.05 * size * rng.normal(size=len(y0))


def at_rest(problem: gi.Problem, y0: Array, rng: np.random.Generator) -> Array:
    """Return the state with some pieces zero, or all."""
    y = y0.copy()
    pieces = list(problem.slices.values())
    for piece in rng.permutation(len(pieces))[: rng.integers(1, len(pieces) + 1)]:
        y[pieces[piece]] = 0.0
    return y


def made(make: Make) -> Make:
    """Return that kind, made of a generic state."""

    def of_generic(problem: gi.Problem, y0: Array, rng: np.random.Generator) -> Array:
        return make(problem, generic(problem, y0, rng), rng)

    return of_generic


def nearly(make: Make) -> Make:
    def near(problem: gi.Problem, y0: Array, rng: np.random.Generator) -> Array:
        y = make(problem, y0, rng)
        return y + 10.0 ** rng.choice([-3, -6, -9, -12, -15, -17, -100]) * rng.normal(size=len(y))

    return near


def other_sizes(problem: gi.Problem, y0: Array, rng: np.random.Generator) -> Array:
    y = generic(problem, y0, rng)
    for piece in problem.slices.values():
        if rng.random() < 0.5:
            y[piece] *= 10.0 ** rng.choice([-150, -20, -8, -3, 2])
    return y


KINDS: dict[str, Make] = {
    "generic": generic,
    "at rest": made(at_rest),
    "zero rows": made(zero_rows),
    "equal rows": made(equal_rows),
    "on axes": made(on_axes),
    "nearly at rest": nearly(made(at_rest)),
    "nearly equal rows": nearly(made(equal_rows)),
    "nearly on axes": nearly(made(on_axes)),
    "other sizes": other_sizes,
}


def states(problem: gi.Problem, y0: Array, kind: str, count: int, seed: int) -> Iterator[Array]:
    """Yield up to `count` admitted states of a kind with finite derivatives."""
    rng = np.random.default_rng([seed, list(KINDS).index(kind), len(y0)])
    with np.errstate(all="ignore"):
        for _ in range(count):
            y = admitted(problem, KINDS[kind](problem, y0, rng))
            if y is not None and np.isfinite(gi.derivative(problem, y)).all():
                yield y
