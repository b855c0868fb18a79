"""Units of the pieces of a state, and normals of {c(y) = 0}."""

from ..compiling.number_types import tangent
from ..compiling.recorded import helper
from ..numbers.arithmetic import like
from ..numbers.blocks import as_lanes, part
from .layout import Kept, Sizes, Work, lanes_for, pieces_of
from .near_identity import log_volume, small
from .products import add_product, write_overlaps

CONDITIONS = tangent(8)  # the numbers that conditions take

GROWN = 4.0  # times its unit: what is larger than that has a larger unit
EIGHT = 8
PASSES = 4  # of which one or two are enough for gradients that are not dependent


@helper
def enlarge_scales(layout, y, kept: Kept, width: int) -> bool:
    """Double the unit of each piece that has outgrown it, once, and halve its rows of directions.

    Returns whether one did.
    """
    scales, basis, pieces = kept.scales, kept.basis, pieces_of(layout)
    n = len(scales)
    grown = False
    r = 0
    while r < n:
        end = r
        largest = 0.0
        while end < n and pieces[end] == pieces[r]:
            largest = max(largest, abs(y[end]))
            end += 1
        if GROWN * scales[r] < largest and scales[r] < 1e300:
            for i in range(r, end):
                scales[i] *= 2.0
                for c in range(width):
                    basis[i * width + c] *= 0.5
            grown = True
        r = end
    return grown


@helper
def write_gradients(manifold, params, t, y, s: Sizes, kept: Kept, C, numbers, plain):
    """Write the gradients of the conditions, a column each, in units of pieces and conditions."""
    state, values = part(numbers, 0, s.n), part(numbers, s.n, s.m)
    scratch = part(numbers, s.n + s.m, s.scratch)
    scales, sizes, width = kept.scales, kept.condition_scales, lanes_for(s.m)
    for r in range(s.n):
        plain[9 * r] = y[r]  # slopes are 0 as they were left
    for first in range(0, s.n, EIGHT):
        count = min(EIGHT, s.n - first)
        for k in range(count):
            plain[9 * (first + k) + 1 + k] = scales[first + k]
        manifold(params, like(t, state[0]), state, values, scratch)
        for k in range(count):
            plain[9 * (first + k) + 1 + k] = 0.0
            for a in range(s.m):
                C[(first + k) * width + a] = plain[9 * (s.n + a) + 1 + k] * sizes[a]


@helper
def write_normals(
    manifold, params, t: float, y, s: Sizes, kept: Kept, work: Work, numbers, plain
) -> float:
    """Write unit normals at y, a column each; return ``½ log det(C Cᵀ)`` with C = Dc.

    C is in units of the pieces and of the conditions; these are the gradients where a run begins. By
    Cholesky's factors, again where gradients are far from orthonormal; NaN for dependent conditions.
    """
    width = lanes_for(s.m)
    volume = 0.0
    if s.m > 0:
        write_gradients(manifold, params, t, y, s, kept, work.C, numbers, plain)
        normals = as_lanes(kept.normals, 0, len(kept.normals) // 8)
        rows = as_lanes(work.C, 0, len(work.C) // 8)
        again = True
        for _ in range(PASSES):
            if not again:
                break
            write_overlaps(s.n, work.C, work.C, work.S)
            for a in range(s.m):
                work.S[a * width + a] -= 1.0
            again = not small(s.m, work.S)
            volume += log_volume(s.m, work.S, work.lower, work.upper)
            for i in range(len(rows)):
                normals[i] = 0.0 * rows[i]
            add_product(s.n, work.C, work.upper, kept.normals)
            for i in range(len(rows) if again else 0):
                rows[i] = normals[i]
    return volume
