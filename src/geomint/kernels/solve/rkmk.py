"""Runge–Kutta–Munthe-Kaas steps: a Runge–Kutta method in the Lie algebra."""

import functools
from collections import namedtuple

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import NAN, like, select
from ..numbers.blocks import REST, part, section, sections
from .advance import stepper, with_maps
from .compensated import add_compensated, compensated_state
from .runge_kutta import HUGE, combine, largest
from .status import NOT_FINITE, OK, OUTSIDE_CHART, Step

Coefficients = namedtuple(
    "Coefficients", "rows algebra_rows stages layout_rows field_work layout A b c errors"
)
Series = namedtuple("Series", "a b scratch")
Work = namedtuple("Work", "u xi increment Y k field_scratch scratch")


@inlined
def rkmk_coefficients(layout_rows: int, s: int, errors: int) -> Coefficients:
    """Return the layout of coefficients: sizes, the group's own `layout`, the tableau; A is full."""
    return Coefficients(1, 1, 1, 1, 1, layout_rows, s * s, s, s, errors)


@inlined
def table_of(coefficients):
    """Return the parts of coefficients by name; the first numbers lie where they do in any."""
    header = rkmk_coefficients(0, 0, REST)
    layout_rows = int(section(coefficients, header, "layout_rows")[0])
    stages = int(section(coefficients, header, "stages")[0])
    return sections(coefficients, rkmk_coefficients(layout_rows, stages, REST))


@inlined
def rkmk_work(rows: int, m: int, stages: int, field_work: int, scratch: int) -> Work:
    """Return the layout of scratch: exponent, ξ, increment, stage, derivatives, the functions' own."""
    return Work(m, m, rows, rows, stages * m, field_work, scratch)


@inlined
def parts_of(work, table, rows: int, m: int):
    """Return the parts of scratch by name."""
    return sections(work, rkmk_work(rows, m, len(table.b), int(table.field_work[0]), REST))


@inlined
def dexpinv_work(rows: int, scratch: int) -> Series:
    """Return the layout of scratch of a series: two elements of the algebra, the bracket's own."""
    return Series(rows, rows, scratch)


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
        a, b, scratch = sections(work, dexpinv_work(rows, REST))
        for r in range(rows):
            out[r] = v[r]
            a[r] = v[r]
        for k in range(1, terms):
            bracket(layout, u, a, b, scratch)
            for r in range(rows):
                a[r] = b[r]
                if numerators[k] != 0.0:
                    out[r] += numerators[k] * a[r] / denominators[k]

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
def stage_value(act, table, i: int, y, carry, own: Work, h, n: int, m: int):
    """Write ``u_i = h Σ_j a_ij k_j``, its increment and ``Y_i = exp(u_i)·y``."""
    if i == 0:
        for r in range(n):
            own.Y[r] = y[r] + carry[r]
    else:
        stages = len(table.b)
        combine(part(table.A, i * stages, i), own.k, h, 0.0 * y[0], own.u, m)
        act(table.layout, own.u, y, own.increment, own.scratch)
        for r in range(n):
            own.Y[r] = y[r] + (carry[r] + own.increment[r])


@inlined
def write_stages(
    generator, act, inverse, params, table, y, carry, own: Work, t, h, known: int, n: int, m: int
):
    """Write ``k_i = dexp⁻¹_(u_i) ξ(t + c_i h, exp(u_i)·y)`` and what is in `own` before them.

    y and its carry are an unevaluated sum. With `known` = 1, the place of ξ holds ξ(t, y) at
    first. Nothing is checked: what is not finite spreads to the end of the step, see
    `diagnose`.
    """
    for i in range(len(table.c)):
        stage_value(act, table, i, y, carry, own, h, n, m)
        if i >= known:
            generator(params, like(t + table.c[i] * h, y[0]), own.Y, own.xi, own.field_scratch)
        derivative = part(own.k, i * m, m)
        if i == 0:  # u = 0, where dexp is the identity
            for r in range(m):
                derivative[r] = own.xi[r]
        else:
            inverse(table.layout, own.u, own.xi, derivative, own.scratch)


@inlined
def diagnose(generator, act, params, table, y, carry, own: Work, t, h, m: int) -> tuple[int, float]:
    """Return (status, residual) of a step whose increment is not finite: the first cause."""
    # Inlined: code in which a function is handed over by its address cannot be kept on disk.
    n = len(y)
    for i in range(len(table.c)):
        size = largest(part(own.k, i * m, m), m)
        if not size < HUGE:
            if i == 0:
                return NOT_FINITE, size
            stage_value(act, table, i, y, carry, own, h, n, m)
            moved = largest(own.increment, n)
            if not moved < HUGE:
                return OUTSIDE_CHART, moved
            generator(params, like(t + table.c[i] * h, y[0]), own.Y, own.xi, own.field_scratch)
            found = largest(own.xi, m)
            return (OUTSIDE_CHART, size) if found < HUGE else (NOT_FINITE, found)
    return OUTSIDE_CHART, largest(own.increment, n)


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
    def rkmk(generator, maps, params, coefficients, substep: int, memory, work, t, h) -> Step:
        """Let ``exp(u₁)``, ``u₁ = h Σ b_i k_i``, act on the compensated state."""
        act, inverse = maps
        table = table_of(coefficients)
        n = rows if rows > 0 else int(table.rows[0])
        d = m if m > 0 else int(table.algebra_rows[0])
        y, carry = sections(memory, compensated_state(n))
        own = parts_of(work, table, n, d)
        write_stages(generator, act, inverse, params, table, y, carry, own, t, h, 0, n, d)
        combine(table.b, own.k, h, 0.0 * y[0], own.u, d)
        act(table.layout, own.u, y, own.increment, own.scratch)
        if not largest(own.increment, n) < HUGE:
            status, size = diagnose(generator, act, params, table, y, carry, own, t, h, d)
            return status, 1, size
        for r in range(n):
            add_compensated(y, carry, r, own.increment[r])
        return OK, 1, 0.0

    return stepper(with_maps(rkmk, act, inverse))
