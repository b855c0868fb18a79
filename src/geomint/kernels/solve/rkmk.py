"""Runge–Kutta–Munthe-Kaas steps: a Runge–Kutta method in the Lie algebra."""

from __future__ import annotations

import functools
from collections import namedtuple
from typing import Any

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import NAN, like, select
from ..numbers.blocks import REST, part, section
from .advance import stepper
from .compensated import add_compensated, compensated_state
from .runge_kutta import HUGE, combine, largest
from .status import NOT_FINITE, OK, OUTSIDE_CHART

__all__ = [
    "dexpinv_series",
    "dexpinv_work",
    "diagnose",
    "numbers_of",
    "rkmk_coefficients",
    "rkmk_stepper",
    "rkmk_work",
    "work_of",
    "write_stages",
]

Coefficients = namedtuple(
    "Coefficients", "rows algebra_rows stages layout_rows field_work layout A b c errors"
)
Series = namedtuple("Series", "a b scratch")
Work = namedtuple("Work", "u xi increment Y k field_scratch scratch")


@inlined
def rkmk_coefficients(layout_rows: int, s: int, errors: int) -> Coefficients:
    """Return the layout of coefficients: sizes, the group's own `layout`, the tableau; A is full."""
    return Coefficients(
        rows=1,
        algebra_rows=1,
        stages=1,
        layout_rows=1,
        field_work=1,
        layout=layout_rows,
        A=s * s,
        b=s,
        c=s,
        errors=errors,
    )


@inlined
def numbers_of(coefficients: Any) -> Coefficients:
    """Return the layout that coefficients have, whose first numbers lie where they do in any."""
    header = rkmk_coefficients(0, 0, REST)
    layout_rows = int(section(coefficients, header, "layout_rows")[0])
    return rkmk_coefficients(layout_rows, int(section(coefficients, header, "stages")[0]), REST)


@inlined
def rkmk_work(rows: int, m: int, stages: int, field_work: int, scratch: int) -> Work:
    """Return the layout of scratch: exponent, ξ, increment, stage, derivatives, the functions' own."""
    return Work(
        u=m, xi=m, increment=rows, Y=rows, k=stages * m, field_scratch=field_work, scratch=scratch
    )


@inlined
def work_of(coefficients: Any, rows: int, m: int) -> Work:
    """Return the layout that scratch has with these coefficients."""
    numbers = numbers_of(coefficients)
    field_work = int(section(coefficients, numbers, "field_work")[0])
    return rkmk_work(rows, m, len(section(coefficients, numbers, "b")), field_work, REST)


@inlined
def dexpinv_work(rows: int, scratch: int) -> Series:
    """Return the layout of scratch of a series: two elements of the algebra, the bracket's own."""
    return Series(a=rows, b=rows, scratch=scratch)


@functools.cache
def dexpinv_series(
    bracket: Recorded,
    numerators: tuple[float, ...],
    denominators: tuple[float, ...],
    extent: Recorded | None = None,
) -> Recorded:
    """Return ``dexpinv(layout, u, v, out, work)`` as ``Σ_k w_k ad_u^k v``, a truncated series.

    w_k = numerators[k] / denominators[k] is B_k / k!, kept as whole numbers: exact in any kind of
    number. Its scratch is `dexpinv_work`. Where `extent` is above 1 it writes NaN: a polynomial is no
    inverse there, and exponents grow until exp of them has no correct digit.
    """
    terms = len(numerators)

    def dexpinv(layout, u, v, out, work):
        rows = len(v)
        own = dexpinv_work(rows, REST)
        a, b, scratch = (
            section(work, own, "a"),
            section(work, own, "b"),
            section(work, own, "scratch"),
        )
        for r in range(rows):
            out[r] = v[r]
            a[r] = v[r]
        for k in range(1, terms):
            bracket(layout, u, a, b, scratch)
            for r in range(rows):
                a[r] = b[r]
                if numerators[k] != 0.0:
                    out[r] = out[r] + numerators[k] * a[r] / denominators[k]

    series = helper(dexpinv)
    if extent is None:
        return series

    def dexpinv_inside(layout, u, v, out, work):
        series(layout, u, v, out, work)
        inside = extent(layout, u, work) <= 1.0
        for r in range(len(v)):
            out[r] = select(inside, out[r], NAN + 0.0 * out[r])

    return helper(dexpinv_inside)


@inlined
def stage_value(
    act: Any, coefficients: Any, i: int, k: Any, y: Any, carry: Any, work: Any, scratch: Any,
    h: float, n: int, m: int,
) -> None:  # fmt: skip
    """Write ``u_i = h Σ_j a_ij k_j``, its increment and ``Y_i = exp(u_i)·y``."""
    numbers, own = numbers_of(coefficients), work_of(coefficients, n, m)
    a, layout = section(coefficients, numbers, "A"), section(coefficients, numbers, "layout")
    stages = len(section(coefficients, numbers, "b"))
    u, step, Y = section(work, own, "u"), section(work, own, "increment"), section(work, own, "Y")
    if i == 0:
        for r in range(n):
            Y[r] = y[r] + carry[r]
    else:
        combine(part(a, i * stages, i), k, h, 0.0 * y[0], u, m)
        act(layout, u, y, step, scratch)
        for r in range(n):
            Y[r] = y[r] + (carry[r] + step[r])


