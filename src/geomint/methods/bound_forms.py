"""The forms of a problem as steppers take them: bound functions, rows, initial memory, scratch."""

from typing import NamedTuple

import numpy as np

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
from ..problems.bound import bound
from ..problems.forms import Group
from ..problems.quadrature import generator_beside, group_beside
from .binding import no_clock
from .method import Start

MAX_UNROLLED_ROWS = 8  # beyond, a compilation for each size costs more than it saves


def unrolled(rows: int, *others: int, limit: int = MAX_UNROLLED_ROWS) -> tuple[int, ...]:
    """Return numbers of rows as constants for kernels; zeros, "any", where states are large."""
    constants = (rows, *others)
    return constants if rows <= limit else (0,) * len(constants)


def field_of(s: Start) -> tuple[Bound, int, Array, int]:
    """Return (field, rows, initial state, rows of scratch), the clock's row included if wanted."""
    problem = s.problem
    assert problem.field is not None  # Method.check_fits has refused others
    n = problem.rows
    if not s.clock:
        return bound(problem, problem.field, FIELD), n, s.y0, problem.work
    assert problem.clock is not None
    both = generator_beside(problem.field, problem.clock, n, n)
    field = bound(problem, both, FIELD, y=n + 1, out=n + 1)
    return field, n + 1, np.append(s.y0, 0.0), problem.work


def piece_numbers(s: Start) -> list[float]:
    """Return for each row the number of its piece; −1 for the clock's row, which has no scale."""
    numbers = [float(i) for i, (_, rows) in enumerate(s.problem.pieces) for _ in range(rows)]
    return numbers + [-1.0] * s.clock


def action_of(s: Start) -> tuple[Bound, Group, Array]:
    """Return the bound generator and the group of the action form, and the initial state.

    The clock, if wanted, is moved beside the group.
    """
    problem, action = s.problem, s.problem.action
    assert action is not None
    n, m = problem.rows, action.group.algebra_rows
    if not s.clock:
        return bound(problem, action.generator, FIELD, out=m), action.group, s.y0
    assert problem.clock is not None
    generator = generator_beside(action.generator, problem.clock, n, m)
    known = bound(problem, generator, FIELD, y=n + 1, out=m + 1)
    return known, group_beside(action.group, n), np.append(s.y0, 0.0)


def group_sizes(s: Start, group: Group, rows: int, stages: int) -> dict[str, int | Array]:
    """Return what the coefficients of a method of groups hold beside its tableau."""
    return {
        "rows": rows,
        "algebra_rows": group.algebra_rows,
        "stages": stages,
        "layout_rows": len(group.layout),
        "field_work": s.problem.work,
        "layout": group.layout,
    }


class Maps(NamedTuple):
    """Functions of a group, where they are compiled in; else those that a kernel takes."""

    inline: tuple[Recorded | None, ...]
    functions: tuple[Bound, ...]


def maps_of(group: Group, *maps: Recorded) -> Maps:
    """Return how a kernel gets those functions of a group."""
    if group.inline:
        return Maps(maps, ())
    return Maps((None,) * len(maps), tuple(Bound(f, ACTION) for f in maps))


def hamiltonian_of(s: Start) -> tuple[tuple[Bound, ...], int, int]:
    """Return (gradients, constraint, clock), the length of q and the number of constraints."""
    problem = s.problem
    form = problem.hamiltonian
    assert form is not None
    functions = (
        bound(problem, form.gradients, GRADIENTS),
        bound(problem, form.constraint, CONSTRAINT),
        _clock_of(s),
    )
    return functions, problem.rows // 2, form.constraints


def _clock_of(s: Start) -> Bound:
    """Return the bound clock, or one that stands still."""
    clock = s.problem.clock if s.clock and s.problem.clock is not None else no_clock
    return bound(s.problem, clock, VALUE)


def splitting_of(s: Start) -> tuple[tuple[Bound, ...], int]:
    """Return (flow, clock) and the number of parts."""
    problem = s.problem
    form = problem.splitting
    assert form is not None
    return (bound(problem, form.flow, FLOW), _clock_of(s)), form.parts
