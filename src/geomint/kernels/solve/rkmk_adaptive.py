"""Adaptive Runge–Kutta–Munthe-Kaas steps: an attempt with the errors of its exponent."""

from __future__ import annotations

import functools
from typing import Any

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.blocks import REST, part, section
from .adaptive import adaptive_stepper, adaptive_work
from .rkmk import diagnose, numbers_of, work_of, write_stages
from .runge_kutta import HUGE, combine, largest
from .status import OK

__all__ = ["adaptive_rkmk_stepper"]


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
        state: ``exp(e)·y − y``. The weights of the errors are ``b − b̂`` and perhaps ``b − b_low``.
        """
        n = rows if rows > 0 else len(y)
        d = m if m > 0 else len(first)
        sizes, result = numbers_of(numbers), adaptive_work(n, d, REST)
        b, layout = section(numbers, sizes, "b"), section(numbers, sizes, "layout")
        estimates = section(numbers, sizes, "errors")
        increment, errors = section(work, result, "increment"), section(work, result, "errors")
        last, rest = section(work, result, "last"), section(work, result, "attempt")
        own = work_of(numbers, n, d)
        u, xi, step = (
            section(rest, own, "u"),
            section(rest, own, "xi"),
            section(rest, own, "increment"),
        )
        k, scratch = section(rest, own, "k"), section(rest, own, "scratch")
        if known == 1:
            for r in range(d):
                xi[r] = first[r]
        write_stages(generator, act, inverse, params, numbers, y, carry, rest, t, h, known, n, d)
        zero = 0.0 * y[0]
        if reuse == 0:  # else it is the increment of the last stage
            combine(b, k, h, zero, u, d)
            act(layout, u, y, step, scratch)
        if not largest(step, n) < HUGE:
            return diagnose(generator, act, params, numbers, y, carry, rest, t, h, d)
        for r in range(n):
            increment[r] = step[r]
        for i in range(len(estimates) // len(b)):
            combine(part(estimates, i * len(b), len(b)), k, h, zero, u, d)
            act(layout, u, y, part(errors, i * n, n), scratch)
        for r in range(d):
            first[r] = k[r]
            last[r] = xi[r]
        return OK, 0.0

    if act is None:

        def rkmk(f, p, c, reuse, y, carry, first, known, work, t, h):
            return rkmk_attempt(f[0], f[1], f[2], p, c, reuse, y, carry, first, known, work, t, h)

        return adaptive_stepper(helper(rkmk))

    def rkmk_in(f, p, c, reuse, y, carry, first, known, work, t, h):
        return rkmk_attempt(f[0], act, inverse, p, c, reuse, y, carry, first, known, work, t, h)

    return adaptive_stepper(helper(rkmk_in))
