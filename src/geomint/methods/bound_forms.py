"""The forms of a problem as steppers take them: bound functions, rows, initial memory, scratch."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..arguments import Array
from ..kernels.compiling.recorded import Recorded
from ..kernels.numbers.blocks import Block
from ..problems.forms import Group
from . import binding
from .method import Start
from .stepper import filled_block

__all__ = [
    "action_of",
    "field_of",
    "hamiltonian_of",
    "maps_of",
    "piece_numbers",
    "splitting_of",
    "substeps",
    "unrolled",
]

MAX_UNROLLED_ROWS = 8  # beyond, a compilation for each size costs more than it saves


def unrolled(rows: int, *others: int, limit: int = MAX_UNROLLED_ROWS) -> tuple[int, ...]:
    """Return numbers of rows as constants for kernels; zeros, "any", where states are large."""
    constants = (rows, *others)
    return constants if rows <= limit else (0,) * len(constants)


def substeps(s: Start) -> Block:
    """Return the substeps of a composition, in units of the step; by default the whole step."""
    return filled_block(s.lengths, s.starts)


def field_of(s: Start) -> tuple[Recorded, int, Array, int]:
    """Return (field, rows, initial state, rows of scratch), the clock's row included if wanted."""
    problem = s.problem
    assert problem.field is not None  # Method.check_fits has refused others
    n, m = problem.rows, len(problem.params)
    if not s.clock:
        return binding.bind_field(problem.field, m, n, n), n, s.y0, problem.work
    assert problem.clock is not None
    field = binding.with_clock(problem.field, problem.clock, m, n)
    return field, n + 1, np.append(s.y0, 0.0), problem.work


def piece_numbers(s: Start) -> list[float]:
    """Return for each row the number of its piece; −1 for the clock's row, which has no scale."""
    numbers = [float(i) for i, (_, rows) in enumerate(s.problem.pieces) for _ in range(rows)]
    return numbers + [-1.0] * s.clock


def action_of(s: Start) -> tuple[Recorded, Any]:
    """Return the bound generator and the group of the action form."""
    action = s.problem.action
    assert action is not None
    rows = action.group.algebra_rows
    generator = binding.bind_field(action.generator, len(s.problem.params), s.problem.rows, rows)
    return generator, action.group


class Maps(NamedTuple):
    """Functions of a group, where they are compiled in; else those that a kernel takes."""

    inline: tuple[Recorded | None, ...]
    functions: tuple[Recorded, ...]
    signatures: tuple[str, ...]


def maps_of(group: Group, *maps: Recorded) -> Maps:
    """Return how a kernel gets those functions of a group."""
    if group.inline:
        return Maps(maps, (), ())
    return Maps((None,) * len(maps), maps, ("action",) * len(maps))


def hamiltonian_of(s: Start) -> tuple[tuple[Recorded, Recorded, Recorded], int, int]:
    """Return (gradients, constraint, clock), the length of q and the number of constraints."""
    problem = s.problem
    form = problem.hamiltonian
    assert form is not None
    n, m = problem.rows // 2, len(problem.params)
    clock = problem.clock if s.clock and problem.clock is not None else binding.no_clock
    functions = (
        binding.bind_gradients(form.gradients, m, n),
        binding.bind_constraint(form.constraint, m, n, form.constraints),
        binding.bind_value(clock, m, 2 * n),
    )
    return functions, n, form.constraints


def splitting_of(s: Start) -> tuple[tuple[Recorded, Recorded], int]:
    """Return (flow, clock) and the number of parts."""
    problem = s.problem
    form = problem.splitting
    assert form is not None
    n, m = problem.rows, len(problem.params)
    clock = problem.clock if s.clock and problem.clock is not None else binding.no_clock
    functions = (binding.bind_flow(form.flow, m, n), binding.bind_value(clock, m, n))
    return functions, form.parts
