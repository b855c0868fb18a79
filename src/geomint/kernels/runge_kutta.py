"""Explicit Runge–Kutta steps of any tableau, for any kind of number."""

from __future__ import annotations

import functools
from typing import Any

from .advance import stepper
from .arithmetic import like, maximum, top
from .blocks import part
from .compensated import add_compensated
from .recorded import Recorded, helper
from .status import NOT_FINITE, OK

__all__ = ["runge_kutta_stepper", "runge_kutta_work_size"]

HEADER = 2  # coefficients: rows, stages; then A (full), b, c


def runge_kutta_work_size(rows: int, stages: int, field_work: int) -> int:
    """Rows of scratch: the stage derivatives, one stage, the field's own scratch."""
    return (stages + 1) * rows + field_work


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
    """Add ``h Σ b_i k_i`` with ``k_i = f(t + c_i h, y + h Σ_j a_ij k_j)`` to the compensated state."""
    field = functions[0]
    rows = int(coefficients[0])
    stages = int(coefficients[1])
    a = part(coefficients, HEADER, stages * stages)
    b = part(coefficients, HEADER + stages * stages, stages)
    c = part(coefficients, HEADER + stages * (stages + 1), stages)
    y = part(memory, 0, rows)
    carry = part(memory, rows, rows)
    k = part(work, 0, stages * rows)
    Y = part(work, stages * rows, rows)
    scratch = part(work, (stages + 1) * rows, len(work) - (stages + 1) * rows)
    for i in range(stages):
        for r in range(rows):
            total = 0.0 * y[r]
            for j in range(i):
                if a[i * stages + j] != 0.0:
                    total += a[i * stages + j] * k[j * rows + r]
            Y[r] = y[r] + (carry[r] + h * total)
        field(params, like(t + c[i] * h, y[0]), Y, part(k, i * rows, rows), scratch)
    worst = 0.0 * y[0]
    for r in range(rows):
        total = 0.0 * y[r]
        for j in range(stages):
            if b[j] != 0.0:
                total += b[j] * k[j * rows + r]
        Y[r] = h * total
        worst = maximum(abs(Y[r]), worst)
    largest = top(worst)
    if not largest < 1e300:
        return NOT_FINITE, 1, largest
    for r in range(rows):
        add_compensated(y, carry, r, Y[r])
    return OK, 1, 0.0


@functools.cache
def runge_kutta_stepper() -> Recorded:
    """Return the stepper of explicit Runge–Kutta methods."""
    return stepper(runge_kutta_step, 1)
