"""Gauss collocation: all stages at once in lanes, and the round-off treatment that keeps invariants.

The stages are ``Y_i = y + Σ_j μ_ij L_j`` with ``L_j = (h b_j) f(t + c_j h, Y_j)`` and
``μ_ij = a_ij / b_j``, where ``μ_ij + μ_ji = 1`` holds exactly in floating point: quadratic
invariants survive the rounding of the coefficients. The update adds the same ``L_j`` into a
compensated sum whose carry enters the stages of the next step (Hairer, McLachlan, Razakarivony,
BIT 48 (2008) 231; Antoñana, Makazaga, Murua, Numer. Algorithms 76 (2017) 861).

Stages live in `groups` lane values a row, eight stages each; unused lanes have zero weights and
lie symmetrically at the two ends, so that the update adds stages pairwise from the ends.
"""

import functools
from collections import namedtuple

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import fma, lane, like, magnitude, maximum, top
from ..numbers.blocks import REST, as_lanes, part, section, sections
from .advance import stepper
from .compensated import add_compensated
from .fixed_point import (
    BEGINNING,
    COARSE,
    failure,
    finite,
    inverse_size,
    kept_up,
    no_contraction,
    rounding_left,
    solved,
)
from .status import NOT_CONVERGED, NOT_FINITE, OK, Step

Coefficients = namedtuple(
    "Coefficients", "rows cap patience tolerance pieces padding c b mu predictors"
)
Memory = namedtuple("Memory", "y carry padding stages")
Work = namedtuple("Work", "Y F scales padding scratch")


@inlined
def padding(size: int) -> int:
    """Return what makes whole lane values: one across two cache lines loads twice as slowly."""
    return (8 - size % 8) % 8


@inlined
def gauss_coefficients(rows: int, groups: int, substeps: int) -> Coefficients:
    """Return the layout of coefficients: the rows' pieces; in lanes c, b, μ, one predictor a substep.

    The matrices are in columns. Substeps: `REST`, any number.
    """
    lanes = 8 * groups
    return Coefficients(
        1, 1, 1, 1, rows, padding(4 + rows), lanes, lanes, lanes * lanes, substeps * lanes * lanes
    )


@inlined
def gauss_memory(rows: int, groups: int) -> Memory:
    """Return the layout of memory: state, carry, and in lanes the stage increments of the last step."""
    return Memory(rows, rows, padding(2 * rows), 8 * groups * rows)


@inlined
def gauss_work(rows: int, groups: int, scratch: int) -> Work:
    """Return the layout of scratch: in lanes stages, their derivatives, the field's own."""
    size = 8 * groups * rows
    return Work(size, size, rows, padding(rows), scratch)


@inlined
def eight_columns(columns, source: int, target: int, groups: int):
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
def combine(m, L, start):
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
def stage_sums(m, columns, stages, y, carry, Y, groups: int, rows: int):
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
def folded(front, back):
    """Return the sums of the first four lanes of `front` and the last four of `back`, from the ends."""
    return (
        lane(front, 0) + lane(back, 7),
        lane(front, 1) + lane(back, 6),
        lane(front, 2) + lane(back, 5),
        lane(front, 3) + lane(back, 4),
    )


@inlined
def increment(stages, row: int, groups: int, rows: int):
    """Return ``Σ_j L_j``, the stages added pairwise from the ends."""
    front = stages[row]
    back = stages[(groups - 1) * rows + row]
    p0, p1, p2, p3 = folded(front, back)
    if groups == 1:
        total = (p0 + p3) + (p1 + p2)
    else:
        p7, p6, p5, p4 = folded(back, front)
        total = ((p0 + p7) + (p3 + p4)) + ((p1 + p6) + (p2 + p5))
    return total


