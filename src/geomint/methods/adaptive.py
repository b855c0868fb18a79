"""Adaptive steps: tolerances, the first step, and steppers that choose their steps themselves."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import (
    DomainError,
    MethodError,
    NonFiniteError,
    StepError,
    StepLimitError,
    StepSizeError,
)
from ..evaluate import derivative
from ..kernels.adaptive import END, LARGEST, NEXT, REMEMBERED, SMALLEST
from ..kernels.blocks import Block, scalar_block
from ..kernels.recorded import Recorded
from ..kernels.status import NOT_FINITE, OK, OUTSIDE_CHART, TOO_MANY_STEPS
from ..problem import Problem
from ..tableaux import Tableau
from .forms import piece_numbers
from .lane_stepper import LaneStepper
from .method import Method, Start
from .stepper import Advance, Stepper, filled_block

__all__ = ["AdaptiveStepper", "Tolerances", "adaptive_stepper", "made_adaptive", "tolerances"]

Array = npt.NDArray[np.float64]
LEAST_RTOL = 2.0**-50


@dataclass(frozen=True)
class Tolerances:
    """What a step may err, how long it may be, and how many there may be.

    The estimated error of a step must not exceed ``atol + rtol max |y_i|`` in any piece of the state,
    with y_i the rows of the piece before and after the step.
    """

    rtol: float = 1e-8
    atol: float = 1e-12
    max_step: float = math.inf
    max_steps: int = 10**8

    def __post_init__(self) -> None:
        if not LEAST_RTOL <= self.rtol <= 0.1:
            raise DomainError("rtol", self.rtol, "a number from 2⁻⁵⁰ = 8.9e-16 to 0.1")
        if not 0.0 <= self.atol < math.inf:
            raise DomainError("atol", self.atol, "a number ≥ 0")
        if not self.max_step > 0.0:
            raise DomainError("max_step", self.max_step, "a number > 0")
        if not isinstance(self.max_steps, int | np.integer) or self.max_steps < 1:
            raise DomainError("max_steps", self.max_steps, "a whole number ≥ 1")

    def first_step(self, order: int, problem: Problem, y0: Array, end: float) -> float:
        """Return the length of a first step towards `end`, for a method of some order.

        The algorithm of Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, Section
        II.4: the explicit Euler method would make an error of the tolerance's size, from estimates
        of two derivatives.
        """
        sizes = np.zeros(problem.rows)
        for rows in problem.slices.values():
            sizes[rows] = np.max(np.abs(y0[rows]))
        allowed = self.atol + self.rtol * sizes
        allowed[allowed == 0.0] = math.inf

        def norm(v: Array) -> float:
            return float(np.max(np.abs(v) / allowed))

        with np.errstate(all="ignore"):
            slope = derivative(problem, y0)
            d0, d1 = norm(y0), norm(slope)
            h0 = 0.01 * d0 / d1 if min(d0, d1) > 1e-5 else 1e-6
            h0 = math.copysign(min(h0, abs(end)), end)
            d2 = norm(derivative(problem, y0 + h0 * slope, h0) - slope) / abs(h0)
            largest = max(d1, d2)
            h1 = (0.01 / largest) ** (1.0 / (order + 1)) if largest > 1e-15 else 1e-3 * abs(h0)
        h = min(100.0 * abs(h0), h1, self.max_step, abs(end))
        return h if 0.0 < h < math.inf else 1e-6 * abs(end)


def tolerances(
    table: Tableau,
    adaptive: bool,
    rtol: float | None,
    atol: float | None,
    max_step: float | None,
    max_steps: int | None,
) -> Tolerances | None:
    """Return what the options of a method say, None for fixed steps; or raise."""
    given = {"rtol": rtol, "atol": atol, "max_step": max_step, "max_steps": max_steps}
    given = {name: value for name, value in given.items() if value is not None}
    if not adaptive:
        if given:
            raise MethodError(f"{', '.join(given)}: only with adaptive=True")
        return None
    if table.estimate_order is None:
        raise MethodError(f"tableau {table.name!r} has no embedded method to estimate errors with")
    for name, value in given.items():
        if isinstance(value, bool) or not isinstance(value, int | float | np.number):
            raise DomainError(name, value, "a number")
    limit = Tolerances.max_steps if max_steps is None else max_steps
    numbers = {name: float(v) for name, v in given.items() if v is not None and name != "max_steps"}
    return Tolerances(**numbers, max_steps=limit)


@dataclass
class AdaptiveStepper(Stepper):
    """A stepper that chooses its steps: its own time is the last row of what it hands out.

    Attributes
    ----------
    rows : int
        Rows of the state and one of the time.
    fixed : Stepper
        The method at fixed step: for single steps, and for lanes.
    reuses : bool
        Whether the last stage of a step serves as the first of the next.
    """

    fixed: Stepper = field(kw_only=True)
    allowed: Tolerances = field(kw_only=True)
    reuses: bool = field(kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._tried = self.h

    @property
    def state(self) -> Array:
        """The rounded state, without the time; a view."""
        return self.memory.data[: self.rows - 1]

    @property
    def carry(self) -> Array:
        """The carries of the compensated state; a view."""
        return self.memory.data[self.rows : 2 * self.rows - 1]

    @property
    def time(self) -> float:
        """The problem's own time that has been reached."""
        return float(self.memory.data[self.rows - 1])

    @property
    def finished(self) -> bool:
        """Whether the end has been reached."""
        return bool(self.time == self.coefficients.data[END])

    @property
    def left(self) -> float:
        """How far the end is, in the problem's own time."""
        return float(self.coefficients.data[END]) - self.time

    @property
    def extremes(self) -> tuple[float, float]:
        """Smallest and largest step so far, without those that the end cuts short; 0, 0 if none."""
        smallest, largest = (float(self._remembered(which)) for which in (SMALLEST, LARGEST))
        return (smallest, largest) if largest > 0.0 else (0.0, 0.0)

    def _remembered(self, which: int) -> float:
        return float(self.memory.data[2 * self.rows + which])

    def evaluations_in(self, steps: int, tries: int) -> int:
        """Return the evaluations in so many steps and tries; a retry keeps the first stage."""
        return round(tries * (self.evaluations - 1)) + (min(steps, 1) if self.reuses else steps)

    def lanes(self) -> LaneStepper:
        """Return the same step at fixed length for eight trajectories at once."""
        return self.fixed.lanes()

    def advance(self, first: int, count: int, every: int, out: Block) -> Advance:
        """Take up to `count` steps, write every `every`-th state with its time, and the end's."""
        left = self.allowed.max_steps - first
        result = super().advance(first, min(count, left), every, out)
        if result.status == OK and result.steps == left < count and not self.finished:
            result = result._replace(status=TOO_MANY_STEPS, residual=abs(self.left))
        if result.status != OK:
            self._tried = self._remembered(NEXT)
        return result

    def restarted(self, y: Array, t: float, h: float, carry: Array | None = None) -> Stepper:
        """Return a stepper of fixed step from another state, time and step."""
        self.fixed.prepare()
        return self.fixed.restarted(y, t, h, carry)

    def error(self, result: Advance, first: int, before: int = 0) -> StepError:
        """Return the typed error of an advance that failed; memory is that of the last good step."""
        residual = result.residual if result.residual == result.residual else float("inf")
        numbers = (self.time, before + first + result.steps, residual, result.iterations)
        h = self._tried
        if result.status == NOT_FINITE:
            return NonFiniteError(*numbers, f"even with h = {h:.3g}")
        if result.status == OUTSIDE_CHART:
            return StepSizeError(*numbers, f"even h = {h:.3g} leaves the group's coordinates", h=h)
        if result.status == TOO_MANY_STEPS:
            return StepLimitError(*numbers, f"max_steps = {self.allowed.max_steps}; h = {h:.3g}")
        hint = (
            f"rtol = {self.allowed.rtol:g} and atol = {self.allowed.atol:g} ask for a step of "
            f"{h:.3g}; the solution may end here, or the tolerances lie below rounding"
        )
        return StepSizeError(*numbers, hint, h=h)


