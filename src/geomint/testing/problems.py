"""What every problem has."""

import functools
import warnings
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from ..arguments import Array, as_vector, whole
from ..problems.base import off_base, stretches_fibre
from ..problems.declaration import check_problem as check_declared
from ..problems.declared import false_claims
from ..problems.evaluate import derivative, rounding_scale, value, vector
from ..problems.forms import Measure
from ..problems.problem import Problem
from ..problems.spaces.conditions import differences
from ..problems.spaces.repair import length
from .groups import check_group
from .judge import checks, hold, small, sure

__all__ = ["check_problem"]

ROUNDING = 1e-13
SLOPES = 1e-6  # of central differences
H, STEP = 1e-5, 1e-4
TIMES = (0.0, 1.0)  # at which a motion is looked at: fields may depend on time
SPREAD = 1e-5  # of a divergence by central differences


@checks(Problem)
def check_problem(problem: Problem, states: Any = 3) -> None:
    """Raise `AssertionError` for the first property of a problem that does not hold.

    Random states are admissible; functions fit what the problem declares; all forms have one
    derivative; constraints vanish, and they and the invariants are constant along it, and none of them
    everywhere; the group is one. The measure is invariant, its divergence along the field is 0, and so
    is that of its base, which moves by itself as the first rows of the state do. The
    clock of a problem in another time is positive.

    Parameters
    ----------
    problem : Problem
    states : int or sequence of arrays
        How many random states are taken, from seeds 0, 1, …; or the states, for a problem that has no
        random ones.
    """
    if isinstance(states, Iterable):
        chosen = [as_vector(f"states[{k}]", y, problem.rows) for k, y in enumerate(states)]
    else:
        chosen = list(_random(problem, whole("states", states, 0)))
    whole("states", len(chosen), 1)
    for y in chosen:
        hold(problem.canonical(y), y, f"problem {problem.name!r} changes an admissible state")
        for form in problem.forms:
            check_declared(problem, y, form, clock=problem.clock is not None)
        if problem.clock is not None:
            sure(
                value(problem, problem.clock, y) > 0.0,
                f"time stands or runs back in {problem.name!r}",
            )
        for t in filter(functools.partial(_admits, problem, y), TIMES):
            for name, f in problem.constraints.items():
                bound = ROUNDING * max(1.0, rounding_scale(problem, f, y))
                text = f"constraint {name!r} of {problem.name!r} is not 0"
                small(value(problem, f, y, t), bound, text)
            for _, _, text in false_claims(problem, y, t):
                sure(False, text)
    for name, f in {**problem.constraints, **problem.invariants}.items():
        way = np.random.default_rng(len(name)).normal(size=problem.rows)
        moves = any(value(problem, f, y + 0.1 * way) != value(problem, f, y) for y in chosen)
        sure(moves, f"{name!r} of {problem.name!r} is the same number at all states")
    if problem.action is not None:
        check_group(problem.action.group, problem.rows, 1)
    if problem.measure is not None and problem.field is not None:
        for y in chosen:
            _check_measure(problem, problem.measure, y)
    base = None if problem.measure is None else problem.measure.base
    if base is not None and base.measure is not None:
        for y in chosen:
            off = off_base(problem, base, y, 0.0)
            sure(not off, f"{base.name!r} is no base of {problem.name!r}: {off}")
            text = f"the fibre of {problem.name!r} over {base.name!r} is stretched"
            small(stretches_fibre(problem, base, y), SLOPES * max(1.0, length(y)), text)
            if base.field is not None:
                _check_measure(base, base.measure, y[: base.rows])


def _random(problem: Problem, count: int) -> Iterator[Array]:
    """Yield random states: admissible as they are, others for other seeds."""
    before = None
    for seed in range(count):
        with warnings.catch_warnings(action="error"):
            y = problem.random_state(seed)
        sure(before is None or (y != before).any(), f"{problem.name!r} has one random state")
        before = y
        yield y


def _admits(problem: Problem, y: Array, t: float) -> bool:
    """Tell whether a state of time 0 is one of time t: whether no constraint depends on time there."""
    constraints = problem.constraints.values()
    return all(value(problem, f, y, t) == value(problem, f, y) for f in constraints)


def _check_measure(problem: Problem, measure: Measure, y: Array) -> None:
    """Hold tr(Tᵀ f_y T) + d/dt (log μ − ½ log det c_y c_yᵀ) to be 0, T a basis of the tangent space."""

    def normals(z: Array) -> Array:
        if measure.manifold is None:
            return np.zeros((len(z), 0))
        conditions = functools.partial(vector, problem, measure.manifold, measure.conditions)
        return differences(conditions, z, STEP * np.eye(len(z))) / STEP

    def log_density(later: Array) -> Array:
        volume = np.linalg.slogdet(normals(later[:-1]).T @ normals(later[:-1]))[1]
        return value(problem, measure.log_density, later[:-1], later[-1]) - 0.5 * np.array([volume])

    rate, basis = derivative(problem, y), np.linalg.qr(normals(y), mode="complete")[0].T
    size, basis = max(1.0, length(rate)), basis[measure.conditions :]
    changes = differences(functools.partial(derivative, problem), y, H * basis) / H
    way = H / size * np.array([[*rate, 1.0]])
    along = differences(log_density, np.array([*y, 0.0]), way)[0, 0] / H * size
    bound = SPREAD * size * max(1.0, float(np.max(np.abs(changes), initial=0.0)))
    text = f"the measure of {problem.name!r} is not invariant: its divergence"
    small(np.sum(changes * basis) + along, bound, text)
