"""Commutator-free steps: products of exponentials of sums of stage generators."""

from __future__ import annotations

import functools
from typing import Any

from .advance import stepper
from .arithmetic import like, maximum, top
from .blocks import part
from .compensated import add_compensated
from .recorded import Recorded, helper
from .status import NOT_FINITE, OK

__all__ = ["commutator_free_stepper", "commutator_free_work_size"]

# coefficients: rows, algebra rows, stages, length of layout, rows of scratch of the generator;
# then layout, c, and for each stage and the update: start (stage whose value it starts from; −1: y),
# number of exponentials, and the coefficients of each.
HEADER = 5


def commutator_free_work_size(
    rows: int, algebra_rows: int, stages: int, field_work: int, group_work: int
) -> int:
    """Rows of scratch: generators, moves of the stages and update, exponent, value, increment."""
    own = stages * algebra_rows + (stages + 1) * rows + algebra_rows + 2 * rows
    return own + field_work + group_work


@helper
def combine_generators(
    table: Any, at: int, stages: int, xi: Any, algebra_rows: int, h: float, v: Any
) -> None:
    """Write ``v = h Σ_j table[at + j] ξ_j``."""
    for r in range(algebra_rows):
        total = 0.0 * v[r]
        for j in range(stages):
            if table[at + j] != 0.0:
                total += table[at + j] * xi[j * algebra_rows + r]
        v[r] = h * total


@helper
def commutator_free_step(
    functions: Any,
    params: Any,
    coefficients: Any,
    substep: int,
    memory: Any,
    work: Any,
    t: float,
    h: float,
) -> tuple[int, int, float]:
    """Build the stages and the update as moves: the differences of their values from the state.

    Summed before they are added to the state, moves lose nothing to its rounding.
    """
    generator = functions[0]
    act = functions[1]
    rows = int(coefficients[0])
    algebra_rows = int(coefficients[1])
    stages = int(coefficients[2])
    layout = part(coefficients, HEADER, int(coefficients[3]))
    field_work = int(coefficients[4])
    at = HEADER + len(layout)
    c = part(coefficients, at, stages)
    table = part(coefficients, at + stages, len(coefficients) - at - stages)
    y = part(memory, 0, rows)
    carry = part(memory, rows, rows)
    xi = part(work, 0, stages * algebra_rows)
    used = stages * algebra_rows
    moves = part(work, used, (stages + 1) * rows)
    used += (stages + 1) * rows
    v = part(work, used, algebra_rows)
    Y = part(work, used + algebra_rows, rows)
    step = part(work, used + algebra_rows + rows, rows)
    used += algebra_rows + 2 * rows
    field_scratch = part(work, used, field_work)
    used += field_work
    scratch = part(work, used, len(work) - used)
    for r in range(algebra_rows):
        v[r] = 0.0 * y[0]
    worst = 0.0 * y[0]
    at = 0
    for i in range(stages + 1):
        start = int(table[at])
        exponentials = int(table[at + 1])
        at += 2
        move = part(moves, i * rows, rows)
        for r in range(rows):
            move[r] = 0.0 * y[r] if start < 0 else moves[start * rows + r]
            Y[r] = y[r] + move[r]
        for _ in range(exponentials):
            combine_generators(table, at, stages, xi, algebra_rows, h, v)
            at += stages
            act(layout, v, Y, step, scratch)
            for r in range(rows):
                move[r] = move[r] + step[r]
                Y[r] = y[r] + move[r]
        if i < stages:
            generator_out = part(xi, i * algebra_rows, algebra_rows)
            generator(params, like(t + c[i] * h, y[0]), Y, generator_out, field_scratch)
            for r in range(algebra_rows):
                worst = maximum(abs(generator_out[r]), worst)
    largest = top(worst)
    if not largest < 1e300:
        return NOT_FINITE, 1, largest
    for r in range(rows):
        add_compensated(y, carry, r, moves[stages * rows + r])
    return OK, 1, 0.0


@functools.cache
def commutator_free_stepper() -> Recorded:
    """Return the stepper of commutator-free methods; it takes (generator, act)."""
    return stepper(commutator_free_step, 2)