def adaptive_stepper(
    s: Start,
    table: Tableau,
    allowed: Tolerances,
    fixed: Stepper,
    *,
    kernel: Recorded,
    y0: Array,
    derivative_rows: int,
    header: tuple[Any, ...],
    work_rows: int,
) -> AdaptiveStepper:
    """Return the adaptive stepper of a method whose fixed-step stepper is `fixed`.

    Parameters
    ----------
    kernel : Recorded
        Made by `geomint.kernels.adaptive.adaptive_stepper`; it takes the functions of `fixed`.
    y0 : array
        The initial state, with the clock's row where there is one.
    derivative_rows : int
        Length of a stage's derivative.
    header : tuple
        What the method's own coefficients are, before those of the tableau.
    """
    assert table.error_float is not None
    assert table.estimate_order is not None
    rows = len(y0) + 1
    memory = scalar_block(2 * rows + REMEMBERED + derivative_rows)
    memory.data[: rows - 1], memory.data[rows - 1] = y0, s.t0
    memory.data[2 * rows + NEXT] = math.copysign(min(abs(s.h), allowed.max_step), s.h)
    memory.data[2 * rows + SMALLEST] = math.inf
    coefficients = filled_block(
        *(allowed.rtol, allowed.atol, allowed.max_step),
        math.copysign(math.inf, s.h) if s.end is None else s.end,
        table.estimate_order,
        len(table.error_float) // table.stages,
        float(table.first_same_as_last),
        piece_numbers(s),  # the clock is a piece of its own
        *header,
        *(table.A_float, table.b_float, table.c_float, table.error_float),
    )
    return AdaptiveStepper(
        kernel=kernel,
        signatures=fixed.signatures,
        functions=fixed.functions,
        params=fixed.params,
        coefficients=coefficients,
        fractions=fixed.fractions,
        memory=memory,
        work=scalar_block(work_rows),
        rows=rows,
        t0=s.t0,
        h=s.h,
        evaluations=table.stages,
        compiled=s.compiled,
        fixed=fixed,
        allowed=allowed,
        reuses=table.first_same_as_last,
    )


def made_adaptive(
    method: Method,
    table: Tableau,
    allowed: Tolerances,
    start: Callable[[Start], Stepper],
    remake: Callable[..., Method],
) -> Method:
    """Return a method of fixed step as the adaptive one that `start` starts."""
    return replace(
        method,
        name=f"{method.name}-adaptive",
        start=start,
        first_step=functools.partial(allowed.first_step, table.order),
        options=asdict(allowed),
        remake=remake,
        summary=f"{method.summary}; adaptive, error estimate of order {table.estimate_order}",
    )
