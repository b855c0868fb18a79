"""Explicit Runge–Kutta steps of any tableau, for any kind of number."""

from __future__ import annotations

import functools
from typing import Any

from .adaptive import adaptive_stepper
from .advance import stepper
from .arithmetic import like, maximum, top
from .blocks import part
from .compensated import add_compensated
from .recorded import Recorded, helper
from .status import NOT_FINITE, OK

__all__ = [
    "HUGE",
    "adaptive_runge_kutta_stepper",
    "adaptive_runge_kutta_work_size",
    "combine",
    "largest",
    "runge_kutta_stages",
    "runge_kutta_stepper",
    "runge_kutta_work_size",
]

HEADER = 2  # coefficients: rows, stages; then A (full), b, c
HUGE = 1e300  # what is not less counts as not finite


def runge_kutta_work_size(rows: int, stages: int, field_work: int) -> int:
    """Rows of scratch: the stage derivatives, one stage, the field's own scratch."""
    return (stages + 1) * rows + field_work


@helper
def combine(weights: Any, k: Any, h: float, zero: Any, out: Any) -> None:
    """Write ``h Σ_j weights[j] k_j``; `k` holds the vectors one after the other.

    `zero` is the number 0 of the right kind.
    """
    rows = len(out)
    for r in range(rows):
        total = zero
        for j in range(len(weights)):
            if weights[j] != 0.0:
                total += weights[j] * k[j * rows + r]
        out[r] = h * total


@helper
def largest(block: Any) -> Any:
    """Return the largest absolute value in any row and lane; NaN if there is one."""
    worst = abs(block[0])
    for r in range(1, len(block)):
        worst = maximum(abs(block[r]), worst)
    return top(worst)


@helper
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
) -> None:
    """Write ``k_i = f(t + c_i h, y + h Σ_j a_ij k_j)``; the first `known` of them are there already.

    y and its carry are an unevaluated sum; `Y` is scratch for one stage.
    """
    rows = len(y)
    zero = 0.0 * y[0]
    stages = int(coefficients[1])
    a = part(coefficients, HEADER, stages * stages)
    c = part(coefficients, HEADER + stages * (stages + 1), stages)
    for i in range(known, stages):
        combine(part(a, i * stages, i), k, h, zero, Y)
        for r in range(rows):
            Y[r] = y[r] + (carry[r] + Y[r])
        field(params, like(t + c[i] * h, y[0]), Y, part(k, i * rows, rows), scratch)


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
    rows = int(coefficients[0])
    stages = int(coefficients[1])
    y = part(memory, 0, rows)
    carry = part(memory, rows, rows)
    k = part(work, 0, stages * rows)
    Y = part(work, stages * rows, rows)
    scratch = part(work, (stages + 1) * rows, len(work) - (stages + 1) * rows)
    runge_kutta_stages(functions[0], params, coefficients, y, carry, k, Y, scratch, t, h, 0)
    combine(part(coefficients, HEADER + stages * stages, stages), k, h, 0.0 * y[0], Y)
    size = largest(Y)
    if not size < HUGE:
        return NOT_FINITE, 1, size
    for r in range(rows):
        add_compensated(y, carry, r, Y[r])
    return OK, 1, 0.0


@functools.cache
def runge_kutta_stepper() -> Recorded:
    """Return the stepper of explicit Runge–Kutta methods."""
    return stepper(runge_kutta_step, 1)


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
    """Write ``h Σ b_i k_i``, its estimated errors and k_s, see `geomint.kernels.adaptive`.

    `numbers` end with the weights of the errors, ``b − b̂`` and perhaps ``b − b_low``.
    """
    rows = len(y)
    stages = int(numbers[1])
    increment = part(work, 0, rows)
    last = part(work, 3 * rows, rows)
    k = part(work, 4 * rows, stages * rows)
    Y = part(work, (4 + stages) * rows, rows)
    at = (5 + stages) * rows
    scratch = part(work, at, len(work) - at)
    if known == 1:
        for r in range(rows):
            k[r] = first[r]
    runge_kutta_stages(functions[0], params, numbers, y, carry, k, Y, scratch, t, h, known)
    zero = 0.0 * y[0]
    combine(part(numbers, HEADER + stages * stages, stages), k, h, zero, increment)
    size = largest(increment)
    if not size < HUGE:
        return NOT_FINITE, size
    at = HEADER + stages * (stages + 2)
    for estimate in range((len(numbers) - at) // stages):
        weights = part(numbers, at + estimate * stages, stages)
        combine(weights, k, h, zero, part(work, (1 + estimate) * rows, rows))
    for r in range(rows):
        first[r] = k[r]
        last[r] = k[(stages - 1) * rows + r]
    return OK, 0.0


@functools.cache
def adaptive_runge_kutta_stepper() -> Recorded:
    """Return the stepper of adaptive explicit Runge–Kutta methods."""
    return adaptive_stepper(runge_kutta_attempt, 1)


def adaptive_runge_kutta_work_size(rows: int, stages: int, field_work: int) -> int:
    """Rows of scratch: increment, two errors, last derivative, and those of a fixed step."""
    return 4 * rows + runge_kutta_work_size(rows, stages, field_work)
