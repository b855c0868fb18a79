"""Gauss stages by Newton's method, for steps whose fixed-point iteration does not contract.

The equations are those of `geomint.kernels.solve.stage_equations`. There are three tries, each begun
on L = 0:

- *Simplified Newton*, with one Jacobian, factored once a step. It contracts where J changes little
  along the step: stiff forces beside slow motion.
- *Newton's method* for all stages together, with the Jacobian of each, damped by the natural
  monotonicity test (P. Deuflhard, Newton Methods for Nonlinear Problems, 3.3).
- *Continuation in the step*: where that fails, from the same state steps of half the length, and from
  the increments of one that succeeds longer ones.

What is found is a solution of the same equations, to rounding, and depends on state and step alone.
With derivatives beside L, the tries take L alone into account, so that its bits are those it has
without; the derivatives are solved for afterwards, alike for directions of any length.
"""

import functools

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import like, maximum, plain, slope_count, top
from ..numbers.blocks import REST, as_lanes, section, sections
from .advance import stepper
from .compensated import add_compensated
from .fixed_point import BEGINNING, COARSE, finite, no_contraction
from .gauss import eight_columns, gauss_coefficients, gauss_step, increment, stage_sums
from .newton_endings import ended, plain_scales, size_of_change, size_of_vector, slopes_solved
from .stage_equations import (
    factor_mean,
    factor_stages,
    solve_all,
    solve_mean,
    solve_stages,
    stages_of,
    whole_size,
    write_jacobians,
    write_lack,
)
from .stage_jacobians import jacobian_evaluations
from .status import NOT_CONVERGED, OK, Step

LEAST_DAMPED = 2.0**-10
LEAST_PART = 2.0**-6  # of a step, in continuation
TRIES = 3  # times the cap on iterations: for all of continuation together


@inlined
def simplified(field, jacobians, params, s, t, h, tolerance, groups: int, rows: int) -> Step:
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
            s.L[i] -= s.change[i]
        if not last <= COARSE:
            plain_scales(s.pieces, s.y, s.L, groups, s.scales)
        delta = size_of_change(s, groups, rows)
        if not finite(delta) or no_contraction(iteration, patience, delta):
            return NOT_CONVERGED, iteration + 1, delta
        final = iteration + 1 == cap
        if ended(
            field, params, s, t, h, lack, delta, last, before, tolerance, final, False, groups, rows
        ):
            return OK, iteration + 1, delta
        before, last = last, delta
        write_lack(field, params, s, t, h, groups, rows)
    return NOT_CONVERGED, cap, last


@inlined
def damped(field, jacobians, params, s, t, h, tolerance, groups: int, rows: int) -> Step:
    """Solve for L from where it is, with the Jacobian of each stage."""
    cap = int(s.numbers.cap[0])
    kept, step = s.real, s.imaginary
    last = before = BEGINNING
    write_lack(field, params, s, t, h, groups, rows)
    for iteration in range(cap):
        write_jacobians(jacobians, s, t, h, groups, rows)
        lack = size_of_change(s, groups, rows)
        factor_stages(s, h, groups, rows)
        solve_all(s, groups, rows)
        for i in range(groups * rows):
            kept[i] = s.L[i]
            step[i] = s.change[i]
            s.L[i] = kept[i] - step[i]
        plain_scales(s.pieces, s.y, s.L, groups, s.scales)
        delta, size = size_of_change(s, groups, rows), size_of_vector(s, rows)
        if not finite(delta):
            return NOT_CONVERGED, iteration + 1, delta
        final = iteration + 1 == cap
        if ended(
            field, params, s, t, h, lack, delta, last, before, tolerance, final, True, groups, rows
        ):
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
def continued(field, jacobians, params, s, t, h, tolerance, groups: int, rows: int) -> Step:
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


@helper
def roughness(coefficients, substep: int, s, groups: int, rows: int):
    """Return how large what the step extrapolates to is, over the sizes of pieces."""
    columns = 8 * groups * groups
    given = sections(coefficients, gauss_coefficients(rows, groups, REST))
    predictor = as_lanes(given.predictors, 8 * columns * substep, columns)
    m = eight_columns(predictor, 0, 0, groups)
    stage_sums(m, predictor, s.L, s.y, s.carry, s.change, groups, rows)
    return size_of_change(s, groups, rows)


@inlined
def newton_step(
    functions, params, coefficients, substep: int, memory, work, t, h, groups: int,
    rows: int,
) -> Step:  # fmt: skip
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
    if status == OK and slope_count(s.L[0]) > 0:
        cap = int(s.numbers.cap[0])
        status, more, left = slopes_solved(field, jacobians, params, s, t, h, cap, groups, rows)
        used += more + jacobian_evaluations(rows)
    if status == OK:
        rough = roughness(coefficients, substep, s, groups, rows)
        for r in range(rows):
            add_compensated(s.y, s.carry, r, increment(s.L, r, groups, rows))
        return status, used, maximum(1.0, rough)
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

    return stepper(gauss_newton, ranked=True)
