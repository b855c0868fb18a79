"""All that follows from a problem and a method, whatever the state and the step: made once."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from ..errors import DeclarationError
from ..kernels.compiling.bound import Bound
from ..kernels.compiling.call import Call
from ..kernels.compiling.recorded import Recorded
from ..kernels.numbers.blocks import Block, filled_block
from ..kernels.solve.advance import bound_stepper
from ..problems.problem import Problem
from .stepper import Stepper

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

    kernel: Recorded
    functions: tuple[Bound, ...]
    coefficients: Block
    work: int


@dataclass(eq=False)
class Flow:
    """A kernel, and all of its arguments that depend on neither state nor step.

    `Method.on` makes it once for a problem and a method, and keeps it with the problem.

    Attributes
    ----------
    clock : bool
        Whether physical time is integrated beside the state, as one more row.
    memory, work : int
        Rows of what the next step depends on, first of the state, then of the carries of its
        compensated sum, and of scratch.
    evaluations : float
        Evaluations of the problem's functions an iteration.
    between : Between, optional
    stages_in_lanes : bool
        Whether the kernel's own lanes are stages.
    lane_by_lane : bool
        Whether a step of eight states at once, in lanes, is that of each alone, to the bit.
    ranked : bool
        Whether each step has a number of its own that ranks it (`geomint.kernels.solve.ranks`).
    newton : bool
        Whether its iterations are those of Newton's method, where others do not converge.
    make_other : callable, optional
        Makes what takes the steps from the first one on that does not converge, by Newton's method.
    seen : tuple of str
        What `check_problem` has returned.
    method : Method
    """

    problem: Problem
    clock: bool
    compiled: bool
    kernel: Recorded
    functions: tuple[Bound, ...]
    coefficients: Block
    fractions: Block
    memory: int
    work: int
    evaluations: float
    between: Between | None = None
    stages_in_lanes: bool = False
    lane_by_lane: bool = False
    ranked: bool = False
    newton: bool = False
    make_other: Callable[[], Kernel] | None = None
    seen: tuple[str, ...] = ()
    method: Any = None

    def __post_init__(self) -> None:
        self.params = filled_block(self.problem.params)
        self.rows = self.problem.rows + self.clock
        self.proven = False  # whether compiled code is known to give the numbers of plain Python
        self.calls: dict[Any, Any] = {}  # of code that runs beside the steps, or takes them
        reached = {f.reach: None for f in (self.kernel, *(b.recorded for b in self.functions))}
        self._reached = [reach for reach in reached if reach.can_change]

    @property
    def bound(self) -> Bound:
        """What takes steps, with its signature."""
        return bound_stepper(self.kernel, self.functions)

    def holds(self) -> bool:
        """Tell whether all that its functions reach is still as it was."""
        return all(reach.holds() for reach in self._reached)

    def prepare(self) -> Call:
        """Compile, or find in the cache, what takes steps."""
        found: Call | None = self.calls.get("advance")
        if found is None:
            found = self.bound.call(
                self.compiled,
                functions=self.functions,
                params=self.params,
                coefficients=self.coefficients,
                fractions=self.fractions,
                rows=self.rows,
            )
            self.calls["advance"] = found
        return found

    @property
    def entries(self) -> int:
        """How many functions `prepare` asks for."""
        return 1 + len(self.functions)

    @property
    def fixed(self) -> Flow:
        """That of steps of given lengths."""
        return self

    def begin(self, y: Any, t: float, h: float, end: float | None = None) -> Stepper:
        """Return what takes steps from a state and a time of the problem's own on."""
        return Stepper(self, y, t, h, end)

    @property
    def other(self) -> Flow | None:
        """What takes the steps which this one cannot take; None where there is nothing.

        Steps that both can take have the same bits, so that it does not matter who asks first: a run,
        or what takes steps beside it, in another thread perhaps. A field that takes no numbers with
        derivatives has no other kernel.
        """
        with _TURNING:
            if self.make_other is not None and "other" not in self.calls:
                self.calls["other"] = None
                with suppress(DeclarationError):
                    own = self.make_other()._asdict()
                    found = replace(self, **own, newton=True, make_other=None)
                    found.prepare()
                    self.calls["other"] = found
            return self.calls.get("other")
