"""Eight steps with directions of their own, in lanes: what is known of their ends, what they add."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

from ..compiling.recorded import helper, inlined
from ..numbers.arithmetic import delayed, like, log
from ..numbers.blocks import as_lanes, as_singles, part, sections
from ..numbers.lanes import LANES
from ..solve.status import OK
from .householder import reflect_by, write_reflections
from .layout import Kept, Sizes, lanes_for
from .normals import enlarge_scales
from .supports import Supports

__all__ = [
    "LaneWork",
    "carry_lanes",
    "lane_work_layout",
    "load_steps",
    "parts_at",
    "shift",
    "write_known",
    "write_tangents",
]

# Rows of eight numbers: times and lengths; states where steps begin and end; units; what is known of
# these states, and was of the ends of eight steps before; directions, what steps add to them, scratch;
# a matrix; stretches and squares; scratch of the density.
LaneWork = namedtuple(
    "LaneWork", "times begin end scales at_begin at_end last basis D X S found scratch"
)
# Of a state: gradients of conditions, as reflections, with a factor each; log μ − ½ log det(C Cᵀ).
At = namedtuple("At", "C by volume")


@inlined
def lane_work_layout(s: Sizes) -> LaneWork:
    """Return the layout of scratch."""
    return LaneWork(
        times=2,
        begin=s.rows,
        end=s.rows,
        scales=s.n,
        at_begin=(s.n + 1) * s.m + 1,
        at_end=(s.n + 1) * s.m + 1,
        last=(s.n + 1) * s.m + 1,
        basis=s.n * s.d,
        D=s.n * s.d,
        X=s.n * s.d,
        S=s.d * s.d,
        found=2,
        scratch=s.scratch,
    )


@inlined
def parts_at(s: Sizes, known: Any) -> At:
    """Return the parts of what is known of eight states."""
    return sections(known, At(C=s.n * s.m, by=s.m, volume=1))


@helper
def load_steps(
    layout: Any, s: Sizes, kept: Kept, own: LaneWork, starts: Any, lengths: Any, states: Any,
    group: int, here: int,
) -> bool:  # fmt: skip
    """Write steps into lanes, with units that fit the states they lead to; the last one again.

    Returns whether the units are those of the steps before.
    """
    times, end, scales = as_singles(own.times), as_singles(own.end), as_singles(own.scales)
    for r in range(s.n):
        own.scales[r] = like(kept.scales[r], own.scales[r])
    for r in range(s.rows):
        last = own.end[r]
        own.begin[r] = like(kept.state[r], last) if group == 0 else last
    same = True
    for lane in range(LANES):
        k = group + min(lane, here - 1)
        times[lane], times[LANES + lane] = starts[k], lengths[k]
        for r in range(s.rows):
            end[LANES * r + lane] = states[k * s.rows + r]
        grown = True
        while grown:
            grown = enlarge_scales(layout, part(states, k * s.rows, s.rows), kept, lanes_for(s.d))
            same = same and not grown
        for r in range(0 if same else s.n):
            scales[LANES * r + lane] = kept.scales[r]
    for r in range(s.rows):
        own.begin[r] = delayed(own.end[r], own.begin[r])
    return same


@helper
def shift(end: Any, begin: Any, last: Any, shifted: bool) -> None:
    """Write what is known where steps end to where those after them begin, unless it is there."""
    for i in range(len(end)):
        if shifted:
            begin[i] = delayed(end[i], last[i])
        last[i] = end[i]


@helper
def write_known(
    manifold: Any, density: Any, params: Any, t: Any, y: Any, s: Sizes, supports: Supports,
    kept: Kept, own: LaneWork, known: Any, numbers: Any, plain: Any,
) -> None:  # fmt: skip
    """Write what has to be known of eight states, in units of pieces and conditions.

    A direction serves all groups of conditions: a row of each, counted from its first one.
    """
    at, size, zero = parts_at(s, known), 1 + s.at_once, 0.0 * y[0]
    state, values = part(numbers, 0, s.n), part(numbers, s.n, s.m)
    scratch = part(numbers, s.n + s.m, s.scratch)
    rows = as_lanes(plain, 0, len(plain) // LANES)
    for i in range(s.n * size):
        rows[i] = zero
    for r in range(s.n):
        rows[r * size] = y[r]
    for first in range(0, int(supports.most[0]), s.at_once):
        for a in range(s.m):
            at_row = int(supports.lows[a]) + first
            for k in range(min(s.at_once, int(supports.ends[a]) - at_row)):
                rows[(at_row + k) * size + 1 + k] = own.scales[at_row + k]
        manifold(params, like(t, state[0]), state, values, scratch)
        for a in range(s.m):
            at_row = int(supports.lows[a]) + first
            for k in range(min(s.at_once, int(supports.ends[a]) - at_row)):
                rows[(at_row + k) * size + 1 + k] = zero
                slope = rows[(s.n + a) * size + 1 + k]
                at.C[(at_row + k) * s.m + a] = slope * kept.condition_scales[a]
    volume = write_reflections(supports, at.C, at.by) if s.m > 0 else like(1.0, zero)
    at.volume[0] = density(params, t, part(y, 0, s.n), own.scratch) - log(volume)


@helper
def write_tangents(s: Sizes, supports: Supports, own: LaneWork) -> None:
    """Write orthonormal directions where steps begin."""
    at = parts_at(s, own.at_begin)
    for i in range(len(own.basis)):
        own.basis[i] = 0.0 * own.begin[0]
    for c in range(s.d):
        own.basis[int(supports.free[c]) * s.d + c] = like(1.0, own.begin[0])
    for step in range(s.m):
        a = s.m - 1 - step
        reflect_by(supports, a, at.C, at.by, s.d, own.basis, 0)


@helper
def carry_lanes(
    method: Any, s: Sizes, own: LaneWork, numbers: Any, plain: Any, scratch: Any
) -> int:
    """Write what steps add to directions, some at once; return the stepper's status."""
    kernel, functions, params, coefficients, fractions = method
    rows, size = as_lanes(plain, 0, len(plain) // LANES), 1 + s.at_once
    for first in range(0, s.d, s.at_once):
        count = min(s.at_once, s.d - first)
        for i in range(len(rows)):
            rows[i] = 0.0 * own.begin[0]
        for r in range(s.rows):
            rows[r * size] = own.begin[r]
        for r in range(s.n):
            for k in range(count):
                rows[r * size + 1 + k] = own.scales[r] * own.basis[r * s.d + first + k]
        status = kernel(
            functions, params, coefficients, fractions, numbers, scratch, s.rows, own.times[0],
            own.times[1], 0, 1, 2, numbers,
        )[0]  # fmt: skip
        if status != OK:
            return int(status)
        for r in range(s.n):
            by = 1.0 / own.scales[r]
            for k in range(count):
                at = r * s.d + first + k
                added = rows[r * size + 1 + k] - own.scales[r] * own.basis[at]
                own.D[at] = (added + rows[(r + s.rows) * size + 1 + k]) * by
    return OK