@inlined
def write_stages(
    generator: Any,
    act: Any,
    inverse: Any,
    params: Any,
    coefficients: Any,
    y: Any,
    carry: Any,
    work: Any,
    t: float,
    h: float,
    known: int,
    n: int,
    m: int,
) -> None:
    """Write ``k_i = dexp⁻¹_(u_i) ξ(t + c_i h, exp(u_i)·y)`` and what is in `work` before them.

    y and its carry are an unevaluated sum. With `known` = 1, the place of ξ holds ξ(t, y) at
    first. Nothing is checked: what is not finite spreads to the end of the step, see
    `diagnose`.
    """
    numbers, own = numbers_of(coefficients), work_of(coefficients, n, m)
    c, layout = section(coefficients, numbers, "c"), section(coefficients, numbers, "layout")
    u, xi, Y, k = (
        section(work, own, "u"),
        section(work, own, "xi"),
        section(work, own, "Y"),
        section(work, own, "k"),
    )
    field_scratch, scratch = section(work, own, "field_scratch"), section(work, own, "scratch")
    for i in range(len(c)):
        stage_value(act, coefficients, i, k, y, carry, work, scratch, h, n, m)
        if i >= known:
            generator(params, like(t + c[i] * h, y[0]), Y, xi, field_scratch)
        derivative = part(k, i * m, m)
        if i == 0:  # u = 0, where dexp is the identity
            for r in range(m):
                derivative[r] = xi[r]
        else:
            inverse(layout, u, xi, derivative, scratch)


@inlined
def diagnose(
    generator: Any,
    act: Any,
    params: Any,
    coefficients: Any,
    y: Any,
    carry: Any,
    work: Any,
    t: float,
    h: float,
    m: int,
) -> tuple[int, float]:
    """Return (status, residual) of a step whose increment is not finite: the first cause."""
    # Inlined: code in which a function is handed over by its address cannot be kept on disk.
    n = len(y)
    c, own = section(coefficients, numbers_of(coefficients), "c"), work_of(coefficients, n, m)
    xi, step, Y = section(work, own, "xi"), section(work, own, "increment"), section(work, own, "Y")
    k, field_scratch = section(work, own, "k"), section(work, own, "field_scratch")
    scratch = section(work, own, "scratch")
    for i in range(len(c)):
        size = largest(part(k, i * m, m), m)
        if not size < HUGE:
            if i == 0:
                return NOT_FINITE, size
            stage_value(act, coefficients, i, k, y, carry, work, scratch, h, n, m)
            moved = largest(step, n)
            if not moved < HUGE:
                return OUTSIDE_CHART, moved
            generator(params, like(t + c[i] * h, y[0]), Y, xi, field_scratch)
            found = largest(xi, m)
            return (OUTSIDE_CHART, size) if found < HUGE else (NOT_FINITE, found)
    return OUTSIDE_CHART, largest(step, n)


@functools.cache
def rkmk_stepper(act: Recorded | None, inverse: Recorded | None, rows: int, m: int) -> Recorded:
    """Return the stepper of RKMK methods in the coordinates of a group.

    Parameters
    ----------
    act, inverse : Recorded or None
        The coordinates' map as an increment of the state and the inverse of the map's differential,
        to be compiled in; the stepper takes (generator,). With None it takes (generator, act,
        inverse).
    rows, m : int
        Numbers of rows of states and of the algebra, as constants that unroll the loops over them,
        or 0: any.
    """

    @inlined
    def rkmk_step(
        generator: Any,
        act: Any,
        inverse: Any,
        params: Any,
        coefficients: Any,
        memory: Any,
        work: Any,
        t: float,
        h: float,
    ) -> tuple[int, int, float]:
        """Let ``exp(u₁)``, ``u₁ = h Σ b_i k_i``, act on the compensated state."""
        numbers = numbers_of(coefficients)
        n = rows if rows > 0 else int(section(coefficients, numbers, "rows")[0])
        d = m if m > 0 else int(section(coefficients, numbers, "algebra_rows")[0])
        b, layout = section(coefficients, numbers, "b"), section(coefficients, numbers, "layout")
        state, own = compensated_state(n), work_of(coefficients, n, d)
        y, carry = section(memory, state, "y"), section(memory, state, "carry")
        u, step, k = (
            section(work, own, "u"),
            section(work, own, "increment"),
            section(work, own, "k"),
        )
        scratch = section(work, own, "scratch")
        write_stages(generator, act, inverse, params, coefficients, y, carry, work, t, h, 0, n, d)
        combine(b, k, h, 0.0 * y[0], u, d)
        act(layout, u, y, step, scratch)
        if not largest(step, n) < HUGE:
            status, size = diagnose(generator, act, params, coefficients, y, carry, work, t, h, d)
            return status, 1, size
        for r in range(n):
            add_compensated(y, carry, r, step[r])
        return OK, 1, 0.0

    if act is None:

        def rkmk(functions, p, c, substep, memory, work, t, h):
            return rkmk_step(functions[0], functions[1], functions[2], p, c, memory, work, t, h)

        return stepper(helper(rkmk))

    def rkmk_in(functions, p, c, substep, memory, work, t, h):
        return rkmk_step(functions[0], act, inverse, p, c, memory, work, t, h)

    return stepper(helper(rkmk_in))
