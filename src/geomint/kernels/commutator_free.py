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
    """Rows of scratch: stage generators, stage values, one exponent, one increment, the functions'."""
    return stages * (algebra_rows + rows) + algebra_rows + rows + field_work + group_work


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
    """Build the stages and let the update's exponentials act on the compensated state."""
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
    values = part(work, stages * algebra_rows, stages * rows)
    used = stages * (algebra_rows + rows)
    v = part(work, used, algebra_rows)
    step = part(work, used + algebra_rows, rows)
    field_scratch = part(work, used + algebra_rows + rows, field_work)
    used += algebra_rows + rows + field_work
    scratch = part(work, used, len(work) - used)
    for r in range(algebra_rows):
        v[r] = 0.0 * y[0]
    at = 0
    for i in range(stages):
        start = int(table[at])
        exponentials = int(table[at + 1])
        at += 2
        Y = part(values, i * rows, rows)
        for r in range(rows):
            Y[r] = y[r] if start < 0 else values[start * rows + r]
        for _ in range(exponentials):
            combine_generators(table, at, stages, xi, algebra_rows, h, v)
            at += stages
            act(layout, v, Y, step, scratch)
            for r in range(rows):
                Y[r] = Y[r] + step[r]
        generator(
            params,
            like(t + c[i] * h, y[0]),
            Y,
            part(xi, i * algebra_rows, algebra_rows),
            field_scratch,
        )
    worst = 0.0 * y[0]
    for r in range(stages * algebra_rows):
        worst = maximum(abs(xi[r]), worst)
    largest = top(worst)
    if not largest < 1e300:
        return NOT_FINITE, 1, largest
    exponentials = int(table[at + 1])
    at += 2
    for _ in range(exponentials):
        combine_generators(table, at, stages, xi, algebra_rows, h, v)
        at += stages
        act(layout, v, y, step, scratch)
        for r in range(rows):
            add_compensated(y, carry, r, step[r])
    return OK, 1, 0.0


@functools.cache
def commutator_free_stepper() -> Recorded:
    """Return the stepper of commutator-free methods; it takes (generator, act)."""
    return stepper(commutator_free_step, 2)
