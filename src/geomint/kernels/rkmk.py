"""Runge–Kutta–Munthe-Kaas steps: a Runge–Kutta method in the Lie algebra."""

from __future__ import annotations

import functools
from typing import Any

from .advance import stepper
from .arithmetic import like, maximum, top
from .blocks import part
from .compensated import add_compensated
from .recorded import Recorded, helper
from .status import NOT_FINITE, OK

__all__ = ["rkmk_stepper", "rkmk_work_size"]

# coefficients: rows, algebra rows, stages, length of layout, rows of scratch of the generator,
# number of dexpinv coefficients; then layout, dexpinv coefficients, A (full), b, c.
HEADER = 6


def rkmk_work_size(
    rows: int, algebra_rows: int, stages: int, field_work: int, group_work: int
) -> int:
    """Rows of scratch: stage derivatives, four algebra elements, two states, the functions' own."""
    return (stages + 4) * algebra_rows + 2 * rows + field_work + group_work


@helper
def dexpinv(
    weights: Any, bracket: Any, layout: Any, u: Any, v: Any, out: Any, a: Any, b: Any, work: Any
) -> None:
    """Write ``dexp_u⁻¹ v = Σ_k weights[k] ad_u^k v``, weights[k] = B_k / k!, truncated.

    `a` and `b` are two more algebra elements of scratch.
    """
    rows = len(v)
    for r in range(rows):
        out[r] = v[r]
        a[r] = v[r]
    for k in range(1, len(weights)):
        bracket(layout, u, a, b, work)
        for r in range(rows):
            a[r] = b[r]
            if weights[k] != 0.0:
                out[r] = out[r] + weights[k] * a[r]


@helper
def rkmk_step(
    functions: Any,
    params: Any,
    coefficients: Any,
    substep: int,
    memory: Any,
    work: Any,
    t: float,
    h: float,
) -> tuple[int, int, float]:
    """Solve ``u̇ = dexp_u⁻¹ ξ(t, exp(u) y)`` by the tableau and let exp(u₁) act on the state."""
    generator = functions[0]
    act = functions[1]
    bracket = functions[2]
    rows = int(coefficients[0])
    m = int(coefficients[1])
    stages = int(coefficients[2])
    layout = part(coefficients, HEADER, int(coefficients[3]))
    field_work = int(coefficients[4])
    terms = int(coefficients[5])
    at = HEADER + len(layout)
    weights = part(coefficients, at, terms)
    A = part(coefficients, at + terms, stages * stages)
    b = part(coefficients, at + terms + stages * stages, stages)
    c = part(coefficients, at + terms + stages * (stages + 1), stages)
    y = part(memory, 0, rows)
    carry = part(memory, rows, rows)
    k = part(work, 0, stages * m)
    u = part(work, stages * m, m)
    xi = part(work, (stages + 1) * m, m)
    ad = part(work, (stages + 2) * m, m)
    ad_next = part(work, (stages + 3) * m, m)
    at = (stages + 4) * m
    Y = part(work, at, rows)
    step = part(work, at + rows, rows)
    field_scratch = part(work, at + 2 * rows, field_work)
    at += 2 * rows + field_work
    scratch = part(work, at, len(work) - at)
    worst = 0.0 * y[0]
    for i in range(stages):
        for r in range(m):
            total = 0.0 * y[0]
            for j in range(i):
                if A[i * stages + j] != 0.0:
                    total += A[i * stages + j] * k[j * m + r]
            u[r] = h * total
        act(layout, u, y, step, scratch)
        for r in range(rows):
            Y[r] = y[r] + step[r]
        generator(params, like(t + c[i] * h, y[0]), Y, xi, field_scratch)
        dexpinv(weights, bracket, layout, u, xi, part(k, i * m, m), ad, ad_next, scratch)
        for r in range(m):
            worst = maximum(abs(k[i * m + r]), worst)
    largest = top(worst)
    if not largest < 1e300:
        return NOT_FINITE, 1, largest
    for r in range(m):
        total = 0.0 * y[0]
        for j in range(stages):
            if b[j] != 0.0:
                total += b[j] * k[j * m + r]
        u[r] = h * total
    act(layout, u, y, step, scratch)
    for r in range(rows):
        add_compensated(y, carry, r, step[r])
    return OK, 1, 0.0


@functools.cache
def rkmk_stepper() -> Recorded:
    """Return the stepper of RKMK methods; it takes (generator, act, bracket)."""
    return stepper(rkmk_step, 3)
