"""Steppers that choose their steps themselves."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from ..arguments import Array
from ..errors import (
    NonFiniteError,
    StepError,
    StepLimitError,
    StepSizeError,
)
from ..kernels.compiling.recorded import Recorded
from ..kernels.numbers.blocks import Block, scalar_block
from ..kernels.solve.adaptive import END, LARGEST, NEXT, REMEMBERED, SMALLEST
from ..kernels.solve.status import NOT_FINITE, OK, OUTSIDE_CHART, TOO_MANY_STEPS
from ..tableaux import Tableau
from .bound_forms import piece_numbers
from .lane_stepper import LaneStepper
from .method import Method, Start
from .stepper import Advance, Stepper, filled_block
from .tolerances import Tolerances

__all__ = ["AdaptiveStepper", "controlled_stepper", "made_adaptive"]


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
        if self.fixed._advance is None:
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


def controlled_stepper(
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
        Made by `geomint.kernels.solve.adaptive.adaptive_stepper`; it takes the functions of `fixed`.
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
