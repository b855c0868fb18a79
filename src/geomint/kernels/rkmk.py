"""Runge–Kutta–Munthe-Kaas steps: a Runge–Kutta method in the Lie algebra."""

from __future__ import annotations

import functools
from typing import Any

from .adaptive import adaptive_stepper
from .advance import stepper
from .arithmetic import like
from .blocks import part
from .compensated import add_compensated
from .recorded import Recorded, helper
from .runge_kutta import HUGE, combine, largest
from .status import NOT_FINITE, OK, OUTSIDE_CHART

__all__ = [
    "adaptive_rkmk_stepper",
    "adaptive_rkmk_work_size",
    "dexpinv_series",
    "rkmk_stepper",
    "rkmk_work_size",
]

# coefficients: rows, algebra rows, stages, length of layout, rows of scratch of the generator; then
# layout, A (full), b, c.
HEADER = 5


def rkmk_work_size(
    rows: int, algebra_rows: int, stages: int, field_work: int, group_work: int
) -> int:
    """Rows of scratch: stage derivatives, two algebra elements, two states, the functions' own."""
    return (stages + 2) * algebra_rows + 2 * rows + field_work + group_work


@functools.cache
def dexpinv_series(
    bracket: Recorded, numerators: tuple[float, ...], denominators: tuple[float, ...]
) -> Recorded:
    """Return ``dexpinv(layout, u, v, out, work)`` as ``Σ_k w_k ad_u^k v``, a truncated series.

    w_k = numerators[k] / denominators[k] is B_k / k!, kept as whole numbers: exact in any kind of
    number. It needs two algebra elements of scratch beside that of `bracket`.
    """
    terms = len(numerators)

    def dexpinv(layout, u, v, out, work):  # type: ignore[no-untyped-def]
        rows = len(v)
        a = part(work, 0, rows)
        b = part(work, rows, rows)
        scratch = part(work, 2 * rows, len(work) - 2 * rows)
        for r in range(rows):
            out[r] = v[r]
            a[r] = v[r]
        for k in range(1, terms):
            bracket(layout, u, a, b, scratch)
            for r in range(rows):
                a[r] = b[r]
                if numerators[k] != 0.0:
                    out[r] = out[r] + numerators[k] * a[r] / denominators[k]

    return helper(dexpinv)


@helper
def rkmk_stages(
    generator: Any,
    act: Any,
    inverse: Any,
    params: Any,
    coefficients: Any,
    y: Any,
    carry: Any,
    k: Any,
    u: Any,
    xi: Any,
    step: Any,
    work: Any,
    t: float,
    h: float,
    known: int,
) -> tuple[int, float]:
    """Write ``k_i = dexp⁻¹_(u_i) ξ(t + c_i h, exp(u_i)·y)``, ``u_i = h Σ_j a_ij k_j``.

    y and its carry are an unevaluated sum. `u`, `xi` and `step` are left as in the last stage: u_i,
    ξ and exp(u_i)·y − y. With `known` = 1, `xi` holds ξ(t, y) at first.

    Returns
    -------
    status, residual
    """
    rows = len(y)
    m = len(u)
    zero = 0.0 * y[0]
    stages = int(coefficients[2])
    layout = part(coefficients, HEADER, int(coefficients[3]))
    field_work = int(coefficients[4])
    a = part(coefficients, HEADER + len(layout), stages * stages)
    c = part(coefficients, HEADER + len(layout) + stages * (stages + 1), stages)
    Y = part(work, 0, rows)
    field_scratch = part(work, rows, field_work)
    scratch = part(work, rows + field_work, len(work) - rows - field_work)
    for i in range(stages):
        if i == 0:
            for r in range(rows):
                Y[r] = y[r] + carry[r]
        else:
            combine(part(a, i * stages, i), k, h, zero, u)
            act(layout, u, y, step, scratch)
            size = largest(step)
            if not size < HUGE:
                return OUTSIDE_CHART, size
            for r in range(rows):
                Y[r] = y[r] + (carry[r] + step[r])
        if i >= known:
            generator(params, like(t + c[i] * h, y[0]), Y, xi, field_scratch)
        size = largest(xi)
        if not size < HUGE:
            return NOT_FINITE, size
        derivative = part(k, i * m, m)
        if i == 0:  # u = 0, where dexp is the identity
            for r in range(m):
                derivative[r] = xi[r]
        else:
            inverse(layout, u, xi, derivative, scratch)
            size = largest(derivative)
            if not size < HUGE:
                return OUTSIDE_CHART, size
    return OK, 0.0


