"""A problem as methods take it: functions bound to its sizes, rows with the clock's, substeps."""

from collections.abc import Iterable
from typing import Any, NamedTuple

from ..arguments import Array
from ..kernels.compiling.bound import Bound
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import (
    ACTION,
    CONSTRAINT,
    FIELD,
    FLOW,
    GRADIENTS,
    VALUE,
)
from ..kernels.numbers.blocks import filled_block
from ..problems.bound import bound
from ..problems.forms import Group
from ..problems.problem import Problem
from ..problems.quadrature import generator_beside, group_beside
from .binding import no_clock
from .flow import Flow

MAX_UNROLLED_ROWS = 8  # beyond, a compilation for each size costs more than it saves


class Posed(NamedTuple):
    """What a method is given: a problem, and how it is to be integrated.

    Attributes
    ----------
    state, time : array, float
        Any canonical state, without the clock's row: functions are tried there.
    clock : bool
        Whether physical time is integrated beside the state, as one more row.
    compiled : bool
        Whether kernels are compiled; plain Python otherwise, with the same bits.
    lengths, starts : tuple of float
        The substeps of a composition, in units of the step, and where they begin: the whole step
        unless `geomint.Compose` asks for more.
    """

    problem: Problem
    state: Array
    time: float = 0.0
    clock: bool = False
    compiled: bool = True
    lengths: tuple[float, ...] = (1.0,)
    starts: tuple[float, ...] = (0.0,)

    def flow(
        self, kind: type[Flow] = Flow, *, memory: Iterable[int], work: Iterable[int], **own: Any
    ) -> Flow:
        """Return the flow of a kernel; `memory` and `work` are layouts, `own` its other attributes."""
        return kind(
            problem=self.problem,
            clock=self.clock,
            compiled=self.compiled,
            fractions=filled_block(self.lengths, self.starts),
            memory=sum(memory),
            work=sum(work),
            **own,
        )

    @property
    def rows(self) -> int:
        """Rows of the state, the clock's included if it is integrated."""
        return self.problem.rows + self.clock

    @property
    def pieces(self) -> list[float]:
        """For each row the number of its piece; −1 for the clock's row, which has no scale."""
        numbers = [float(i) for i, (_, rows) in enumerate(self.problem.pieces) for _ in range(rows)]
        return numbers + [-1.0] * self.clock

    @property
    def field(self) -> Bound:
        """The bound field, with the clock's rate if it is integrated."""
        problem, field = self.problem, self.problem.field
        if self.clock:
            assert problem.clock is not None
            field = generator_beside(field, problem.clock, problem.rows, problem.rows)
        assert field is not None  # Method.check_fits has refused others
        return bound(problem, field, FIELD, y=self.rows, out=self.rows)

    @property
    def action(self) -> tuple[Bound, Group]:
        """The bound generator and the group, beside which the clock is moved if it is integrated."""
        problem, action = self.problem, self.problem.action
        assert action is not None
        group, generator, n = action.group, action.generator, problem.rows
        if self.clock:
            assert problem.clock is not None
            generator = generator_beside(generator, problem.clock, n, group.algebra_rows)
            group = group_beside(group, n)
        return bound(problem, generator, FIELD, y=self.rows, out=group.algebra_rows), group

    @property
    def hamiltonian(self) -> tuple[tuple[Bound, ...], int, int]:
        """(Gradients, constraint, clock), the length of q and the number of constraints."""
        problem = self.problem
        form = problem.hamiltonian
        assert form is not None
        functions = (
            bound(problem, form.gradients, GRADIENTS),
            bound(problem, form.constraint, CONSTRAINT),
            self._rate,
        )
        return functions, problem.rows // 2, form.constraints

    @property
    def splitting(self) -> tuple[tuple[Bound, ...], int]:
        """(Flow, clock) and the number of parts."""
        form = self.problem.splitting
        assert form is not None
        return (bound(self.problem, form.flow, FLOW), self._rate), form.parts

    @property
    def _rate(self) -> Bound:
        """The bound clock, or one that stands still."""
        clock = self.problem.clock if self.clock else None
        return bound(self.problem, clock or no_clock, VALUE)

    def group_sizes(self, group: Group, stages: int) -> dict[str, int | Array]:
        """Return what the coefficients of a method of groups hold beside its tableau."""
        return {
            "rows": self.rows,
            "algebra_rows": group.algebra_rows,
            "stages": stages,
            "layout_rows": len(group.layout),
            "field_work": self.problem.work,
            "layout": group.layout,
        }


def unrolled(rows: int, *others: int, limit: int = MAX_UNROLLED_ROWS) -> tuple[int, ...]:
    """Return numbers of rows as constants for kernels; zeros, "any", where states are large."""
    constants = (rows, *others)
    return constants if rows <= limit else (0,) * len(constants)


class Maps(NamedTuple):
    """Functions of a group, where they are compiled in; else those that a kernel takes."""

    inline: tuple[Recorded | None, ...]
    functions: tuple[Bound, ...]


def maps_of(group: Group, *maps: Recorded) -> Maps:
    """Return how a kernel gets those functions of a group."""
    if group.inline:
        return Maps(maps, ())
    return Maps((None,) * len(maps), tuple(Bound(f, ACTION) for f in maps))
