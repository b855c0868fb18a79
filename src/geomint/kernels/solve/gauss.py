"""Gauss collocation: all stages at once in lanes, and the round-off treatment that keeps invariants.

The stages are ``Y_i = y + Σ_j μ_ij L_j`` with ``L_j = (h b_j) f(t + c_j h, Y_j)`` and
``μ_ij = a_ij / b_j``, where ``μ_ij + μ_ji = 1`` holds exactly in floating point: quadratic
invariants survive the rounding of the coefficients. The update adds the same ``L_j`` into a
compensated sum whose carry enters the stages of the next step (Hairer, McLachlan, Razakarivony,
BIT 48 (2008) 231; Antoñana, Makazaga, Murua, Numer. Algorithms 76 (2017) 861).

Stages live in `groups` lane values a row, eight stages each; unused lanes have zero weights and
lie symmetrically at the two ends, so that the update adds stages pairwise from the ends.
"""

from __future__ import annotations

import functools
from typing import Any

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import fma, lane, maximum, top
from ..numbers.blocks import as_lanes, part
from .advance import stepper
from .compensated import add_compensated
from .fixed_point import (
    BEGINNING,
    COARSE,
    failure,
    finite,
    inverse_size,
    rounding_left,
    solved,
)
from .status import NOT_CONVERGED, OK

__all__ = ["gauss_header", "gauss_memory_size", "gauss_stepper", "gauss_work_size"]

HEADER = 3  # coefficients: rows, cap on iterations, tolerance; then the rows' pieces


@helper
def aligned(size: int) -> int:
    """Round up to whole lane values: a lane value across two cache lines loads twice as slowly."""
    return (size + 7) // 8 * 8


def gauss_header(rows: int, cap: int, tolerance: float, pieces: list[float]) -> list[float]:
    """Return the first numbers of the coefficient block; c, b, μ and the predictors follow."""
    numbers = [float(rows), float(cap), tolerance, *pieces]
    return numbers + [0.0] * (aligned(len(numbers)) - len(numbers))


def gauss_memory_size(rows: int, groups: int) -> int:
    """Numbers in memory: state, carry, and the stage increments of the last step."""
    return aligned(2 * rows) + 8 * groups * rows


def gauss_work_size(rows: int, groups: int, field_work: int) -> int:
    """Numbers of scratch: stages, their derivatives, the field's own scratch, row scales."""
    return 16 * groups * rows + 8 * field_work + rows


@inlined
def eight_columns(columns: Any, source: int, target: int, groups: int) -> Any:
    """Return the columns that take the stages of group `source` to those of group `target`."""
    at = 8 * source * groups + target
    return (
        columns[at],
        columns[at + groups],
        columns[at + 2 * groups],
        columns[at + 3 * groups],
        columns[at + 4 * groups],
        columns[at + 5 * groups],
        columns[at + 6 * groups],
        columns[at + 7 * groups],
    )


@inlined
def combine(m: Any, L: Any, start: Any) -> Any:
    """Return ``start + Σ_j m[j] L_j`` over the lanes of L.

    Four partial sums: latency, not the number of operations, is the cost (measured 1.15×).
    """
    s0 = fma(m[0], lane(L, 0), start)
    s1 = m[1] * lane(L, 1)
    s2 = m[2] * lane(L, 2)
    s3 = m[3] * lane(L, 3)
    s0 = fma(m[4], lane(L, 4), s0)
    s1 = fma(m[5], lane(L, 5), s1)
    s2 = fma(m[6], lane(L, 6), s2)
    s3 = fma(m[7], lane(L, 7), s3)
    return (s0 + s1) + (s2 + s3)


@inlined
def stage_sums(
    m: Any, columns: Any, stages: Any, y: Any, carry: Any, Y: Any, groups: int, rows: int
) -> None:
    """Write ``Y_i = y + (carry + Σ_j columns_ij L_j)`` for all stages.

    `m` are the columns of one group, held in registers by the caller (measured: 2 ns of 30).
    """
    zero = 0.0 * m[0]
    if groups == 1:
        for r in range(rows):
            Y[r] = y[r] + combine(m, stages[r], zero + carry[r])
    else:
        for target in range(groups):
            for source in range(groups):
                n = eight_columns(columns, source, target, groups)
                for r in range(rows):
                    start = zero + carry[r] if source == 0 else Y[target * rows + r]
                    total = combine(n, stages[source * rows + r], start)
                    Y[target * rows + r] = y[r] + total if source == groups - 1 else total


@inlined
def increment(stages: Any, row: int, groups: int, rows: int) -> float:
    """Return ``Σ_j L_j``, the stages added pairwise from the ends."""
    front = stages[row]
    back = stages[(groups - 1) * rows + row]
    p0 = lane(front, 0) + lane(back, 7)
    p1 = lane(front, 1) + lane(back, 6)
    p2 = lane(front, 2) + lane(back, 5)
    p3 = lane(front, 3) + lane(back, 4)
    if groups == 1:
        total = (p0 + p3) + (p1 + p2)
    else:
        p4 = lane(front, 4) + lane(back, 3)
        p5 = lane(front, 5) + lane(back, 2)
        p6 = lane(front, 6) + lane(back, 1)
        p7 = lane(front, 7) + lane(back, 0)
        total = ((p0 + p7) + (p3 + p4)) + ((p1 + p6) + (p2 + p5))
    return total


