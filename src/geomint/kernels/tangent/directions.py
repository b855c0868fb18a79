"""Directions carried along by one step, and made orthonormal again.

A step is taken in tangent numbers, some directions at once; what a method remembers of it, such as the
stages that the next iteration begins with, is turned with the directions.
"""

from ..compiling.recorded import helper, inlined
from ..numbers.arithmetic import fma, total
from ..numbers.blocks import as_lanes, part
from ..solve.status import OK, Steps
from .layout import Kept, Sizes, Work, lanes_for
from .near_identity import log_volume
from .normals import enlarge_scales, write_normals
from .products import add_product, write_overlaps

EIGHT = 8


@helper
def begin_at(s: Sizes, state, plain):
    """Let the next step begin at a state, without what was carried of its sums."""
    size = 1 + s.at_once
    for first in range(0, s.d, s.at_once):
        here = first // s.at_once * s.memory_rows
        for r in range(s.rows):
            plain[(here + r) * size] = state[r]
            plain[(here + s.rows + r) * size] = 0.0


@helper
def gather(s: Sizes, plain):
    """Let all groups of directions be where the first is.

    Iterations that see other slopes end in other roundings, which chaos would make as large as the
    motion: directions would be those of several motions.
    """
    size = 1 + s.at_once
    for first in range(s.at_once, s.d, s.at_once):
        here = first // s.at_once * s.memory_rows
        for r in range(2 * s.rows):
            plain[(here + r) * size] = plain[r * size]


@helper
def carry(
    method, t0: float, h: float, before: int, steps: int, s: Sizes, kept: Kept, numbers, plain,
    scratch, D,
) -> Steps:  # fmt: skip
    """Write what some steps add to each direction; return what the stepper returns.

    `method` is what takes a step: (kernel, functions, params, coefficients, fractions). `plain` are
    the numbers that `numbers`, its memory, is made of. After a failure nothing is remembered.
    """
    kernel, functions, params, coefficients, fractions = method
    scales, basis = kept.scales, kept.basis
    size, width = 1 + s.at_once, lanes_for(s.d)
    status, done, iterations, residual = OK, steps, 0, 0.0
    for first in range(0, s.d, s.at_once):
        here = first // s.at_once * s.memory_rows
        count = min(s.at_once, s.d - first)
        written = s.n if count == s.at_once else 0  # rows that are written whole below
        for r in range(written, 2 * s.rows):
            for k in range(s.at_once):
                plain[(here + r) * size + 1 + k] = 0.0
        for r in range(s.n):
            write_scaled(basis, r * width + first, scales[r], count, plain, (here + r) * size + 1)
        memory = part(numbers, here, s.memory_rows)
        found = kernel(
            functions, params, coefficients, fractions, memory, scratch, s.rows, t0, h, before,
            steps, before + steps + 1, memory, part(fractions, 0, 0),
        )  # fmt: skip
        iterations = max(iterations, found[2])
        if found[0] != OK and status == OK:
            status, done, iterations, residual = found
        for r in range(s.n):
            at, rest = (here + r) * size + 1, (here + r + s.rows) * size + 1
            write_added(basis, r * width + first, scales[r], count, plain, at, rest, D)
    if status != OK:
        for i in range(len(plain)):
            plain[i] = 0.0
    return status, done, iterations, residual


@inlined
def write_scaled(basis, at: int, scale, count: int, plain, to: int):
    """Write directions of a row in units of the state; eight at once if there are as many."""
    if count == EIGHT:
        as_lanes(plain, to, 1)[0] = scale * as_lanes(basis, at, 1)[0]
    else:
        for k in range(count):
            plain[to + k] = scale * basis[at + k]


@inlined
def write_added(basis, at: int, scale, count: int, plain, new: int, rest: int, D):
    """Write what a step has added to directions of a row: state and carry, less what was there."""
    by = 1.0 / scale
    if count == EIGHT:
        added = as_lanes(plain, new, 1)[0] - scale * as_lanes(basis, at, 1)[0]
        as_lanes(D, at, 1)[0] = (added + as_lanes(plain, rest, 1)[0]) * by
    else:
        for k in range(count):
            D[at + k] = ((plain[new + k] - scale * basis[at + k]) + plain[rest + k]) * by


