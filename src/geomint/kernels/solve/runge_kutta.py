"""Explicit Runge–Kutta steps of any tableau, for any kind of number."""

import functools
from collections import namedtuple

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import like, maximum, top
from ..numbers.blocks import REST, part, section, sections
from .adaptive import adaptive_stepper, adaptive_work
from .advance import stepper
from .compensated import add_compensated, compensated_state
from .status import NOT_FINITE, OK, Step

Coefficients = namedtuple("Coefficients", "rows stages A b c errors")
Work = namedtuple("Work", "k Y scratch")

HUGE = 1e300  # what is not less counts as not finite


@inlined
def runge_kutta_coefficients(s: int, errors: int) -> Coefficients:
    """Return the layout of coefficients: A is full. Where `stages` lies depends on nothing."""
    return Coefficients(1, 1, s * s, s, s, errors)


@inlined
def table_of(coefficients):
    """Return the parts of coefficients by name."""
    stages = int(section(coefficients, runge_kutta_coefficients(0, REST), "stages")[0])
    return sections(coefficients, runge_kutta_coefficients(stages, REST))


@inlined
def runge_kutta_work(rows: int, stages: int, field_work: int) -> Work:
    """Return the layout of scratch: stage derivatives, one stage, the field's own."""
    return Work(stages * rows, rows, field_work)


@inlined
def combine(weights, k, h, zero, out, rows: int):
    """Write ``h Σ_j weights[j] k_j``; `k` holds the vectors of `rows` one after the other.

    `zero` is the number 0 of the right kind.
    """
    for r in range(rows):
        total = zero
        for j in range(len(weights)):
            if weights[j] != 0.0:
                total += weights[j] * k[j * rows + r]
        out[r] = h * total


@inlined
def largest(block, rows: int):
    """Return the largest absolute value in any row and lane; NaN if there is one."""
    worst = abs(block[0])
    for r in range(1, rows):
        worst = maximum(abs(block[r]), worst)
    return top(worst)


@inlined
def runge_kutta_stages(field, params, table, y, carry, own: Work, t, h, known: int, rows: int):
    """Write ``k_i = f(t + c_i h, y + h Σ_j a_ij k_j)``; the first `known` of them are there already.

    y and its carry are an unevaluated sum; `table` and `own` are the parts of coefficients and scratch.
    """
    zero = 0.0 * y[0]
    stages, Y = len(table.c), own.Y
    for i in range(known, stages):
        combine(part(table.A, i * stages, i), own.k, h, zero, Y, rows)
        for r in range(rows):
            Y[r] = y[r] + (carry[r] + Y[r])
        k = part(own.k, i * rows, rows)
        field(params, like(t + table.c[i] * h, y[0]), Y, k, own.scratch)


@functools.cache
def runge_kutta_stepper(rows: int) -> Recorded:
    """Return the stepper of explicit Runge–Kutta methods for states of `rows` numbers (0: any).

    A constant number of rows unrolls the loops over them.
    """

    @helper
    def runge_kutta_step(functions, params, coefficients, substep: int, memory, work, t, h) -> Step:
        """Add ``h Σ b_i k_i`` to the compensated state."""
        table = table_of(coefficients)
        n = rows if rows > 0 else int(table.rows[0])
        y, carry = sections(memory, compensated_state(n))
        own = sections(work, runge_kutta_work(n, len(table.c), REST))
        runge_kutta_stages(functions[0], params, table, y, carry, own, t, h, 0, n)
        combine(table.b, own.k, h, 0.0 * y[0], own.Y, n)
        size = largest(own.Y, n)
        if not size < HUGE:
            return NOT_FINITE, 1, size
        for r in range(n):
            add_compensated(y, carry, r, own.Y[r])
        return OK, 1, 0.0

    return stepper(runge_kutta_step)


@functools.cache
def adaptive_runge_kutta_stepper(rows: int) -> Recorded:
    """Return the stepper of adaptive explicit Runge–Kutta methods; `rows` as in the other."""

    @helper
    def runge_kutta_attempt(
        functions, params, numbers, reuse: int, y, carry, first, known: int, work, t, h
    ) -> tuple[int, float]:
        """Write ``h Σ b_i k_i``, its estimated errors and k_s, see `geomint.kernels.solve.adaptive`.

        The weights of the errors are ``b − b̂`` and perhaps ``b − b_low``.
        """
        n = rows if rows > 0 else len(y)
        table = table_of(numbers)
        stages = len(table.c)
        increment, errors, last, rest = sections(work, adaptive_work(n, n, REST))
        own = sections(rest, runge_kutta_work(n, stages, REST))
        k = own.k
        if known == 1:
            for r in range(n):
                k[r] = first[r]
        runge_kutta_stages(functions[0], params, table, y, carry, own, t, h, known, n)
        zero = 0.0 * y[0]
        combine(table.b, k, h, zero, increment, n)
        size = largest(increment, n)
        if not size < HUGE:
            return NOT_FINITE, size
        for i in range(len(table.errors) // stages):
            weights = part(table.errors, i * stages, stages)
            combine(weights, k, h, zero, part(errors, i * n, n), n)
        for r in range(n):
            first[r] = k[r]
            last[r] = k[(stages - 1) * n + r]
        return OK, 0.0

    return adaptive_stepper(runge_kutta_attempt)
