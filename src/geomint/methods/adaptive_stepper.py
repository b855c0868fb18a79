"""Steppers that choose their steps themselves."""

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..arguments import Array, Integers
from ..errors import NonFiniteError, StepError, StepLimitError, StepSizeError
from ..kernels.compiling.recorded import Recorded
from ..kernels.numbers.blocks import (
    REST,
    Block,
    filled_block,
    packed,
    section,
    sections,
)
from ..kernels.solve.adaptive import SPACINGS, adaptive_coefficients, adaptive_memory, adaptive_work
from ..kernels.solve.status import NOT_FINITE, OK, OUTSIDE_CHART, TOO_MANY_STEPS
from ..tableaux import Tableau
from .adaptive import Adaptive
from .flow import Flow
from .posed import Posed
from .stepper import NOTHING, Advance, Stepper

_GIVEN = adaptive_coefficients(0, REST)  # what is read here lies before all of other sizes


@dataclass(eq=False)
class AdaptiveFlow(Flow):
    """A flow that chooses its steps: its own time is the last row of what it hands out.

    Attributes
    ----------
    given : Flow
        The method at steps of given lengths: for single steps, and for lanes.
    allowed : Adaptive
    reuses : bool
        Whether the last stage of a step serves as the first of the next.
    """

    given: Flow = field(kw_only=True)
    allowed: Adaptive = field(kw_only=True)
    reuses: bool = field(kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self.rows += 1  # the time's

    @property
    def fixed(self) -> Flow:
        """That of steps of given lengths."""
        return self.given

    def begin(self, y: Any, t: float, h: float, end: float | None = None) -> Stepper:
        """Return what takes steps from a state and a time of the problem's own on."""
        return AdaptiveStepper(self, y, t, h, end)


class AdaptiveStepper(Stepper):
    """A stepper that chooses its steps."""

    flow: AdaptiveFlow

    def __init__(
        self, flow: AdaptiveFlow, y: Any, t: float, h: float, end: float | None = None
    ) -> None:
        self.coefficients = filled_block(flow.coefficients.data)
        super().__init__(flow, y, t, h)
        self._tried = h
        section(self.memory, adaptive_memory(self.rows, REST), "smallest")[0] = math.inf
        self.begin(self.state.copy(), t, h)
        self.aim(math.copysign(math.inf, h) if end is None else end)

    @property
    def _own(self) -> dict[str, Block]:
        return {**super()._own, "coefficients": self.coefficients}

    @property
    def state(self) -> Array:
        """The rounded state, without the time; a view."""
        return self.memory.data[: self.rows - 1]

    @property
    def carry(self) -> Array:
        """The carries of the compensated state; a view."""
        return self.memory.data[self.rows : 2 * self.rows - 1]

    @functools.cached_property
    def fixed_step(self) -> Stepper:
        """The method at given steps."""
        return self.flow.given.begin(self.state, self.t0, self.h)

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
        remembered.next[0] = math.copysign(min(max(abs(h), least), self.flow.allowed.max_step), h)
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
        return round(tries * (self.flow.evaluations - 1)) + (
            min(steps, 1) if self.flow.reuses else steps
        )

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
        left = self.flow.allowed.max_steps - first
        result = super().advance(first, min(count, left), every, out)
        if result.status == OK and result.steps == left < count and not self.finished:
            result = result._replace(status=TOO_MANY_STEPS, residual=abs(self.left))
        if result.status != OK:
            self._tried = self._remembered("next")
        return result

    def error(self, result: Advance, first: int, before: int = 0) -> StepError:
        """Return the typed error of an advance that failed; memory is that of the last good step."""
        residual = result.residual if result.residual == result.residual else float("inf")
        numbers = (self.time, before + first + result.steps, residual, result.iterations)
        h, allowed = self._tried, self.flow.allowed
        if result.status == NOT_FINITE:
            return NonFiniteError(*numbers, f"even with h = {h:.3g}")
        if result.status == OUTSIDE_CHART:
            return StepSizeError(*numbers, f"even h = {h:.3g} leaves the group's coordinates", h=h)
        if result.status == TOO_MANY_STEPS:
            return StepLimitError(*numbers, f"max_steps = {allowed.max_steps}; h = {h:.3g}")
        hint = (
            f"rtol = {allowed.rtol:g} and atol = {allowed.atol:g} ask for a step of "
            f"{h:.3g}; the solution may end here, or the tolerances lie below rounding"
        )
        return StepSizeError(*numbers, hint, h=h)


def controlled(
    p: Posed,
    table: Tableau,
    allowed: Adaptive,
    given: Flow,
    *,
    kernel: Recorded,
    derivative_rows: int,
    layout: Callable[..., Any],
    sizes: dict[str, Any],
    work_rows: int,
) -> Flow:
    """Return the flow that chooses its steps, of a method whose flow of given steps is `given`.

    Parameters
    ----------
    kernel : Recorded
        Made by `geomint.kernels.solve.adaptive.adaptive_stepper`; it takes the functions of `given`.
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
    numbers = packed(
        layout(table.stages, len(table.error_float)),
        **sizes,
        A=table.A_float,
        b=table.b_float,
        c=table.c_float,
        errors=table.error_float,
    )
    coefficients = packed(
        adaptive_coefficients(p.rows, len(numbers)),
        rtol=allowed.rtol,
        atol=allowed.atol,
        max_step=allowed.max_step,
        end=math.inf,
        order=table.estimate_order,
        estimates=len(table.error_float) // table.stages,
        reuse=float(table.first_same_as_last),
        pieces=p.pieces,  # the clock is a piece of its own
        numbers=numbers.data,
    )
    return p.flow(
        AdaptiveFlow,
        kernel=kernel,
        functions=given.functions,
        coefficients=coefficients,
        memory=adaptive_memory(p.rows + 1, derivative_rows),
        work=adaptive_work(p.rows, derivative_rows, work_rows),
        evaluations=table.stages,
        given=given,
        allowed=allowed,
        reuses=table.first_same_as_last,
    )
