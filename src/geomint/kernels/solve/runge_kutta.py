"""Explicit Runge–Kutta steps of any tableau, for any kind of number."""

from __future__ import annotations

import functools
from typing import Any

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import like, maximum, top
from ..numbers.blocks import part
from .adaptive import adaptive_stepper
from .advance import stepper
from .compensated import add_compensated
from .status import NOT_FINITE, OK

__all__ = [
    "HUGE",
    "adaptive_runge_kutta_stepper",
    "adaptive_runge_kutta_work_size",
    "combine",
    "largest",
    "runge_kutta_stepper",
    "runge_kutta_work_size",
]

HEADER = 2  # coefficients: rows, stages; then A (full), b, c
HUGE = 1e300  # what is not less counts as not finite


def runge_kutta_work_size(rows: int, stages: int, field_work: int) -> int:
    """Rows of scratch: the stage derivatives, one stage, the field's own scratch."""
    return (stages + 1) * rows + field_work


@inlined
def combine(weights: Any, k: Any, h: float, zero: Any, out: Any, rows: int) -> None:
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
def largest(block: Any, rows: int) -> Any:
    """Return the largest absolute value in any row and lane; NaN if there is one."""
    worst = abs(block[0])
    for r in range(1, rows):
        worst = maximum(abs(block[r]), worst)
    return top(worst)


@inlined
def runge_kutta_stages(
    field: Any,
    params: Any,
    coefficients: Any,
    y: Any,
    carry: Any,
    k: Any,
    Y: Any,
    scratch: Any,
    t: float,
    h: float,
    known: int,
    rows: int,
) -> None:
    """Write ``k_i = f(t + c_i h, y + h Σ_j a_ij k_j)``; the first `known` of them are there already.

    y and its carry are an unevaluated sum; `Y` is scratch for one stage.
    """
    zero = 0.0 * y[0]
    stages = int(coefficients[1])
    a = part(coefficients, HEADER, stages * stages)
    c = part(coefficients, HEADER + stages * (stages + 1), stages)
    for i in range(known, stages):
        combine(part(a, i * stages, i), k, h, zero, Y, rows)
        for r in range(rows):
            Y[r] = y[r] + (carry[r] + Y[r])
        field(params, like(t + c[i] * h, y[0]), Y, part(k, i * rows, rows), scratch)


@functools.cache
def runge_kutta_stepper(rows: int) -> Recorded:
    """Return the stepper of explicit Runge–Kutta methods for states of `rows` numbers (0: any).

    A constant number of rows unrolls the loops over them.
    """

    @helper
    def runge_kutta_step(
        functions: Any,
        params: Any,
        coefficients: Any,
        substep: int,
        memory: Any,
        work: Any,
        t: float,
        h: float,
    ) -> tuple[int, int, float]:
        """Add ``h Σ b_i k_i`` to the compensated state."""
        n = rows if rows > 0 else int(coefficients[0])
        stages = int(coefficients[1])
        y = part(memory, 0, n)
        carry = part(memory, n, n)
        k = part(work, 0, stages * n)
        Y = part(work, stages * n, n)
        scratch = part(work, (stages + 1) * n, len(work) - (stages + 1) * n)
        runge_kutta_stages(functions[0], params, coefficients, y, carry, k, Y, scratch, t, h, 0, n)
        weights = part(coefficients, HEADER + stages * stages, stages)
        combine(weights, k, h, 0.0 * y[0], Y, n)
        size = largest(Y, n)
        if not size < HUGE:
            return NOT_FINITE, 1, size
        for r in range(n):
            add_compensated(y, carry, r, Y[r])
        return OK, 1, 0.0

    return stepper(runge_kutta_step, 1)


@functools.cache
def adaptive_runge_kutta_stepper(rows: int) -> Recorded:
    """Return the stepper of adaptive explicit Runge–Kutta methods; `rows` as in the other."""

    @helper
    def runge_kutta_attempt(
        functions: Any,
        params: Any,
        numbers: Any,
        reuse: int,
        y: Any,
        carry: Any,
        first: Any,
        known: int,
        work: Any,
        t: float,
        h: float,
    ) -> tuple[int, float]:
        """Write ``h Σ b_i k_i``, its estimated errors and k_s, see `geomint.kernels.solve.adaptive`.

        `numbers` end with the weights of the errors, ``b − b̂`` and perhaps ``b − b_low``.
        """
        n = rows if rows > 0 else len(y)
        stages = int(numbers[1])
        increment = part(work, 0, n)
        last = part(work, 3 * n, n)
        k = part(work, 4 * n, stages * n)
        Y = part(work, (4 + stages) * n, n)
        at = (5 + stages) * n
        scratch = part(work, at, len(work) - at)
        if known == 1:
            for r in range(n):
                k[r] = first[r]
        runge_kutta_stages(functions[0], params, numbers, y, carry, k, Y, scratch, t, h, known, n)
        zero = 0.0 * y[0]
        combine(part(numbers, HEADER + stages * stages, stages), k, h, zero, increment, n)
        size = largest(increment, n)
        if not size < HUGE:
            return NOT_FINITE, size
        at = HEADER + stages * (stages + 2)
        for estimate in range((len(numbers) - at) // stages):
            weights = part(numbers, at + estimate * stages, stages)
            combine(weights, k, h, zero, part(work, (1 + estimate) * n, n), n)
        for r in range(n):
            first[r] = k[r]
            last[r] = k[(stages - 1) * n + r]
        return OK, 0.0

    return adaptive_stepper(runge_kutta_attempt, 1)


def adaptive_runge_kutta_work_size(rows: int, stages: int, field_work: int) -> int:
    """Rows of scratch: increment, two errors, last derivative, and those of a fixed step."""
    return 4 * rows + runge_kutta_work_size(rows, stages, field_work)
