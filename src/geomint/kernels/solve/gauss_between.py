"""Between the ends of a Gauss step: its collocation polynomial, and other steps begun on it.

The L_j of a step of length h are ``h b_j f(Y_j)``, as `geomint.kernels.solve.gauss` leaves them in
memory. At θ h the polynomial is ``y + Σ_k θ^(k+1) Σ_j S^(k)_j L_j``, and the step of length θ h from
the same state begins with ``L_i(θ) = θ Σ_k θ^k Σ_j M^(k)_ij L_j``, where S^(k) are the sums over the
columns of M^(k). Tables have the M^(k), the highest power first, in lanes and columns, and then the
S^(k), the lowest first.

Where the increments of the step before are known too, interpolation through the derivatives at the
nodes of both tells what the step has added with nearly twice the order, and the difference to the
collocation polynomial how far that is known.
"""

import functools

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import fma, top
from ..numbers.blocks import REST, as_lanes, part, section
from .gauss import combine, eight_columns, folded, gauss_coefficients, gauss_memory


@inlined
def powers_of(table, groups: int) -> int:
    """Return the number of stages that a table was made for."""
    return int(len(table) // (8 * groups * (8 * groups + 1)))


@functools.cache
def gauss_between(groups: int) -> Recorded:
    """Return ``between(coefficients, table, theta)``, which makes the predictor M(θ)."""

    @helper
    def between(coefficients, table, theta: float):
        columns = 8 * groups * groups
        rows = int(top(section(coefficients, gauss_coefficients(0, groups, REST), "rows")[0]))
        numbers = gauss_coefficients(rows, groups, REST)
        predictor = as_lanes(section(coefficients, numbers, "predictors"), 0, columns)
        powers = powers_of(table, groups)
        M = as_lanes(table, 0, powers * columns)
        for j in range(columns):
            total = M[j]
            for k in range(1, powers):
                total = fma(total, theta, M[k * columns + j])
            predictor[j] = theta * total

    return between


@functools.cache
def gauss_polynomial(groups: int) -> Recorded:
    """Return ``polynomial(memory, table, rows, out)``: coefficients of θ, θ², …, row after row."""

    @helper
    def polynomial(memory, table, rows: int, out):
        powers = powers_of(table, groups)
        stages = as_lanes(section(memory, gauss_memory(rows, groups), "stages"), 0, rows * groups)
        sums = part(table, 64 * powers * groups * groups, 8 * powers * groups)
        S = as_lanes(sums, 0, powers * groups)
        for r in range(rows):
            for k in range(powers):
                terms = S[k * groups] * stages[r]
                for g in range(1, groups):
                    terms += S[k * groups + g] * stages[g * rows + r]
                p0, p1, p2, p3 = folded(terms, terms)
                out[r * powers + k] = (p0 + p3) + (p1 + p2)

    return polynomial


@functools.cache
def gauss_inside(groups: int) -> Recorded:
    """Return ``inside(memory, before, table, rows, first, count, out)``.

    It writes for each of `count` rows from `first` on what the step has added at ⅛, ¼, … 1 of it, by
    interpolation and by the collocation polynomial, eight numbers each. `memory` and `before` are
    those after the step and after the one before; the table has A, B and U
    (`geomint.tableaux.GaussTableau.inside`) in columns, with a lane for each place.
    """

    @helper
    def inside(memory, before, table, rows: int, first: int, count: int, out):
        columns = as_lanes(table, 0, 24 * groups)
        layout = gauss_memory(rows, groups)
        stages = as_lanes(section(memory, layout, "stages"), 0, rows * groups)
        past = as_lanes(section(before, layout, "stages"), 0, rows * groups)
        values = as_lanes(out, 0, 2 * count)
        for r in range(first, first + count):
            better = 0.0 * columns[0]
            plain = better
            for g in range(groups):
                own, other = stages[g * rows + r], past[g * rows + r]
                better = combine(eight_columns(columns, g, 0, 1), own, better)
                better = combine(eight_columns(columns, groups + g, 0, 1), other, better)
                plain = combine(eight_columns(columns, 2 * groups + g, 0, 1), own, plain)
            values[2 * (r - first)] = better
            values[2 * (r - first) + 1] = plain

    return inside
