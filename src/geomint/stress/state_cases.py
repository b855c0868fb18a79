"""Special states of all built-in scenes and test problems, and states at a distance from them."""

from collections.abc import Iterable, Iterator
from functools import partial

import numpy as np

from ..arguments import Array
from ..problems.evaluate import derivative
from ..problems.problem import Problem
from ..problems.systems import Model
from ..problems.time_scale import characteristic_time
from .case import StressAxis, StressCase
from .special_states import (
    Make,
    allowed,
    equal_rows,
    is_steady,
    on_axes,
    resting,
    resting_pieces,
    zero_rows,
)
from .step_cases import QUICK, Build, Source

REST = StressAxis("rest", "pieces at rest", "their size, relative")
ZEROS = StressAxis("zeros", "zero and equal rows", "distance")
STEADY = StressAxis("steady", "steady motions and fixed points", "distance")

_RESTS = (1e-8, 1e-100, 0.0)
_ZEROS = (1e-10, 0.0)
_DISTANCES = (1e-1, 1e-6, 1e-12, 0.0)
_FRACTION, _STEPS = 0.02, 50  # in times of the usual state: what stands still has none
_MOST_ROWS = 30
_TRIES = 40  # random choices until one is admitted


def cases(sources: Iterable[Source]) -> list[StressCase]:
    """Return the cases of the three axes, each problem in its smallest size."""
    smallest: dict[tuple[str, tuple[str, ...]], tuple[str, Build, str, Problem, Array]] = {}
    for source, build in sources:
        model = build()
        for name, problem in model.problems.items():
            key = problem.name, tuple(problem.slices)
            if key not in smallest or problem.rows < smallest[key][3].rows:
                smallest[key] = source, build, name, problem, model.states[name]
    return [
        case for source, build, name, problem, y0 in smallest.values()
        if problem.rows <= _MOST_ROWS
        for case in _of_problem(source, build, name, problem, y0)
    ]  # fmt: skip


def _of_problem(
    source: str, build: Build, name: str, problem: Problem, y0: Array
) -> Iterator[StressCase]:
    time = characteristic_time(problem, y0)

    def along(
        axis: StressAxis, values: tuple[float, ...], kind: str, special: Array | None
    ) -> Iterator[StressCase]:
        """Yield states on the way from the special one to the usual one."""
        if special is None:
            return
        for value in values:
            away = value * (y0 - special)
            if "g" in problem.slices:  # between two rotations there is none
                away[problem.slices["g"]] = 0.0
            y = allowed(problem, special + away)
            if y is not None:
                yield StressCase(
                    f"{source}-{kind}",
                    axis,
                    value,
                    0,
                    partial(_started, build, name, y),
                    representations=(name,),
                    step=_FRACTION * time,
                    steps=_STEPS,
                    steady=axis is STEADY and value == 0.0 and is_steady(problem, y),
                    quick=(name,) if name == QUICK and value == 0.0 else (),
                )

    for pieces in resting_pieces(problem, y0):
        yield from along(REST, _RESTS, "-".join(pieces), resting(problem, y0, pieces))
    kinds: dict[str, Make] = {"zero-rows": zero_rows, "equal-rows": equal_rows}
    for kind, make in kinds.items():
        yield from along(ZEROS, _ZEROS, kind, _first(problem, y0, make))
    special = _first(problem, y0, on_axes)
    yield from along(STEADY, _DISTANCES, "axes", special)
    still = resting_pieces(problem, special) if special is not None else []
    if special is not None and still:
        yield from along(STEADY, _DISTANCES, "still", resting(problem, special, still[0]))


def _first(problem: Problem, y0: Array, make: Make) -> Array | None:
    """Return the first state of a kind that is admitted and moves at a finite velocity."""
    rng = np.random.default_rng(1)
    for _ in range(_TRIES):
        y = allowed(problem, make(problem, y0, rng))
        if y is not None and np.isfinite(derivative(problem, y)).all():
            return y
    return None


def _started(build: Build, name: str, y: Array) -> Model:
    return Model({name: build().problems[name]}, {name: y})
