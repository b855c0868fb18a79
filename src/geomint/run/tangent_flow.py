"""The exact derivative of a numerical flow: steps in numbers that carry their derivatives."""

import dataclasses
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from ..arguments import Array, finite
from ..errors import DomainError, MethodError, StepError
from ..methods import Adaptive, Compose, Exact, Method, find_solver
from ..methods.stepper import Stepper
from ..problems.problem import Problem
from .carried_directions import CarriedDirections, columns
from .solve import solve
from .timeline import Timeline, plan_timeline


@dataclass(frozen=True, eq=False)
class TangentFlow:
    """Where a run has led, and the derivative of that by where it began.

    Attributes
    ----------
    y : array, shape (rows,)
        The state: that of `geomint.solve` to the bit, of implicit and adaptive methods to roundings.
    slopes : array, shape (rows, directions)
        DΦ v for each direction v.
    """

    y: Array
    slopes: Array


def tangent_flow(
    problem: Problem,
    y0: Any,
    *,
    t_end: Any = None,
    tau_end: Any = None,
    method: str | Method | None = None,
    step: Any = None,
    t0: float = 0.0,
    directions: Any = None,
    parameters: Any = None,
) -> TangentFlow:
    """Integrate a problem and the derivative of its flow, as the method has it, to rounding.

    Every step is taken in numbers that carry their derivatives (`geomint.kernels.numbers.tangent`):
    the slopes are those of the numerical map itself, for implicit methods of its converged equations,
    whatever their tolerance: the iteration ends where neither values nor slopes change any more. An
    adaptive method's steps are those of its run, as if they had been given: how they would change is
    no part of the slopes.
    On a constraint manifold Φ is differentiated as a map of the numbers of the state; directions that
    are tangent to the manifold stay so if the method stays on it.

    Parameters
    ----------
    problem, y0, t_end, tau_end, method, step, t0
        As those of `geomint.solve`. The end is in the problem's own time: an end in another time
        would move with the state. A default step is what `geomint.solve` begins with, or where such
        a step fails, what it ends with; nothing looks at what it errs by.
    directions : array_like, shape (rows, k), optional
        One a column. Default: all unit vectors, so that the slopes are the matrix DΦ; with
        `parameters` none, so that all begin at the same state.
    parameters : array_like, shape (len(problem.params), k), optional
        How the problem's parameters change with each direction: the slopes are then derivatives of
        the flow by both. A step in time stays what it is.

    Raises
    ------
    ArgumentError, DomainError, FormError, DeclarationError
        As `geomint.solve`.
    MethodError
        For the exact flow, which takes no steps.
    ConvergenceError, NonFiniteError, StepSizeError
        With t, step, residual and iterations.

    Examples
    --------
    >>> import geomint as gi
    >>> scene = gi.load_scene("sphere-n3")
    >>> found = gi.tangent_flow(scene.problem, scene.state, t_end=1.0, step=0.1)
    >>> found.slopes.shape
    (6, 6)
    """
    chosen = find_solver(method, problem)
    given = {"t_end": t_end, "tau_end": tau_end, "t0": t0}
    alone = {**given, "progress": False, "clock": None if tau_end is None else False}
    if isinstance(chosen, Adaptive):
        run = solve(problem, y0, method=chosen, step=step, save_every=1, **alone)
        step, method = abs(run.step), chosen.base
    _, timeline, stepper = started(problem, y0, t_end, tau_end, method, step, t0)
    carried = CarriedDirections(stepper, *_directions(problem, directions, parameters))
    if isinstance(chosen, Adaptive):
        for i, (t, after) in enumerate(pairwise(run.tau)):
            carried.cut(t, after - t, i)
        return TangentFlow(carried.state, carried.slopes)
    assert timeline.steps is not None
    try:
        carried.take(timeline.start, timeline.h, timeline.steps)
        if timeline.remainder != 0.0:
            last = timeline.start + timeline.h * timeline.steps
            carried.cut(last, timeline.remainder, timeline.steps)
    except StepError:
        if step is not None:
            raise
        given["step"] = abs(solve(problem, y0, method=chosen, **alone).step)
        also = {"directions": directions, "parameters": parameters}
        return tangent_flow(problem, y0, method=chosen, **given, **also)
    return TangentFlow(carried.state, carried.slopes)


def _directions(problem: Problem, states: Any, parameters: Any) -> tuple[Array, Array | None]:
    """Return directions of the state, and of the parameters if these move."""
    rows, count = problem.rows, len(problem.params)
    if parameters is None:
        return np.eye(rows) if states is None else columns("directions", states, rows), None
    if count == 0:
        raise DomainError("parameters", parameters, f"none: {problem.name!r} has no parameters")
    moved = columns("parameters", parameters, count)
    if states is None:
        return np.zeros((rows, moved.shape[1])), moved
    wanted = columns("directions", states, rows)
    if wanted.shape != (rows, moved.shape[1]):
        raise DomainError("directions", states, f"as many as of parameters, {moved.shape[1]}")
    return wanted, moved


def started(
    problem: Any, y0: Any, t_end: Any, tau_end: Any, method: Any, step: Any, t0: float
) -> tuple[Array, Timeline, Stepper]:
    """Return where a run begins that is differentiated, its timeline and its stepper; check all."""
    start_time = finite("t0", t0)
    if not isinstance(problem, Problem):
        raise DomainError("problem", problem, "a geomint.Problem")
    chosen = find_solver(method, problem)
    if isinstance(chosen, Exact) or chosen.adaptive:
        raise MethodError(f"method {chosen.name!r} takes no steps of a given length")
    if problem.time == "tau" and t_end is not None:
        raise DomainError("t_end", t_end, "tau_end: an end in another time moves with the state")
    chosen = _iterated_to_rounding(chosen)
    state = problem.canonical(y0)
    flow = chosen.on(problem, state, start_time)
    timeline = plan_timeline(
        problem, chosen, state, t_end, tau_end, step, start_time, compiled=True
    )
    return state, timeline, flow.begin(state, timeline.start, timeline.h, timeline.own_end)


def _iterated_to_rounding(method: Method) -> Method:
    """Return a method without a tolerance: where an iteration stops before, slopes are not exact."""
    if isinstance(method, Compose):
        return dataclasses.replace(method, base=_iterated_to_rounding(method.base))
    if not getattr(method, "iteration_tolerance", 0.0):
        return method
    return dataclasses.replace(method, iteration_tolerance=0.0)  # type: ignore[type-var]
