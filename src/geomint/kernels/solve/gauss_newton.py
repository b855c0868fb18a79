"""Gauss stages by Newton's method, for steps whose fixed-point iteration does not contract.

Unknown are the increments L of `geomint.kernels.solve.gauss`, and what is to vanish is
``R_i = L_i − h b_i f(t + c_i h, y + Σ_j μ_ij L_j)``. There are three tries, each begun on L = 0:

- *Simplified Newton.* One Jacobian J for all stages, the mean of those at y. With
  ``B A B⁻¹ = V Λ V⁻¹``, B = diag(b), the change of L is ``V (1 − h Λ ⊗ J)⁻¹ V⁻¹ R``: complex systems
  of the size of the state, one for each stage and each in a lane of its own, factored once a step
  (J. C. Butcher, BIT 16 (1976) 237; T. A. Bickart, SIAM J. Numer. Anal. 14 (1977) 1005; Hairer,
  Wanner, Solving Ordinary Differential Equations II, IV.8). It contracts where J changes little
  along the step: stiff forces beside slow motion.
- *Newton's method* for all stages together, with the Jacobian of each, damped by the natural
  monotonicity test (P. Deuflhard, Newton Methods for Nonlinear Problems, 3.3).
- *Continuation in the step*: where that fails, from the same state steps of half the length, and from
  the increments of one that succeeds longer ones.

What is found is a solution of the same equations, to rounding, and depends on state and step alone.
Matrices are plain numbers: with derivatives beside L, theirs converge with it.
"""

from __future__ import annotations

import functools
from collections import namedtuple
from typing import Any

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import lane, like, magnitude, maximum, plain, top, total
from ..numbers.blocks import REST, as_lanes, as_numbers, part, section, sections, set_lane
from .advance import stepper
from .compensated import add_compensated
from .fixed_point import (
    BEGINNING,
    COARSE,
    NEWTON_ROUNDING,
    finite,
    no_contraction,
    rounding_left,
    solved,
)
from .gauss import (
    combine,
    eight_columns,
    gauss_coefficients,
    gauss_memory,
    gauss_step,
    increment,
    inverse_scales,
    padding,
    stage_sums,
)
from .stage_jacobians import jacobian_evaluations
from .stage_matrices import factor_lanes, factor_whole, padded, solve_lanes, solve_whole
from .status import NOT_CONVERGED, OK

__all__ = ["newton_coefficients", "newton_stepper", "newton_work", "whole_size"]

MOST_WHOLE = 1024  # unknowns of all stages together: their matrix takes 8 MB, factors 0.2 s
BLIND = 2.0**-24
LEAST_DAMPED = 2.0**-10
LEAST_PART = 2.0**-6  # of a step, in continuation
TRIES = 3  # times the cap on iterations: for all of continuation together

Numbers = namedtuple(
    "Numbers", "stages first cap patience params padding eigen_real eigen_imaginary into_real "
    "into_imaginary out_real out_imaginary"
)  # fmt: skip
Work = namedtuple(
    "Work",
    "Y F scales padding begun change real imaginary vector params jacobian matrix order scratch",
)
Stages = namedtuple(
    "Stages", "y carry L begun change real imaginary Y F scales scratch vector matrix order jacobian "
    "values jacobian_scratch params c b mu pieces numbers first count"
)  # fmt: skip


@inlined
def newton_coefficients(groups: int) -> Numbers:
    """Return the layout of what stands behind the coefficients of the fixed-point iteration.

    How many stages there are and in which lane the first is; the cap on iterations; how many numbers
    `params` has; in lanes Λ, and the columns of V⁻¹ and V, those of the imaginary part of V negative.
    """
    lanes = 8 * groups
    return Numbers(
        stages=1,
        first=1,
        cap=1,
        patience=1,
        params=1,
        padding=3,
        eigen_real=lanes,
        eigen_imaginary=lanes,
        into_real=lanes * lanes,
        into_imaginary=lanes * lanes,
        out_real=lanes * lanes,
        out_imaginary=lanes * lanes,
    )