@functools.cache
def scales_by(size: Recorded) -> Recorded:
    """Return ``inverse_scales(pieces, y, stages, groups, scales)``, by the sizes of numbers."""

    @helper
    def inverse_scales(pieces, y, stages, groups, scales):
        """Write 1 / (size of the row's piece) for each row; 0 for rows of no piece, as the clock's is.

        The size is the largest of those of y and of the increments of the stages
        (`geomint.kernels.solve.fixed_point`).
        """
        rows = len(scales)
        r = 0
        while r < rows:
            end = r
            largest = 0.0
            moves = 0.0 * size(stages[r])
            while end < rows and top(pieces[end]) == top(pieces[r]):
                largest = max(largest, top(size(y[end])))
                for g in range(groups):
                    moves = maximum(size(stages[g * rows + end]), moves)
                end += 1
            inverse = inverse_size(max(largest, top(moves))) if top(pieces[r]) >= 0.0 else 0.0
            for i in range(r, end):
                scales[i] = inverse
            r = end

    return inverse_scales


inverse_scales = scales_by(magnitude)


@inlined
def gauss_step(
    functions, params, coefficients, substep: int, memory, work, t, h, groups: int,
    rows: int,
) -> Step:  # fmt: skip
    """Solve for the stages by fixed-point iteration and add the update.

    Where what is extrapolated from the last step is no state of the field's, the iteration begins anew
    from the state itself.
    """
    field = functions[0]
    given = sections(coefficients, gauss_coefficients(rows, groups, REST))
    cap, tolerance = int(top(given.cap[0])), top(given.tolerance[0])
    patience = int(top(given.patience[0]))
    c, b = as_lanes(given.c, 0, groups), as_lanes(given.b, 0, groups)
    columns = 8 * groups * groups
    mu = as_lanes(given.mu, 0, columns)
    predictor = as_lanes(given.predictors, 8 * columns * substep, columns)
    y, carry, _, increments = sections(memory, gauss_memory(rows, groups))
    stages = as_lanes(increments, 0, rows * groups)
    own = sections(work, gauss_work(rows, groups, REST))
    Y, F = as_lanes(own.Y, 0, rows * groups), as_lanes(own.F, 0, rows * groups)
    scales, scratch = own.scales, as_lanes(own.scratch, 0, len(own.scratch) // 8)

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
    first = BEGINNING
    before = BEGINNING
    halfway = BEGINNING
    coarse = True
    anew = False
    for iteration in range(cap):
        stage_sums(m, mu, stages, y, carry, Y, groups, rows)
        for g in range(groups):
            field(params, t + c[g] * h, part(Y, g * rows, rows), part(F, g * rows, rows), scratch)
        if coarse:
            if no_contraction(iteration, patience, last):
                return NOT_CONVERGED, iteration + 1, last
            inverse_scales(given.pieces, y, stages, groups, scales)
        worst = 0.0 * c[0]
        for g in range(groups):
            weights = b[g] * h
            for r in range(rows):
                new = weights * F[g * rows + r]
                worst = maximum(magnitude(new - stages[g * rows + r]) * top(scales[r]), worst)
                stages[g * rows + r] = new
        delta = top(worst)
        if iteration == 0:
            first = delta
        if not finite(delta):
            if iteration > 0:
                return NOT_FINITE if anew else failure(iteration), iteration + 1, delta
            anew = True
            for i in range(rows * groups):
                stages[i] = like(0.0, stages[i])
            continue
        final = iteration + 1 == cap
        if 2 * iteration == cap:
            halfway = delta
        rounding = rounding_left(delta, c[0]) | (final & kept_up(delta, halfway))
        if solved(delta, last, before, tolerance, rounding, final):
            for r in range(rows):
                add_compensated(y, carry, r, increment(stages, r, groups, rows))
            return OK, iteration + 1, first
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
        header = gauss_coefficients(0, groups, REST)
        n = rows if rows > 0 else int(top(section(coefficients, header, "rows")[0]))
        return gauss_step(functions, params, coefficients, substep, memory, work, t, h, groups, n)

    if field is None:
        return stepper(gauss, ranked=True)

    @helper
    def fused(functions, params, coefficients, substep, memory, work, t, h):
        return gauss((field,), params, coefficients, substep, memory, work, t, h)

    return stepper(fused, ranked=True)
