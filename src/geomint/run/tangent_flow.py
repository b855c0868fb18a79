"""The exact derivative of a numerical flow: steps in numbers that carry their derivatives."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arguments import Array, as_array, finite
from ..errors import DomainError, MethodError
from ..kernels.compiling.number_types import NumberType
from ..kernels.numbers.blocks import Block, scalar_block
from ..kernels.solve.advance import bound_stepper
from ..kernels.solve.status import OK
from ..methods import Compose, Exact, Method, find_solver
from ..methods.method import Start
from ..methods.stepper import Advance, Stepper
from ..methods.tangent import AT_ONCE, tangent_type
from ..problems.declaration import check_problem
from ..problems.problem import Problem
from .timeline import Timeline, plan_timeline

__all__ = ["TangentFlow", "columns", "started", "tangent_flow"]

PIECE = 1000  # steps between which Ctrl-C is seen


@dataclass(frozen=True, eq=False)
class TangentFlow:
    """Where a run has led, and the derivative of that by where it began.

    Attributes
    ----------
    y : array, shape (rows,)
        The state: that of `geomint.solve` to the bit, of implicit methods to a rounding.
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
    whatever their tolerance: the iteration ends where neither values nor slopes change any more.
    On a constraint manifold Φ is differentiated as a map of the numbers of the state; directions that
    are tangent to the manifold stay so if the method stays on it.

    Parameters
    ----------
    problem, y0, t_end, tau_end, method, step, t0
        As those of `geomint.solve`. The end is in the problem's own time: an end in another time
        would move with the state.
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
        For adaptive methods and the exact flow, which take no steps of a given length.
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
    state, timeline, stepper = started(problem, y0, t_end, tau_end, method, step, t0)
    wanted, moved = _directions(problem, directions, parameters)
    y, slopes = state, [np.zeros((problem.rows, 0))]
    for first in range(0, wanted.shape[1], AT_ONCE):
        some = slice(first, first + AT_ONCE)
        of_params = None if moved is None else moved[:, some]
        y, found = _flown(stepper, timeline, wanted[:, some], of_params)
        slopes.append(found)
    return TangentFlow(y, np.concatenate(slopes, axis=1))


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
    chosen = find_solver(method)
    if isinstance(chosen, Exact) or chosen.adaptive:
        raise MethodError(f"method {chosen.name!r} takes no steps of a given length")
    if problem.time == "tau" and t_end is not None:
        raise DomainError("t_end", t_end, "tau_end: an end in another time moves with the state")
    chosen = _iterated_to_rounding(chosen)
    state = problem.canonical(y0)
    chosen.check_fits(problem, False)
    check_problem(problem, state, chosen.needs)
    timeline = plan_timeline(problem, chosen, state, t_end, tau_end, step, start_time)
    stepper = chosen.start(Start(problem, state, timeline.start, timeline.h))
    return state, timeline, stepper


def _iterated_to_rounding(method: Method) -> Method:
    """Return a method without a tolerance: where an iteration stops before, slopes are not exact."""
    if isinstance(method, Compose):
        return dataclasses.replace(method, base=_iterated_to_rounding(method.base))
    if not getattr(method, "tolerance", 0.0):
        return method
    return dataclasses.replace(method, tolerance=0.0)  # type: ignore[type-var]


def columns(name: str, directions: Any, rows: int) -> Array:
    """Return directions that are given, one a column."""
    expected = f"finite numbers in {rows} rows, a direction a column"
    found: Array = as_array(name, directions, expected)
    fits = found.ndim == 2 and len(found) == rows and found.shape[1] > 0
    if not (fits and np.isfinite(found).all()):
        raise DomainError(name, directions, expected)
    return found


def _flown(
    stepper: Stepper, timeline: Timeline, directions: Array, moved: Array | None
) -> tuple[Array, Array]:
    """Return the state at the end, and what becomes of at most eight directions."""
    steps = _Steps(stepper, tangent_type(stepper, AT_ONCE, moved is not None), moved)
    rows = stepper.rows
    memory = np.zeros((len(stepper.memory), 1 + AT_ONCE))
    memory[:, 0] = stepper.memory.data
    memory[:rows, 1 : 1 + directions.shape[1]] = directions
    assert timeline.steps is not None
    memory = steps.take(memory, timeline.start, timeline.h, timeline.steps)
    if timeline.remainder != 0.0:
        memory[2 * rows :] = 0.0
        last = timeline.start + timeline.h * timeline.steps
        memory = steps.take(memory, last, timeline.remainder, 1, timeline.steps)
    return memory[:rows, 0].copy(), memory[:rows, 1 : 1 + directions.shape[1]].copy()


class _Steps:
    """The steps of a method in another type of number."""

    def __init__(self, stepper: Stepper, kind: NumberType, moved: Array | None) -> None:
        self._stepper, self._held = stepper, kind.memory.held
        params = stepper.params
        if moved is not None:
            params = self._block(len(params))
            rows = params.data.reshape(len(params), -1)
            rows[:, 0], rows[:, 1 : 1 + moved.shape[1]] = stepper.params.data, moved
        work = self._block(len(stepper.work))
        self._call = bound_stepper(stepper.kernel, stepper.functions).call(
            number_type=kind,
            functions=stepper.functions,
            params=params,
            coefficients=stepper.coefficients,
            fractions=stepper.fractions,
            work=work,
            rows=stepper.rows,
            out=self._block(0),
        )

    def _block(self, rows: int) -> Block:
        block: Block = self._held(scalar_block(rows * self._held.width).data)
        return block

    def take(self, memory: Array, t: float, h: float, steps: int, before: int = 0) -> Array:
        """Return what is remembered after so many steps."""
        block = self._block(len(memory))
        block.data[:] = memory.ravel()
        for first in range(0, steps, PIECE):
            count = min(PIECE, steps - first)
            done = Advance(
                *self._call(
                    memory=block, t0=t, h=h, first=first, count=count, every=count + first + 1
                )
            )
            if done.status != OK:
                stepper = self._stepper
                stepper.move(t, h)
                raise stepper.error(done, first, before)
        return block.data.reshape(memory.shape).copy()
