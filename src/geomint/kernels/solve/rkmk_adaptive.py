"""Adaptive Runge–Kutta–Munthe-Kaas steps: an attempt with the errors of its exponent."""

from __future__ import annotations

import functools
from typing import Any

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.blocks import part
from .adaptive import adaptive_stepper
from .rkmk import HEADER, diagnose, rkmk_work_size, write_stages
from .runge_kutta import HUGE, combine, largest
from .status import OK

__all__ = ["adaptive_rkmk_stepper", "adaptive_rkmk_work_size"]


@functools.cache
def adaptive_rkmk_stepper(
    act: Recorded | None, inverse: Recorded | None, rows: int, m: int
) -> Recorded:
    """Return the stepper of adaptive RKMK methods; arguments and functions as `rkmk_stepper`."""

    @inlined
    def rkmk_attempt(
        generator: Any,
        act: Any,
        inverse: Any,
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
        """Write the increment of the state, its errors and ξ_s, see `geomint.kernels.solve.adaptive`.

        The error is the difference of the exponents, ``e = u₁ − û₁``, and what it does to the
        state: ``exp(e)·y − y``. `numbers` end with the weights of the errors, ``b − b̂`` and perhaps
        ``b − b_low``.
        """
        n = rows if rows > 0 else len(y)
        d = m if m > 0 else len(first)
        stages = int(numbers[2])
        layout = part(numbers, HEADER, int(numbers[3]))
        at = HEADER + len(layout) + stages * stages
        b = part(numbers, at, stages)
        errors = at + 2 * stages
        increment, last = part(work, 0, n), part(work, 3 * n, d)
        own = part(work, 3 * n + d, len(work) - 3 * n - d)
        u, xi, step = part(own, 0, d), part(own, d, d), part(own, 2 * d, n)
        at = 2 * d + 2 * n
        k = part(own, at, stages * d)
        at += stages * d
        rest = part(own, at, len(own) - at)
        if known == 1:
            for r in range(d):
                xi[r] = first[r]
        write_stages(generator, act, inverse, params, numbers, y, carry, own, t, h, known, n, d)
        zero = 0.0 * y[0]
        if reuse == 0:  # else it is the increment of the last stage
            combine(b, k, h, zero, u, d)
            act(layout, u, y, step, rest)
        if not largest(step, n) < HUGE:
            return diagnose(generator, act, params, numbers, y, carry, own, t, h, d)
        for r in range(n):
            increment[r] = step[r]
        for estimate in range((len(numbers) - errors) // stages):
            combine(part(numbers, errors + estimate * stages, stages), k, h, zero, u, d)
            act(layout, u, y, part(work, (1 + estimate) * n, n), rest)
        for r in range(d):
            first[r] = k[r]
            last[r] = xi[r]
        return OK, 0.0

    if act is None:

        def rkmk(f, p, c, reuse, y, carry, first, known, work, t, h):
            return rkmk_attempt(f[0], f[1], f[2], p, c, reuse, y, carry, first, known, work, t, h)

        return adaptive_stepper(helper(rkmk), 3)

    def rkmk_in(f, p, c, reuse, y, carry, first, known, work, t, h):
        return rkmk_attempt(f[0], act, inverse, p, c, reuse, y, carry, first, known, work, t, h)

    return adaptive_stepper(helper(rkmk_in), 1)


def adaptive_rkmk_work_size(
    rows: int, algebra_rows: int, stages: int, field_work: int, group_work: int
) -> int:
    """Rows of scratch: the increment, two errors and the last ξ beside those of a fixed step."""
    fixed = rkmk_work_size(rows, algebra_rows, stages, field_work, group_work)
    return fixed + 3 * rows + algebra_rows
