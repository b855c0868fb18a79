"""Adaptive Runge–Kutta–Munthe-Kaas steps: an attempt with the errors of its exponent."""

import functools

from ..compiling.recorded import Recorded, inlined
from ..numbers.blocks import REST, part, sections
from .adaptive import adaptive_stepper, adaptive_work
from .advance import with_maps
from .rkmk import diagnose, parts_of, table_of, write_stages
from .runge_kutta import HUGE, combine, largest
from .status import OK


@functools.cache
def adaptive_rkmk_stepper(
    act: Recorded | None, inverse: Recorded | None, rows: int, m: int
) -> Recorded:
    """Return the stepper of adaptive RKMK methods; arguments and functions as `rkmk_stepper`."""

    @inlined
    def rkmk(
        generator,
        maps,
        params,
        numbers,
        reuse: int,
        y,
        carry,
        first,
        known: int,
        work,
        t: float,
        h: float,
    ) -> tuple[int, float]:
        """Write the increment of the state, its errors and ξ_s, see `geomint.kernels.solve.adaptive`.

        The error is the difference of the exponents, ``e = u₁ − û₁``, and what it does to the
        state: ``exp(e)·y − y``. The weights of the errors are ``b − b̂`` and perhaps ``b − b_low``.
        """
        act, inverse = maps
        n = rows if rows > 0 else len(y)
        d = m if m > 0 else len(first)
        table = table_of(numbers)
        stages = len(table.b)
        increment, errors, last, rest = sections(work, adaptive_work(n, d, REST))
        own = parts_of(rest, table, n, d)
        if known == 1:
            for r in range(d):
                own.xi[r] = first[r]
        write_stages(generator, act, inverse, params, table, y, carry, own, t, h, known, n, d)
        zero = 0.0 * y[0]
        if reuse == 0:  # else it is the increment of the last stage
            combine(table.b, own.k, h, zero, own.u, d)
            act(table.layout, own.u, y, own.increment, own.scratch)
        if not largest(own.increment, n) < HUGE:
            return diagnose(generator, act, params, table, y, carry, own, t, h, d)
        for r in range(n):
            increment[r] = own.increment[r]
        for i in range(len(table.errors) // stages):
            combine(part(table.errors, i * stages, stages), own.k, h, zero, own.u, d)
            act(table.layout, own.u, y, part(errors, i * n, n), own.scratch)
        for r in range(d):
            first[r] = own.k[r]
            last[r] = own.xi[r]
        return OK, 0.0

    return adaptive_stepper(with_maps(rkmk, act, inverse))