@helper
def inverse_scales(pieces: Any, y: Any, stages: Any, groups: int, scales: Any) -> None:
    """Write 1 / (size of the row's piece) for each row; 0 for rows of no piece, as the clock's is.

    The size is the largest of |y| and of the increments of the stages
    (`geomint.kernels.solve.fixed_point`).
    """
    rows = len(scales)
    r = 0
    while r < rows:
        end = r
        largest = 0.0
        moves = 0.0 * stages[r]
        while end < rows and top(pieces[end]) == top(pieces[r]):
            largest = max(largest, top(abs(y[end])))
            for g in range(groups):
                moves = maximum(abs(stages[g * rows + end]), moves)
            end += 1
        inverse = inverse_size(max(largest, top(moves))) if top(pieces[r]) >= 0.0 else 0.0
        for i in range(r, end):
            scales[i] = inverse
        r = end


@inlined
def gauss_step(
    functions: Any,
    params: Any,
    coefficients: Any,
    substep: int,
    memory: Any,
    work: Any,
    t: float,
    h: float,
    groups: int,
    rows: int,
) -> tuple[int, int, float]:
    """Solve for the stages by fixed-point iteration and add the update."""
    field = functions[0]
    cap = int(top(coefficients[1]))
    tolerance = top(coefficients[2])
    n_lanes = 8 * groups
    pieces = part(coefficients, HEADER, rows)
    at = aligned(HEADER + rows)
    c = as_lanes(coefficients, at, groups)
    b = as_lanes(coefficients, at + n_lanes, groups)
    mu = as_lanes(coefficients, at + 2 * n_lanes, n_lanes * groups)
    predictor = as_lanes(
        coefficients, at + n_lanes * (2 + n_lanes * (1 + substep)), n_lanes * groups
    )
    y = part(memory, 0, rows)
    carry = part(memory, rows, rows)
    stages = as_lanes(memory, aligned(2 * rows), rows * groups)
    Y = as_lanes(work, 0, rows * groups)
    F = as_lanes(work, 8 * rows * groups, rows * groups)
    scratch_rows = (len(work) - 16 * groups * rows - rows) // 8
    scratch = as_lanes(work, 16 * groups * rows, scratch_rows)
    scales = part(work, len(work) - rows, rows)

    for r in range(rows):
        scales[r] = 0.0
    m = eight_columns(
        predictor, 0, 0, groups
    )  # extrapolates the last step's collocation polynomial
    stage_sums(m, predictor, stages, scales, scales, Y, groups, rows)
    for i in range(rows * groups):
        stages[i] = Y[i]

    m = eight_columns(mu, 0, 0, groups)
    last = BEGINNING
    before = BEGINNING
    coarse = True
    for iteration in range(cap):
        stage_sums(m, mu, stages, y, carry, Y, groups, rows)
        for g in range(groups):
            field(params, t + c[g] * h, part(Y, g * rows, rows), part(F, g * rows, rows), scratch)
        if coarse:
            inverse_scales(pieces, y, stages, groups, scales)
        worst = 0.0 * c[0]
        for g in range(groups):
            weights = b[g] * h
            for r in range(rows):
                new = weights * F[g * rows + r]
                worst = maximum(abs(new - stages[g * rows + r]) * top(scales[r]), worst)
                stages[g * rows + r] = new
        delta = top(worst)
        if not finite(delta):
            return failure(iteration), iteration + 1, delta
        rounding = rounding_left(delta, c[0])
        if solved(delta, last, before, tolerance, rounding, iteration + 1 == cap):
            for r in range(rows):
                add_compensated(y, carry, r, increment(stages, r, groups, rows))
            return OK, iteration + 1, delta
        coarse = delta > COARSE
        before = last
        last = delta
    return NOT_CONVERGED, cap, last


@functools.cache
def gauss_stepper(groups: int, rows: int, field: Recorded | None = None) -> Recorded:
    """Return the stepper for 8 · `groups` stages and `rows` rows (0: any number of rows).

    Both are constants to the compiler, which unrolls, at the price of a compilation for each number
    of rows. With a `field` the stepper is compiled for that field alone and takes no function.
    Measured at 6 rows, nanoseconds an iteration: 30 with rows unknown, 28, 24 with the field.
    """

    @helper
    def gauss(functions, params, coefficients, substep, memory, work, t, h):
        n = rows if rows > 0 else int(top(coefficients[0]))
        return gauss_step(functions, params, coefficients, substep, memory, work, t, h, groups, n)

    if field is None:
        return stepper(gauss, 1)

    @helper
    def fused(functions, params, coefficients, substep, memory, work, t, h):
        return gauss((field,), params, coefficients, substep, memory, work, t, h)

    return stepper(fused, 0)
