"""Many points back to a level, each along ways of its own, by Newton's method."""

from ..compiling.bound import Bound
from ..compiling.recorded import helper
from ..compiling.signatures import FIELD, of_header
from ..numbers.blocks import part
from .small_matrices import largest
from .stage_matrices import factor_whole, padded, solve_whole

ROUNDS = 8
TINY = 1e-7  # of the ways: one-sided differences
FIRST = 1e6  # of sizes: from farther away there is no way back
HALVED = 0.1  # by that much conditions come nearer in a round, or the search is given up


def scratch_of(rows: int, conditions: int) -> tuple[int, int]:
    """Return how many numbers the scratch and the matrix of `back_along` have."""
    return 2 * rows + 3 * conditions, conditions * padded(conditions)


@helper
def write_off(values, params, wanted, sizes, conditions: int, y, work, off):
    """Write how far conditions are from holding, in their sizes; return the largest."""
    values(params, 0.0, y, off, work)
    for c in range(conditions):
        off[c] = (off[c] - wanted[c]) / sizes[c]
    return largest(conditions, off)


@helper
def back_along(
    values,
    params,
    wanted,
    sizes,
    rows: int,
    conditions: int,
    count: int,
    on: float,
    ahead,
    ways,
    work,
    scratch,
    matrix,
    a,
    found,
):
    """Write ``a`` with ``ahead − Σ a_c ways_c`` on the level, for each point, from what it is.

    Parameters
    ----------
    on : float
        Points are on the level where no condition is off by more, in its size.
    ahead, ways : block, shape (count, rows), (count, conditions, rows)
    a, found : block, shape (count, conditions), (count,)
        Changed; 1 where a point of the level was found.
    """
    here, near = part(scratch, 0, rows), part(scratch, rows, rows)
    off, there = (
        part(scratch, 2 * rows, conditions),
        part(scratch, 2 * rows + conditions, conditions),
    )
    order = part(scratch, 2 * rows + 2 * conditions, conditions)
    width = padded(conditions)
    for i in range(count):
        start, own = part(ahead, i * rows, rows), part(a, i * conditions, conditions)
        along = part(ways, i * conditions * rows, conditions * rows)
        bound = FIRST
        found[i] = 0.0
        for _ in range(ROUNDS):
            for r in range(rows):
                total = start[r]
                for c in range(conditions):
                    total -= own[c] * along[c * rows + r]
                here[r] = total
            size = write_off(values, params, wanted, sizes, conditions, here, work, off)
            if size < on:
                found[i] = 1.0
                break
            if not size < bound:
                break
            bound = HALVED * size
            for c in range(conditions):
                for r in range(rows):
                    near[r] = here[r] + TINY * along[c * rows + r]
                write_off(values, params, wanted, sizes, conditions, near, work, there)
                for k in range(conditions):
                    matrix[k * width + c] = (there[k] - off[k]) / TINY
            factor_whole(conditions, matrix, order)
            solve_whole(conditions, matrix, order, off)
            for c in range(conditions):
                own[c] += off[c]


BACK_ALONG = Bound(back_along, of_header(back_along, values=FIELD))
