"""A method bound to a problem, an initial state and a step: what the driver advances."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from ..arguments import Array, Integers
from ..errors import ConvergenceError, NonFiniteError, RankError, StepError, StepSizeError
from ..kernels.compiling.call import Call
from ..kernels.numbers.blocks import Block, part, scalar_block
from ..kernels.solve.status import LOST_RANK, NOT_CONVERGED, NOT_FINITE, OK, OUTSIDE_CHART
from .agreement import check_agreement

if TYPE_CHECKING:
    from .flow import Flow

GAP = 4  # roundings before an end: one of i h, one of N h, two of sums with them
NOTHING = scalar_block(0)
SHORT = 2.0**-30  # of a step: one that fails too is not too long
NO_RATES = "the problem gives no number at the state before it, however short the step"
EARLIER = ": those before may have been too long"
NO_SLOPES = "the step can be taken, its derivative cannot: there is none here, or it is too large"


class Advance(NamedTuple):
    """What one call of a stepper did."""

    status: int
    steps: int
    iterations: int
    residual: float


class Stepper:
    """A flow at a state: what is the run's own, and what takes its steps.

    Attributes
    ----------
    flow : Flow
    memory : Block
        All that the next step depends on: first the state, then the carries of its compensated
        sum, then what the method remembers. Saved and restored whole it continues bit for bit.
    work : Block
        Scratch.
    t0, h : float
        The problem's own time at which steps began, and their length, with its sign.
    end : float or None
        Where the run ends, in the problem's own time: no function is asked beyond it.
    turning : bool
        Whether steps that do not converge are taken by the flow's other kernel, if it has one.
    before : object
        Where its integrator was before the last steps.
    """

    def __init__(self, flow: Flow, y: Any, t: float, h: float, end: float | None = None) -> None:
        self.memory = scalar_block(flow.memory)
        self.memory.data[: len(y)] = y
        self.t0, self.h, self.end, self.turning = t, h, end, True
        self.before: Any = None
        self._take(flow)

    def _take(self, flow: Flow) -> None:
        """Let steps be those of a flow whose memory is the same."""
        self.flow, self.work = flow, scalar_block(flow.work)
        self._call: Call | None = None
        self._aside: Stepper | None = None  # what takes single steps beside the run

    def prepare(self) -> None:
        """Compile, or find in the cache, what steps need; see once that it is right."""
        self._prepared()
        if not self.flow.proven:
            check_agreement(self)

    def _prepared(self) -> Call:
        """Return the call that takes steps, whose arguments are this stepper's own."""
        if self._call is None:
            self._call = self.flow.prepare().copy()
            self._call.set(**self._own, t0=self.t0, h=self.h)
        return self._call

    @property
    def _own(self) -> dict[str, Block]:
        """The blocks that steps change, by name."""
        return {"memory": self.memory, "work": self.work}

    @property
    def rows(self) -> int:
        """Rows of the states that are handed out, the clock's row included where there is one."""
        return self.flow.rows

    @property
    def compiled(self) -> bool:
        """Whether steps are those of compiled code."""
        return self.flow.compiled

    @property
    def fixed_step(self) -> Stepper:
        """What takes steps of given lengths."""
        return self

    @property
    def next_step(self) -> float:
        """The step that is taken or, by an adaptive method, tried next."""
        return self.h

    def timed(self, steps: Integers, states: Array) -> tuple[Array, Array]:
        """Return the problem's own times of states after so many steps, and the states without them."""
        times: Array = self.t0 + self.h * steps  # type: ignore[assignment]
        return times, states

    @property
    def length(self) -> float:
        """The length of every step; 0 where they differ."""
        return self.h

    def lengths(self, steps: int, span: float) -> tuple[float, float, float]:
        """Return the smallest, the mean and the largest length of so many steps over a span."""
        return (abs(self.h),) * 3

    def aim(self, end: float) -> None:
        """Let a run end there: one that chooses its steps does, others end where they are told."""
        self.end = end

    def time_after(self, steps: int) -> float:
        """Return the problem's own time after so many steps; an adaptive stepper remembers it."""
        return self.t0 + steps * self.h

    def begin(self, y: Array, t: float, h: float) -> None:
        """Begin anew, and remember nothing; the clock stands at 0."""
        self.memory.data[:] = 0.0
        self.memory.data[: len(y)] = y
        self.move(t, h)

    def move(self, t: float, h: float) -> None:
        """Take the state as it is for that of another time, and a step of another length."""
        self.t0, self.h = t, h
        if self._call is not None:
            self._call.set(t0=t, h=h)

    @property
    def finished(self) -> bool:
        """Whether the stepper has found the end of the run by itself."""
        return False

    def evaluations_in(self, steps: int, iterations: int) -> int:
        """Return the evaluations of the problem's functions in so many steps and iterations."""
        return round(iterations * self.flow.evaluations)

    def rejected_in(self, steps: int, iterations: int) -> int:
        """Return how many steps were tried and rejected."""
        return 0

    @property
    def state(self) -> Array:
        """The rounded state; a view."""
        return self.memory.data[: self.rows]

    def advance(
        self,
        first: int,
        count: int,
        every: int,
        out: Block,
        whole: bool = False,
        ranks: Block = NOTHING,
    ) -> Advance:
        """Take `count` steps after `first`, write every `every`-th state, or the `whole` memory."""
        before = None
        if self.turning and self.flow.make_other is not None:
            before = self.memory.data.copy(), ranks.data.copy()
        flow, result = self.flow, self._advanced(first, count, every, out, whole, ranks)
        if before is None or result.status != NOT_CONVERGED or not self.turn(flow):
            return result
        self.memory.data[:], ranks.data[:] = before
        return self._advanced(first, count, every, out, whole, ranks)

    def turn(self, failed: Flow) -> bool:
        """Turn from a flow to that for the steps which it cannot take; False if there is none."""
        if self.flow is failed and self.turning and (other := failed.other) is not None:
            self._take(other)
        return self.flow is not failed

    def _advanced(
        self, first: int, count: int, every: int, out: Block, whole: bool, ranks: Block
    ) -> Advance:
        call, t0 = self._call or self._prepared(), self.t0
        if self.end is not None:
            t0 = self.last_begin(t0, self.h, first + count, self.end)
        if t0 != self.t0 and count > 1:
            done = self._advanced(first, count - 1, every, out, whole, ranks)
            if done.status != OK:
                return done
            last = first + count - 1
            saved = (last // every - first // every) * (len(self.memory) if whole else self.rows)
            out = part(out, saved, len(out) - saved)
            final = self._advanced(last, 1, every, out, whole, ranks)
            both = done.steps + final.steps, done.iterations + final.iterations
            return Advance(final.status, *both, final.residual)
        given = {"first": first, "count": count, "every": every, "out": out, "ranks": ranks}
        if not whole and t0 == self.t0:
            return Advance(*call(**given))
        call.set(rows=len(self.memory) if whole else self.rows, t0=t0)
        try:
            return Advance(*call(**given))
        finally:
            call.set(rows=self.rows, t0=self.t0)

    def last_begin(self, t0: float, h: float, steps: int, end: float | None) -> float:
        """Return t0, or some roundings less, from which the last of so many steps is counted.

        Sums of times and lengths may round to more than the end, where functions of time may have no
        value. A state knows nothing of it, and no step of a Gauss method has a stage there.
        """
        if (
            end is None
            or self.flow.between is not None
            or abs(t0 + steps * h - end) >= 1e-9 * abs(h)
        ):
            return t0
        lengths, starts = self.flow.fractions.data.reshape(2, -1)
        rounding = math.copysign(math.ulp(max(abs(t0), abs(end))), h)
        for roundings in range(GAP + 1):
            begin = t0 - roundings * rounding
            last = begin + (steps - 1) * h
            if (((last + starts * h) + lengths * h - end) * h <= 0.0).all():
                return begin
        return t0

    def like(self, y: Array, t: float, h: float) -> Stepper:
        """Return what takes such steps, of a given length, from elsewhere."""
        made = self.flow.fixed.begin(y, t, h)
        made.turning = self.turning
        return made

    @property
    def aside(self) -> Stepper:
        """What takes steps beside the run, from wherever it is begun."""
        if self._aside is None:
            self._aside = self.like(self.state, self.t0, self.h)
        return self._aside

    @property
    def carry(self) -> Array:
        """The carries of the compensated state; a view."""
        return self.memory.data[self.rows : 2 * self.rows]

    def single_step(
        self, y: Array, t: float, h: float, carry: Array | None = None, before: int = 0
    ) -> Array:
        """Return the state after one step of length `h` from (t, y), or raise a `StepError`.

        `before` is the number of steps of the run before it.
        """
        single = self.aside
        single.begin(y, t, h)
        if carry is not None:
            single.carry[:] = carry
        return single._next_state(before)

    def _next_state(self, before: int) -> Array:
        result = self.advance(0, 1, 2, NOTHING)
        if result.status != OK:
            raise self.error(result, 0, before)
        return self.state.copy()

    def step_ahead(self, t: float, h: float, before: int) -> Array:
        """Return the state a step ahead of where the run is, as `single_step` does; it stays there."""
        memory, own = self.memory.data.copy(), (self.t0, self.h)
        self.begin(memory[: self.rows], t, h)
        self.carry[:] = memory[self.rows : 2 * self.rows]
        try:
            return self._next_state(before)
        finally:
            self.memory.data[:] = memory
            self.move(*own)

    def error_of_slopes(
        self, result: Advance, y: Array, t0: float, h: float, first: int, before: int
    ) -> StepError:
        """Return the error of steps with derivatives, from y after step `first`; see `error`."""
        error = self.like(y, t0, h).error(result, first, before)
        alone, steps = self.like(y, t0 + first * h, h), result.steps + 1
        taken = alone.advance(0, steps, steps + 1, NOTHING)[0] == OK
        if taken and isinstance(error, NonFiniteError):
            error = NonFiniteError(error.t, error.step, error.residual, error.iterations, NO_SLOPES)
        return error

    def error(self, result: Advance, first: int, before: int = 0) -> StepError:
        """Return the typed error of an advance that failed after step `first`."""
        step = first + result.steps
        t = self.t0 + step * self.h
        residual = result.residual if result.residual == result.residual else float("inf")
        numbers = (t, before + step, residual, result.iterations)
        if result.status == OUTSIDE_CHART:
            hint = f"h = {self.h:.6g} turns so far that the group's coordinates end"
            return StepSizeError(*numbers, hint, h=self.h)
        if result.status == LOST_RANK:
            hint = f"h = {self.h:.6g} does not tell which of the motions goes on: give another step"
            return RankError(*numbers, hint)
        kind = ConvergenceError if result.status == NOT_CONVERGED else NonFiniteError
        hint = f"h = {self.h:.6g} is probably too large for this method and state"
        short = self.like(self.state, t, SHORT * self.h)
        if kind is NonFiniteError and short.advance(0, 1, 2, NOTHING)[0] == NOT_FINITE:
            hint = NO_RATES + EARLIER * (before + step > 0)
        return kind(*numbers, hint)
