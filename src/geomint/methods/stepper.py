"""A method bound to a problem, an initial state and a step: what the driver advances."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..arguments import Array, Integers
from ..errors import (
    ConvergenceError,
    DeclarationError,
    NonFiniteError,
    RankError,
    StepError,
    StepSizeError,
)
from ..kernels.compiling.bound import Bound
from ..kernels.compiling.call import Call
from ..kernels.compiling.recorded import Recorded
from ..kernels.numbers.blocks import Block, part, scalar_block
from ..kernels.solve.advance import bound_stepper
from ..kernels.solve.status import LOST_RANK, NOT_CONVERGED, NOT_FINITE, OK, OUTSIDE_CHART

GAP = 4  # roundings before an end: one of i h, one of N h, two of sums with them
NOTHING = scalar_block(0)
SHORT = 2.0**-30  # of a step: one that fails too is not too long
NO_RATES = "the problem gives no number at the state before it, however short the step"
EARLIER = ": those before may have been too long"
NO_SLOPES = "the step can be taken, its derivative cannot: there is none here, or it is too large"
_TURNING = threading.RLock()


@dataclass(frozen=True, eq=False)
class Between:
    """How partial steps begin where what a method remembers of the whole step is of use.

    Attributes
    ----------
    write : Recorded
        ``write(coefficients, table, theta)`` changes coefficients for a step of θ h from the state
        where the step began whose memory is there.
    polynomial : Recorded
        ``polynomial(memory, table, rows, out)`` writes the coefficients of θ, θ², … of what the step
        adds to each row; at θ = 1 it is the step.
    table : Block
        What they need; shared, read-only.
    powers : int
        Of the polynomial.
    inside : Recorded
        ``inside(memory, before, places, rows, first, count, out)`` writes for rows from `first` on
        what the step has added at ⅛, ¼, … 1 of it, as well as it can and then less well, from what
        is remembered of it and of the step before.
    places : Block
        What that needs.
    """

    write: Recorded
    polynomial: Recorded
    table: Block
    powers: int
    inside: Recorded
    places: Block


class Kernel(NamedTuple):
    """Another kernel for the same memory: what takes steps where the first one gives up.

    Where the first one does not, its steps have the same bits.
    """

    recorded: Recorded
    functions: tuple[Bound, ...]
    coefficients: Block
    work: int


class Advance(NamedTuple):
    """What one call of a stepper did."""

    status: int
    steps: int
    iterations: int
    residual: float


def filled_block(*parts: Any) -> Block:
    """Return a block of all the numbers given, one after the other."""
    numbers = np.concatenate(
        [np.atleast_1d(np.asarray(p, dtype=np.float64)).ravel() for p in parts]
    )
    block = scalar_block(len(numbers))
    block.data[:] = numbers
    return block


@dataclass
class Stepper:
    """Everything that a kernel needs to take steps.

    Attributes
    ----------
    memory : Block
        All that the next step depends on: first the state, then the carries of its compensated
        sum, then what the method remembers. Saved and restored whole it continues bit for bit.
    rows : int
        Rows of the states that are handed out, the clock's row included where there is one.
    evaluations : float
        Evaluations of the problem's functions an iteration.
    between : Between, optional
    stages_in_lanes : bool
        Whether the kernel's own lanes are stages.
    lane_by_lane : bool
        Whether a step of eight states at once, in lanes, is that of each alone, to the bit.
    otherwise : callable, optional
        Makes what takes the steps from the first one on that does not converge.
    ranked : bool
        Whether each step has a number of its own that ranks it (`geomint.kernels.solve.ranks`).
    end : float or None
        Where the run ends, in the problem's own time: no function is asked beyond it.
    """

    kernel: Recorded
    functions: tuple[Bound, ...]
    params: Block
    coefficients: Block
    fractions: Block
    memory: Block
    work: Block
    rows: int
    t0: float
    h: float
    evaluations: float
    compiled: bool = True
    between: Between | None = None
    stages_in_lanes: bool = False
    lane_by_lane: bool = False
    otherwise: Callable[[], Kernel] | None = None
    ranked: bool = False
    end: float | None = None

    def __post_init__(self) -> None:
        self._advance: Call | None = None
        self.before: Any = None  # where its integrator was before the last steps
        self.turned = False  # whether `otherwise` takes the steps
        self._single: Stepper | None = None  # what takes single steps beside the run
        # What else has been prepared, and what `otherwise` has made: of all that share its code.
        self.beside: dict[Any, Call] = {}
        self._made: list[tuple[Kernel, Call]] = []

    def prepare(self, call: Call | None = None) -> None:
        """Compile, or find in the cache, what `advance` needs, as it is now; a run begins so.

        Or take the call of another stepper with the same kernel, functions and parameters.
        """
        self._single, self.beside, self._made = None, {}, []
        if call is None:
            bound = bound_stepper(self.kernel, self.functions)
            call = bound.call(self.compiled, functions=self.functions)
        self._advance = call.copy()
        self._advance.set(
            params=self.params,
            coefficients=self.coefficients,
            fractions=self.fractions,
            rows=self.rows,
        )

    @property
    def entries(self) -> int:
        """How many functions `prepare` asks for."""
        return 1 + len(self.functions)

    @property
    def fixed_step(self) -> Stepper:
        """What takes steps of given lengths."""
        return self

    @property
    def prepared(self) -> bool:
        """Whether code to run has been looked up."""
        return self._advance is not None

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
        if self._advance is not None and self._advance.owner is self:
            self._advance.set(t0=t, h=h)

    @property
    def finished(self) -> bool:
        """Whether the stepper has found the end of the run by itself."""
        return False

    def evaluations_in(self, steps: int, iterations: int) -> int:
        """Return the evaluations of the problem's functions in so many steps and iterations."""
        return round(iterations * self.evaluations)

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
        if self.otherwise is not None:
            before = self.memory.data.copy(), ranks.data.copy()
        kernel, result = self.kernel, self._advanced(first, count, every, out, whole, ranks)
        if before is None or result.status != NOT_CONVERGED or not self.turn(kernel):
            return result
        self.memory.data[:], ranks.data[:] = before
        return self._advanced(first, count, every, out, whole, ranks)

    def turn(self, failed: Recorded) -> bool:
        """Turn from a kernel to that for the steps which it cannot take; False if there is none.

        Steps that it can take have the same bits by both, so that it does not matter when, nor who asks
        for it: the run, or what takes steps beside it, in another thread perhaps. A field that takes no
        numbers with derivatives has no other kernel.
        """
        with _TURNING:
            if self.kernel is not failed or self.otherwise is None:
                return self.kernel is not failed
            make, self.otherwise = self.otherwise, None
            known = self.kernel, self.functions, self.coefficients, self.work, self._advance
            shared = self._made
            try:
                other = shared[0][0] if shared else make()
                self.kernel, self.functions = other.recorded, other.functions
                self.coefficients, self.work = other.coefficients, scalar_block(other.work)
                self.prepare(shared[0][1] if shared else None)
                assert self._advance is not None
                shared[:] = [(other, self._advance)]
            except DeclarationError:
                self.kernel, self.functions, self.coefficients, self.work, self._advance = known
            self.turned = self.kernel is not failed
            return self.turned

    def _advanced(
        self, first: int, count: int, every: int, out: Block, whole: bool, ranks: Block
    ) -> Advance:
        if self._advance is None:
            self.prepare()
        assert self._advance is not None
        rows, last, t0 = len(self.memory) if whole else self.rows, first + count - 1, self.t0
        if self.end is not None:
            t0 = self.last_begin(t0, self.h, first + count, self.end)
        if t0 != self.t0 and count > 1:
            done = self._advanced(first, count - 1, every, out, whole, ranks)
            if done.status != OK:
                return done
            saved = (last // every - first // every) * rows
            out = part(out, saved, len(out) - saved)
            final = self._advanced(last, 1, every, out, whole, ranks)
            both = done.steps + final.steps, done.iterations + final.iterations
            return Advance(final.status, *both, final.residual)
        if self._advance.owner is not self:  # steppers made by `restarted` share the call
            self._advance.set(memory=self.memory, work=self.work, t0=self.t0, h=self.h)
            self._advance.owner = self
        given = {"first": first, "count": count, "every": every, "out": out, "ranks": ranks}
        if not whole and t0 == self.t0:
            return Advance(*self._advance(**given))
        self._advance.set(rows=rows, t0=t0)
        try:
            return Advance(*self._advance(**given))
        finally:
            self._advance.set(rows=self.rows, t0=self.t0)

    def last_begin(self, t0: float, h: float, steps: int, end: float | None) -> float:
        """Return t0, or some roundings less, from which the last of so many steps is counted.

        Sums of times and lengths may round to more than the end, where functions of time may have no
        value. A state knows nothing of it, and no step of a Gauss method has a stage there.
        """
        if end is None or self.between is not None or abs(t0 + steps * h - end) >= 1e-9 * abs(h):
            return t0
        lengths, starts = self.fractions.data.reshape(2, -1)
        rounding = math.copysign(math.ulp(max(abs(t0), abs(end))), h)
        for roundings in range(GAP + 1):
            begin = t0 - roundings * rounding
            last = begin + (steps - 1) * h
            if (((last + starts * h) + lengths * h - end) * h <= 0.0).all():
                return begin
        return t0

    def restarted(self, y: Array, t: float, h: float, carry: Array | None = None) -> Stepper:
        """Return a stepper from another state, time and step, remembering at most the carries."""
        memory = scalar_block(len(self.memory))
        memory.data[: self.rows] = y
        if carry is not None:
            memory.data[self.rows : 2 * self.rows] = carry
        fresh = object.__new__(type(self))
        fresh.__dict__.update(self.__dict__)  # what `copy.copy` does in five times the time
        fresh.memory, fresh.work, fresh.t0, fresh.h = memory, scalar_block(len(self.work)), t, h
        fresh._single = None
        return fresh

    def renewed(self, y: Array, t: float, h: float) -> Stepper:
        """Return a stepper for another run, prepared as this one is, that shares nothing it changes."""
        return Stepper.restarted(self, y, t, h)._alone()

    def _alone(self) -> Stepper:
        """Let the arguments of its calls be its own."""
        if self._advance is not None:
            self._advance = self._advance.copy()
        return self

    @property
    def aside(self) -> Stepper:
        """What takes steps beside the run, from wherever it is begun; prepared as this one is."""
        if self._single is None:
            self._single = self.restarted(self.state, self.t0, self.h)._alone()
        return self._single

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
        error = self.renewed(y, t0, h).error(result, first, before)
        alone, steps = self.renewed(y, t0 + first * h, h), result.steps + 1
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
        short = self.renewed(self.state, t, SHORT * self.h)
        if kind is NonFiniteError and short.advance(0, 1, 2, NOTHING)[0] == NOT_FINITE:
            hint = NO_RATES + EARLIER * (before + step > 0)
        return kind(*numbers, hint)
