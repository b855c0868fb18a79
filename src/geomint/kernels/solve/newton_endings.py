"""When a step is solved by Newton's method, and the derivatives of one that is.

Residuals of stiff fields are off by h‖J‖ roundings, and the factors leave of them what they leave of
residuals: changes of L fall to that, not to a few roundings of L. How much it is depends on the forces,
how stiff, along which ways, and how sizes of pieces compare; so it is measured (`rounding`).
"""

from ..compiling.recorded import helper, inlined
from ..numbers.arithmetic import epsilon, like, magnitude, maximum, plain, top
from ..numbers.blocks import part
from .fixed_point import BEGINNING, FINE, NEWTON_ROUNDING, ROUNDINGS, finite, rounding_left, solved
from .gauss import scales_by
from .stage_equations import (
    factor_mean,
    factor_stages,
    solve_all,
    solve_mean,
    whole_size,
    write_jacobians,
    write_lack,
)
from .status import NOT_CONVERGED, OK, Step

BLIND = 2.0**-24
TURN = 0.764  # of parts in (−1, 1] that do not repeat from row to row


@inlined
def plain_size(x):
    """Return |x| without derivatives."""
    return abs(plain(x))


plain_scales = scales_by(plain_size)


@helper
def size_of_vector(s, rows: int):
    """Return the largest value in `vector`, over the size of its piece."""
    largest = 0.0
    for i in range(s.count):
        for r in range(rows):
            size = abs(plain(s.vector[i * rows + r])) * top(s.scales[r])
            largest = maximum(size, largest)
    return largest


@helper
def size_of_change(s, groups: int, rows: int):
    """Return the largest value in `change`, over the size of its piece."""
    worst = 0.0 * plain(s.c[0])
    for g in range(groups):
        for r in range(rows):
            worst = maximum(plain_size(s.change[g * rows + r]) * top(s.scales[r]), worst)
    return top(worst)


@inlined
def rounding(field, params, s, t, h, whole: bool, groups: int, rows: int) -> tuple[float, float]:
    """Return what rounding makes of residuals and of changes: how these answer stages off by one.

    Each number of each stage is moved by another part of a rounding, of its own and of its increment's.
    """
    write_lack(field, params, s, t, h, groups, rows)
    tiny = epsilon(s.c[0])
    for g in range(groups):
        turned = 0.0
        for i in range(g * rows, (g + 1) * rows):
            s.jacobian[i] = plain(s.F[i])
            turned = turned + TURN if turned + TURN <= 1.0 else turned + TURN - 2.0
            moved = tiny * (turned + s.c[g])
            s.Y[i] += moved * (s.Y[i] + 0.5 * s.L[i])
        field(
            params, t + s.c[g] * h, part(s.Y, g * rows, rows), part(s.F, g * rows, rows), s.scratch
        )
        for i in range(g * rows, (g + 1) * rows):
            weights = s.b[g] * h
            s.change[i] = like(weights * (plain(s.F[i]) - s.jacobian[i]), s.L[i])
    lack = size_of_change(s, groups, rows)
    if whole:
        solve_all(s, groups, rows)
    else:
        solve_mean(s, groups, rows)
    return lack, size_of_change(s, groups, rows)


@inlined
def ended(
    field, params, s, t, h, lack, change, last, before,
    tolerance, final: bool, whole: bool, groups: int, rows: int,
) -> bool:  # fmt: skip
    """Tell whether Newton's iteration has ended: by the one rule, but that rounding may be larger.

    Where `lack`, a residual over sizes, is more than `BLIND` and than rounding makes it, or where
    rounding leaves no digits of what is solved for, nothing is known, however small changes are.
    """
    known = lack <= BLIND
    stays = (change >= before) | final
    bound = NEWTON_ROUNDING
    if (not known or change > bound) and change <= FINE and (stays or change <= tolerance):
        lacks, changes = rounding(field, params, s, t, h, whole, groups, rows)
        if ROUNDINGS * changes <= FINE:
            known = known | (lack <= ROUNDINGS * lacks)
            bound = max(bound, ROUNDINGS * changes)
    left = rounding_left(change, s.c[0]) | (stays & (change <= bound))
    return known & solved(change, last, before, tolerance, left, final)


@inlined
def slopes_solved(field, jacobians, params, s, t, h, cap: int, groups: int, rows: int) -> Step:
    """Solve for the derivatives of L, which is solved for and stays as it is.

    The equations are linear: corrections fall until they are rounding, however large that is.
    """
    whole = whole_size(rows, s.count) > 0
    write_lack(field, params, s, t, h, groups, rows)
    write_jacobians(jacobians, s, t, h, groups, rows)
    if whole:
        factor_stages(s, h, groups, rows)
    else:
        factor_mean(s, h, groups, rows)
    last = BEGINNING
    for iteration in range(cap):
        if whole:
            solve_all(s, groups, rows)
        else:
            solve_mean(s, groups, rows)
        moved, size = 0.0, 0.0
        for i in range(groups * rows):
            scale = top(s.scales[i % rows])
            slopes = s.change[i] - like(plain(s.change[i]), s.change[i])
            s.L[i] -= slopes
            moved = maximum(top(magnitude(slopes)) * scale, moved)
            own = s.L[i] - like(plain(s.L[i]), s.L[i])
            size = maximum(top(magnitude(own)) * scale, size)
            y = s.y[i % rows] - like(plain(s.y[i % rows]), s.y[i % rows])
            size = maximum(top(magnitude(y)) * scale, size)
        if not finite(moved):
            return NOT_CONVERGED, iteration + 1, moved
        if moved == 0.0 or (moved >= last and moved <= FINE * size):
            return OK, iteration + 1, moved
        last = moved
        write_lack(field, params, s, t, h, groups, rows)
    return NOT_CONVERGED, cap, last
