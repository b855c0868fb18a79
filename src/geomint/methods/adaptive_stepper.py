"""Steppers that choose their steps themselves."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..arguments import Array, Integers
from ..errors import NonFiniteError, StepError, StepLimitError, StepSizeError
from ..kernels.compiling.recorded import Recorded
from ..kernels.numbers.blocks import REST, Block, packed, scalar_block, section, sections
from ..kernels.solve.adaptive import SPACINGS, adaptive_coefficients, adaptive_memory, adaptive_work
from ..kernels.solve.status import NOT_FINITE, OK, OUTSIDE_CHART, TOO_MANY_STEPS
from ..tableaux import Tableau
from .adaptive import Adaptive
from .bound_forms import piece_numbers
from .method import Start
from .stepper import NOTHING, Advance, Stepper

_GIVEN = adaptive_coefficients(0, REST)  # what is read here lies before all of other sizes


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
    allowed: Adaptive = field(kw_only=True)
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
    def fixed_step(self) -> Stepper:
        """The method at given steps."""
        return self.fixed

    @property
    def time(self) -> float:
        """The problem's own time that has been reached."""
        return float(self.memory.data[self.rows - 1])

    @property
    def next_step(self) -> float:
        """The step that is tried next."""
        return self._remembered("next")

    def time_after(self, steps: int) -> float:
        """Return the time that has been reached."""
        return self.time

    def begin(self, y: Array, t: float, h: float) -> None:
        """Begin anew, with a first step to try; how long steps have been is still known."""
        sizes = self._remembered("smallest"), self._remembered("largest")
        super().begin(np.append(y, t), t, h)
        remembered = sections(self.memory, adaptive_memory(self.rows, REST))
        least = 2.0 * SPACINGS * abs(t)  # less is no step at all
        remembered.next[0] = math.copysign(min(max(abs(h), least), self.allowed.max_step), h)
        remembered.smallest[0], remembered.largest[0] = sizes

    def aim(self, end: float) -> None:
        """End there; infinity: nowhere."""
        section(self.coefficients, _GIVEN, "end")[0] = end

    @property
    def finished(self) -> bool:
        """Whether the end has been reached."""
        return self.left == 0.0

    @property
    def left(self) -> float:
        """How far the end is, in the problem's own time."""
        return float(section(self.coefficients, _GIVEN, "end")[0]) - self.time

    def timed(self, steps: Integers, states: Array) -> tuple[Array, Array]:
        """Return the times, which are the last row, and the states."""
        return states[:, -1].copy(), states[:, :-1]

    @property
    def length(self) -> float:
        """0: the lengths differ."""
        return 0.0

    def lengths(self, steps: int, span: float) -> tuple[float, float, float]:
        """Return smallest, mean and largest; those that an end cut short count in the mean alone."""
        mean = abs(span) / steps if steps else abs(self.h)
        smallest, largest = self._remembered("smallest"), self._remembered("largest")
        return (smallest, mean, largest) if largest > 0.0 else (mean, mean, mean)

    def rejected_in(self, steps: int, iterations: int) -> int:
        """Return how many steps were tried and rejected."""
        return iterations - steps

    def _remembered(self, which: str) -> float:
        return float(section(self.memory, adaptive_memory(self.rows, REST), which)[0])

    def evaluations_in(self, steps: int, tries: int) -> int:
        """Return the evaluations in so many steps and tries; a retry keeps the first stage."""
        return round(tries * (self.evaluations - 1)) + (min(steps, 1) if self.reuses else steps)

    def advance(
        self,
        first: int,
        count: int,
        every: int,
        out: Block,
        whole: bool = False,
        ranks: Block = NOTHING,
    ) -> Advance:
        """Take up to `count` steps, write every `every`-th state with its time, and the end's."""
        left = self.allowed.max_steps - first
        result = super().advance(first, min(count, left), every, out)
        if result.status == OK and result.steps == left < count and not self.finished:
            result = result._replace(status=TOO_MANY_STEPS, residual=abs(self.left))
        if result.status != OK:
            self._tried = self._remembered("next")
        return result

    def restarted(self, y: Array, t: float, h: float, carry: Array | None = None) -> Stepper:
        """Return a stepper of fixed step from another state, time and step."""
        if not self.fixed.prepared:
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
    allowed: Adaptive,
    fixed: Stepper,
    *,
    kernel: Recorded,
    y0: Array,
    derivative_rows: int,
    layout: Callable[..., Any],
    sizes: dict[str, Any],
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
    layout : callable
        ``layout(stages, rows of the weights of errors)``: that of the method's own coefficients.
    sizes : dict
        What is in them beside the numbers of the tableau.
    work_rows : int
        Scratch of an attempt.
    """
    assert table.error_float is not None
    assert table.estimate_order is not None
    rows = len(y0) + 1
    remembered = adaptive_memory(rows, derivative_rows)
    memory = scalar_block(sum(remembered))
    section(memory, remembered, "smallest")[0] = math.inf
    numbers = packed(
        layout(table.stages, len(table.error_float)),
        **sizes,
        A=table.A_float,
        b=table.b_float,
        c=table.c_float,
        errors=table.error_float,
    )
    coefficients = packed(
        adaptive_coefficients(rows - 1, len(numbers)),
        rtol=allowed.rtol,
        atol=allowed.atol,
        max_step=allowed.max_step,
        end=math.copysign(math.inf, s.h) if s.end is None else s.end,
        order=table.estimate_order,
        estimates=len(table.error_float) // table.stages,
        reuse=float(table.first_same_as_last),
        pieces=piece_numbers(s),  # the clock is a piece of its own
        numbers=numbers.data,
    )
    stepper = AdaptiveStepper(
        kernel=kernel,
        functions=fixed.functions,
        params=fixed.params,
        coefficients=coefficients,
        fractions=fixed.fractions,
        memory=memory,
        work=scalar_block(sum(adaptive_work(rows - 1, derivative_rows, work_rows))),
        rows=rows,
        t0=s.t0,
        h=s.h,
        evaluations=table.stages,
        compiled=s.compiled,
        fixed=fixed,
        allowed=allowed,
        reuses=table.first_same_as_last,
    )
    stepper.begin(y0, s.t0, s.h)
    return stepper