@inlined
def whole_size(rows: int, stages: int) -> int:
    """Return the number of unknowns of all stages together, 0 where they are too many."""
    size = rows * stages
    return size if size <= MOST_WHOLE else 0


@inlined
def newton_work(rows: int, groups: int, stages: int, params: int, scratch: int) -> Work:
    """Return the layout of scratch, in numbers; `scratch` for the field, and for its Jacobian."""
    size, whole = 8 * groups * rows, whole_size(rows, stages)
    return Work(
        Y=size,
        F=size,
        scales=rows,
        padding=padding(rows),
        begun=size,
        change=size,
        real=size,
        imaginary=size,
        vector=padded(max(whole, rows)),
        params=padded(params),
        jacobian=size * rows,
        matrix=max(2 * size * rows, whole * padded(whole)),
        order=padded(max(whole, rows)),
        scratch=scratch,
    )


@inlined
def stages_of(coefficients: Any, memory: Any, work: Any, groups: int, rows: int) -> Any:
    """Return all that Newton's iteration reads and writes, by name."""
    given = sections(coefficients, gauss_coefficients(rows, groups, REST))
    layout = newton_coefficients(groups)
    behind = part(coefficients, len(coefficients) - sum(layout), sum(layout))
    numbers = sections(behind, layout)
    count, first = int(numbers.stages[0]), int(numbers.first[0])
    y, carry, _, increments = sections(memory, gauss_memory(rows, groups))
    own = sections(work, newton_work(rows, groups, count, int(numbers.params[0]), REST))
    size = rows * groups
    free = as_numbers(own.scratch)
    return Stages(
        y=y,
        carry=carry,
        L=as_lanes(increments, 0, size),
        begun=as_lanes(own.begun, 0, size),
        change=as_lanes(own.change, 0, size),
        real=as_lanes(own.real, 0, size),
        imaginary=as_lanes(own.imaginary, 0, size),
        Y=as_lanes(own.Y, 0, size),
        F=as_lanes(own.F, 0, size),
        scales=own.scales,
        scratch=as_lanes(own.scratch, 0, len(own.scratch) // 8),
        vector=own.vector,
        matrix=as_numbers(own.matrix),
        order=as_numbers(own.order),
        jacobian=as_lanes(as_numbers(own.jacobian), 0, size * rows),
        values=as_lanes(as_numbers(own.real), 0, size),
        jacobian_scratch=as_lanes(free, 0, len(own.scratch) // 8),
        params=part(as_numbers(own.params), 0, int(numbers.params[0])),
        c=as_lanes(given.c, 0, groups),
        b=as_lanes(given.b, 0, groups),
        mu=as_lanes(given.mu, 0, 8 * groups * groups),
        pieces=given.pieces,
        numbers=numbers,
        first=first,
        count=count,
    )


@inlined
def write_lack(field: Any, params: Any, s: Any, t: float, h: float, groups: int, rows: int) -> None:
    """Write R into `change`, and the stages into Y."""
    stage_sums(eight_columns(s.mu, 0, 0, groups), s.mu, s.L, s.y, s.carry, s.Y, groups, rows)
    for g in range(groups):
        field(
            params, t + s.c[g] * h, part(s.Y, g * rows, rows), part(s.F, g * rows, rows), s.scratch
        )
    for g in range(groups):
        weights = s.b[g] * h
        for r in range(g * rows, (g + 1) * rows):
            s.change[r] = s.L[r] - weights * s.F[r]


@inlined
def write_jacobians(jacobians: Any, s: Any, t: float, h: float, groups: int, rows: int) -> None:
    """Write the Jacobian at each stage Y."""
    for i in range(groups * rows):
        s.values[i] = plain(s.Y[i])
    for g in range(groups):
        out = part(s.jacobian, g * rows * rows, rows * rows)
        own = part(s.values, g * rows, rows)
        jacobians(s.params, t + s.c[g] * h, own, out, s.jacobian_scratch)


@helper
def transform(columns: Any, source: Any, target: Any, more: bool, groups: int, rows: int) -> None:
    """Write, or add, ``Σ_j columns_ij source_j`` for all stages."""
    for own in range(groups):
        for other in range(groups):
            n = eight_columns(columns, other, own, groups)
            for r in range(rows):
                known = source[other * rows + r]
                start = target[own * rows + r] if more or other > 0 else like(0.0, known)
                target[own * rows + r] = combine(n, known, start)


@helper
def factor_mean(s: Any, h: float, groups: int, rows: int) -> None:
    """Factor ``1 − h Λ ⊗ J``, J the mean of the Jacobians at the stages."""
    size = rows * rows
    real = as_lanes(s.numbers.eigen_real, 0, groups)
    imaginary = as_lanes(s.numbers.eigen_imaginary, 0, groups)
    for g in range(groups):
        p = as_lanes(s.matrix, 16 * g * size, size)
        q = as_lanes(s.matrix, 16 * g * size + 8 * size, size)
        u, v = h * real[g], h * imaginary[g]
        for e in range(size):
            mean = total(s.b[0] * s.jacobian[e])
            for other in range(1, groups):
                mean += total(s.b[other] * s.jacobian[other * size + e])
            p[e] = (1.0 if e % (rows + 1) == 0 else 0.0) - u * mean
            q[e] = -(v * mean)
        factor_lanes(rows, p, q, part(s.order, g * rows, rows))


@helper
def solve_mean(s: Any, groups: int, rows: int) -> None:
    """Replace R in `change` by the change of L that the factors of `factor_mean` give."""
    n, size, columns = s.numbers, rows * rows, 8 * groups * groups
    transform(as_lanes(n.into_real, 0, columns), s.change, s.real, False, groups, rows)
    transform(as_lanes(n.into_imaginary, 0, columns), s.change, s.imaginary, False, groups, rows)
    for g in range(groups):
        p = as_lanes(s.matrix, 16 * g * size, size)
        q = as_lanes(s.matrix, 16 * g * size + 8 * size, size)
        x, y = part(s.real, g * rows, rows), part(s.imaginary, g * rows, rows)
        solve_lanes(rows, p, q, part(s.order, g * rows, rows), x, y)
    transform(as_lanes(n.out_real, 0, columns), s.real, s.change, False, groups, rows)
    transform(as_lanes(n.out_imaginary, 0, columns), s.imaginary, s.change, True, groups, rows)


@helper
def factor_stages(s: Any, h: float, groups: int, rows: int) -> None:
    """Factor the derivative of R by L, with the Jacobian of each stage."""
    n = s.count * rows
    width, lanes = padded(n), 8 * groups
    b, mu, J = as_numbers(s.b), as_numbers(s.mu), as_numbers(s.jacobian)
    for i in range(s.count):
        at = s.first + i
        own = (at // 8) * rows * rows
        for r in range(rows):
            row = (i * rows + r) * width
            for j in range(s.count):
                weight = h * b[at] * mu[(s.first + j) * lanes + at]
                for k in range(rows):
                    unit = 1.0 if i == j and r == k else 0.0
                    slope = J[8 * (own + r * rows + k) + at % 8]
                    s.matrix[row + j * rows + k] = unit - weight * slope
            for k in range(n, width):
                s.matrix[row + k] = 0.0
    factor_whole(n, s.matrix, s.order)


@helper
def solve_stages(s: Any, rows: int) -> None:
    """Write into `vector` what the factors of `factor_stages` make of R."""
    for i in range(s.count):
        at = s.first + i
        for r in range(rows):
            s.vector[i * rows + r] = lane(s.change[(at // 8) * rows + r], at % 8)
    solve_whole(s.count * rows, s.matrix, s.order, s.vector)


@helper
def size_of_vector(s: Any, rows: int) -> float:
    """Return the largest value in `vector`, over the size of its piece."""
    largest = 0.0
    for i in range(s.count):
        for r in range(rows):
            size = abs(plain(s.vector[i * rows + r])) * top(s.scales[r])
            largest = maximum(size, largest)
    return largest


@helper
def size_of_change(s: Any, groups: int, rows: int) -> float:
    """Return the largest number in `change`, slopes among them, over the size of its piece."""
    worst = 0.0 * plain(s.c[0])
    for g in range(groups):
        for r in range(rows):
            worst = maximum(magnitude(s.change[g * rows + r]) * top(s.scales[r]), worst)
    return top(worst)


@inlined
def ended(
    s: Any, lack: float, change: float, last: float, before: float, tolerance: float, final: bool
) -> bool:
    """Tell whether Newton's iteration has ended: by the one rule, but that rounding may be larger.

    Residuals of stiff fields are rounded to h‖J‖ roundings, of which the factors leave some. Where
    `lack`, a residual over sizes, is more than `BLIND`, nothing is known, however small changes are.
    """
    stays = (change <= NEWTON_ROUNDING) & ((change >= before) | final)
    rounding = rounding_left(change, s.c[0]) | stays
    return (lack <= BLIND) & solved(change, last, before, tolerance, rounding, final)


@inlined
def simplified(
    field: Any, jacobians: Any, params: Any, s: Any, t: float, h: float, tolerance: float,
    groups: int, rows: int,
) -> tuple[int, int, float]:  # fmt: skip
    """Solve for L with one Jacobian."""
    cap, patience = int(s.numbers.cap[0]), int(s.numbers.patience[0])
    for i in range(groups * rows):
        s.L[i] = like(0.0, s.L[i])
    write_lack(field, params, s, t, h, groups, rows)
    write_jacobians(jacobians, s, t, h, groups, rows)
    factor_mean(s, h, groups, rows)
    last = before = BEGINNING
    for iteration in range(cap):
        lack = size_of_change(s, groups, rows)
        solve_mean(s, groups, rows)
        for i in range(groups * rows):
            s.L[i] = s.L[i] - s.change[i]
        if not last <= COARSE:
            inverse_scales(s.pieces, s.y, s.L, groups, s.scales)
        delta = size_of_change(s, groups, rows)
        if not finite(delta) or no_contraction(iteration, patience, delta):
            return NOT_CONVERGED, iteration + 1, delta
        if ended(s, lack, delta, last, before, tolerance, iteration + 1 == cap):
            return OK, iteration + 1, delta
        before, last = last, delta
        write_lack(field, params, s, t, h, groups, rows)
    return NOT_CONVERGED, cap, last


@inlined
def damped(
    field: Any, jacobians: Any, params: Any, s: Any, t: float, h: float, tolerance: float,
    groups: int, rows: int,
) -> tuple[int, int, float]:  # fmt: skip
    """Solve for L from where it is, with the Jacobian of each stage."""
    cap = int(s.numbers.cap[0])
    kept, step = s.real, s.imaginary
    last = before = BEGINNING
    write_lack(field, params, s, t, h, groups, rows)
    for iteration in range(cap):
        write_jacobians(jacobians, s, t, h, groups, rows)
        lack = size_of_change(s, groups, rows)
        factor_stages(s, h, groups, rows)
        solve_stages(s, rows)
        for i in range(groups * rows):
            kept[i] = s.L[i]
            s.change[i] = like(0.0, s.L[i])
        for i in range(s.count):
            at = s.first + i
            for r in range(rows):
                set_lane(s.change, (at // 8) * rows + r, at % 8, s.vector[i * rows + r])
        for i in range(groups * rows):
            step[i] = s.change[i]
            s.L[i] = kept[i] - step[i]
        inverse_scales(s.pieces, s.y, s.L, groups, s.scales)
        delta, size = size_of_change(s, groups, rows), size_of_vector(s, rows)
        if not finite(delta):
            return NOT_CONVERGED, iteration + 1, delta
        if ended(s, lack, delta, last, before, tolerance, iteration + 1 == cap):
            return OK, iteration + 1, delta
        before, last = last, delta
        damping = 1.0
        write_lack(field, params, s, t, h, groups, rows)
        while size > COARSE:
            solve_stages(s, rows)
            if size_of_vector(s, rows) <= (1.0 - 0.25 * damping) * size:
                break
            damping *= 0.5
            if damping < LEAST_DAMPED:
                return NOT_CONVERGED, iteration + 1, delta
            for i in range(groups * rows):
                s.L[i] = kept[i] - damping * step[i]
            write_lack(field, params, s, t, h, groups, rows)
    return NOT_CONVERGED, cap, last


@inlined
def continued(
    field: Any, jacobians: Any, params: Any, s: Any, t: float, h: float, tolerance: float,
    groups: int, rows: int,
) -> tuple[int, int, float]:  # fmt: skip
    """Solve for L from 0, or from the increments of a shorter step, as long as need be."""
    most = TRIES * int(s.numbers.cap[0])
    for i in range(groups * rows):
        s.begun[i] = like(0.0, s.L[i])
    reached, length, used, left = 0.0, 1.0, 0, BEGINNING
    while used < most and length >= LEAST_PART:
        end = min(1.0, reached + length)
        longer = end / reached if reached > 0.0 else 0.0
        for i in range(groups * rows):
            s.L[i] = longer * s.begun[i]
        status, iterations, left = damped(
            field, jacobians, params, s, t, end * h, tolerance, groups, rows
        )
        used += iterations
        if status != OK:
            length *= 0.5
        elif end == 1.0:
            return OK, used, left
        else:
            for i in range(groups * rows):
                s.begun[i] = s.L[i]
            reached = end
            length *= 2.0
    return NOT_CONVERGED, used, left


@inlined
def newton_step(
    functions: Any, params: Any, coefficients: Any, substep: int, memory: Any, work: Any,
    t: float, h: float, groups: int, rows: int,
) -> tuple[int, int, float]:  # fmt: skip
    """Take the step of the fixed-point iteration where it contracts, and else by Newton's method.

    Jacobians count as so many iterations as they take evaluations of the field.
    """
    field, jacobians = functions
    status, used, left = gauss_step(
        (field,), params, coefficients, substep, memory, work, t, h, groups, rows
    )
    if status != NOT_CONVERGED:
        return status, used, left
    s = stages_of(coefficients, memory, work, groups, rows)
    tolerance = top(section(coefficients, gauss_coefficients(rows, groups, REST), "tolerance")[0])
    for i in range(len(s.params)):
        s.params[i] = plain(params[i])
    status, more, left = simplified(field, jacobians, params, s, t, h, tolerance, groups, rows)
    used += more + jacobian_evaluations(rows)
    if status != OK and whole_size(rows, s.count) > 0:
        status, more, left = continued(field, jacobians, params, s, t, h, tolerance, groups, rows)
        used += more * (1 + jacobian_evaluations(rows))
    if status == OK:
        for r in range(rows):
            add_compensated(s.y, s.carry, r, increment(s.L, r, groups, rows))
    return status, used, left


@functools.cache
def newton_stepper(groups: int) -> Recorded:
    """Return the stepper for 8 · `groups` stages and any number of rows.

    It takes a field, and its Jacobians (`geomint.kernels.solve.stage_jacobians`).
    """

    @helper
    def gauss_newton(functions, params, coefficients, substep, memory, work, t, h):
        header = gauss_coefficients(0, groups, REST)
        n = int(top(section(coefficients, header, "rows")[0]))
        return newton_step(functions, params, coefficients, substep, memory, work, t, h, groups, n)

    return stepper(gauss_newton)