@helper
def add_tables(x, factor, y, out):
    """Write ``x + factor y``."""
    rows, others = as_lanes(x, 0, len(x) // 8), as_lanes(y, 0, len(x) // 8)
    sums = as_lanes(out, 0, len(x) // 8)
    for i in range(len(rows)):
        sums[i] = fma(factor, others[i], rows[i])


@helper
def squares(x):
    """Return the sum of the squares of a table."""
    rows = as_lanes(x, 0, len(x) // 8)
    even, odd = 0.0 * rows[0], 0.0 * rows[0]
    for i in range(len(rows) // 2):
        even, odd = fma(rows[2 * i], rows[2 * i], even), fma(rows[2 * i + 1], rows[2 * i + 1], odd)
    if len(rows) % 2 == 1:
        even = fma(rows[len(rows) - 1], rows[len(rows) - 1], even)
    return total(even + odd)


@helper
def project(s: Sizes, kept: Kept, work: Work):
    """Take from what is added to directions the part that leads away from the manifold."""
    add_tables(kept.basis, 1.0, work.D, work.X)
    write_overlaps(s.n, kept.normals, work.X, work.along)
    rows = as_lanes(work.along, 0, len(work.along) // 8)
    for i in range(len(rows)):
        rows[i] = -rows[i]
    add_product(s.n, kept.normals, work.along, work.D)


@helper
def stretched(s: Sizes, kept: Kept, work: Work):
    """Write ``S = XᵀX − 1`` of X = Q + D, as ``QᵀQ − 1 + MᵀD + DᵀM`` with M = Q + ½ D.

    Returns ``½ log det QᵀQ``: what rounding has left of the last step there, which is in S too.
    """
    width = lanes_for(s.d)
    add_tables(kept.basis, 0.5, work.D, work.X)
    write_overlaps(s.n, kept.basis, kept.basis, work.S)
    write_overlaps(s.n, work.X, work.D, work.lower)
    trace = 0.0
    for k in range(s.d):
        work.S[k * width + k] -= 1.0
        trace += work.S[k * width + k]
    before = 0.5 * trace - 0.25 * squares(work.S)
    for i in range(s.d):
        for j in range(s.d):
            change = work.lower[i * width + j] + work.lower[j * width + i]
            work.S[i * width + j] += change
    return before


@helper
def log_stretch(s: Sizes, kept: Kept, work: Work) -> tuple[float, float]:
    """Return ``½ log det XᵀX − ½ log det QᵀQ`` of X = Q + D, and ‖D‖²; go on with ``X R⁻¹``."""
    if s.m > 0:
        project(s, kept, work)
    size = squares(work.D)
    before = stretched(s, kept, work)
    volume = log_volume(s.d, work.S, work.lower, work.upper)
    add_tables(kept.basis, 1.0, work.D, work.X)
    rows = as_lanes(kept.basis, 0, len(kept.basis) // 8)
    for i in range(len(rows)):
        rows[i] *= 0.0
    add_product(s.n, work.X, work.upper, kept.basis)
    return volume - before, size


@helper
def settle(
    layout, manifold, params, t: float, ahead, s: Sizes, kept: Kept, work: Work, numbers, plain
) -> bool:
    """Take units that fit the next state, and orthonormal directions in them; tell if they are others.

    Where nothing has begun yet, directions are made orthonormal as well.
    """
    begins, grown, other = kept.begun[0] == 0.0, True, False
    while grown:
        grown = enlarge_scales(layout, ahead, kept, lanes_for(s.d))
        if begins or grown:
            write_normals(manifold, params, t, kept.state, s, kept, work, numbers, plain)
            for i in range(len(work.D)):
                work.D[i] = 0.0
            log_stretch(s, kept, work)
            begins, other = False, True
    kept.begun[0] = 1.0
    return other


@helper
def turn_stages(s: Sizes, upper, plain):
    """Turn what is remembered of stages as the directions are: the next iteration begins with it.

    In lanes there is a value, and then as many slopes; each is a sum of those up to it.
    """
    width = lanes_for(s.d)
    for first in range(0, s.d, s.at_once):
        here, count = first // s.at_once * s.memory_rows, min(s.at_once, s.d - first)
        for row in range(s.stages, s.memory_rows, EIGHT):
            slopes = as_lanes(plain, (here + row) * (1 + s.at_once) + EIGHT, count)
            for behind in range(count):
                c = count - 1 - behind
                turned = upper[(first + c) * width + first + c] * slopes[c]
                for k in range(c):
                    turned = fma(upper[(first + k) * width + first + c], slopes[k], turned)
                slopes[c] = turned