@functools.cache
def rkmk_stepper(act: Recorded, inverse: Recorded) -> Recorded:
    """Return the stepper of RKMK methods in the coordinates of a group; it takes (generator,).

    `act` is the coordinates' map as an increment of the state, `inverse` the inverse of the map's
    differential. Both are compiled in: on SO(3) they are a few dozen operations each, and calls
    through pointers would cost as much again.
    """

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
        """Let ``exp(u₁)``, ``u₁ = h Σ b_i k_i``, act on the compensated state."""
        rows = int(coefficients[0])
        m = int(coefficients[1])
        stages = int(coefficients[2])
        layout = part(coefficients, HEADER, int(coefficients[3]))
        b = part(coefficients, HEADER + len(layout) + stages * stages, stages)
        y = part(memory, 0, rows)
        carry = part(memory, rows, rows)
        k = part(work, 0, stages * m)
        u = part(work, stages * m, m)
        xi = part(work, (stages + 1) * m, m)
        step = part(work, (stages + 2) * m, rows)
        at = (stages + 2) * m + rows
        rest = part(work, at, len(work) - at)
        status, size = rkmk_stages(
            functions[0], act, inverse,
            params, coefficients, y, carry, k, u, xi, step, rest, t, h, 0,
        )  # fmt: skip
        if status != OK:
            return status, 1, size
        combine(b, k, h, 0.0 * y[0], u)
        act(layout, u, y, step, rest)
        size = largest(step)
        if not size < HUGE:
            return OUTSIDE_CHART, 1, size
        for r in range(rows):
            add_compensated(y, carry, r, step[r])
        return OK, 1, 0.0

    return stepper(rkmk_step, 1)


@functools.cache
def adaptive_rkmk_stepper(act: Recorded, inverse: Recorded) -> Recorded:
    """Return the stepper of adaptive RKMK methods; arguments and functions as `rkmk_stepper`."""

    @helper
    def rkmk_attempt(
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
        """Write the increment of the state, its errors and ξ_s, see `geomint.kernels.adaptive`.

        The error is the difference of the exponents, ``e = u₁ − û₁``, and what it does to the
        state: ``exp(e)·y − y``. `numbers` end with the weights of the errors, ``b − b̂`` and perhaps
        ``b − b_low``.
        """
        rows = len(y)
        m = len(first)
        stages = int(numbers[2])
        layout = part(numbers, HEADER, int(numbers[3]))
        at = HEADER + len(layout) + stages * stages
        b = part(numbers, at, stages)
        errors = at + 2 * stages
        increment = part(work, 0, rows)
        xi = part(work, 3 * rows, m)
        k = part(work, 3 * rows + m, stages * m)
        u = part(work, 3 * rows + (1 + stages) * m, m)
        at = 3 * rows + (2 + stages) * m
        rest = part(work, at, len(work) - at)
        if known == 1:
            for r in range(m):
                xi[r] = first[r]
        status, size = rkmk_stages(
            functions[0], act, inverse,
            params, numbers, y, carry, k, u, xi, increment, rest, t, h, known,
        )  # fmt: skip
        if status != OK:
            return status, size
        zero = 0.0 * y[0]
        if reuse == 0:  # else it is the increment of the last stage
            combine(b, k, h, zero, u)
            act(layout, u, y, increment, rest)
            size = largest(increment)
            if not size < HUGE:
                return OUTSIDE_CHART, size
        for estimate in range((len(numbers) - errors) // stages):
            combine(part(numbers, errors + estimate * stages, stages), k, h, zero, u)
            act(layout, u, y, part(work, (1 + estimate) * rows, rows), rest)
        for r in range(m):
            first[r] = k[r]
        return OK, 0.0

    return adaptive_stepper(rkmk_attempt, 1)


def adaptive_rkmk_work_size(
    rows: int, algebra_rows: int, stages: int, field_work: int, group_work: int
) -> int:
    """Rows of scratch: a second error beside those of a fixed step, and room for its first."""
    fixed = rkmk_work_size(rows, algebra_rows, stages, field_work, group_work)
    return fixed + 2 * rows
