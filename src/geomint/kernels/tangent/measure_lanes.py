"""How much steps stretch the measure, eight of them at once: for steppers that work lane by lane.

`geomint.kernels.tangent.measure` says what is computed; here every step has orthonormal directions of
its own, those that Householder's reflections of the conditions' gradients at its first state leave,
so that no step waits for another one: a lane is a step. There are two QR factorisations a step, of
gradients where it begins and where it ends, and no matrix to turn directions by.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any

from ..compiling.bound import Bound
from ..compiling.number_types import NumberType
from ..compiling.recorded import helper, inlined
from ..compiling.signatures import BLOCK
from ..numbers.arithmetic import NAN, fma, like, log, maximum, select, sqrt, top
from ..numbers.blocks import as_lanes, as_singles, part, sections
from ..numbers.lanes import LANES
from ..solve.compensated import add_compensated
from ..solve.status import OK
from .layout import Kept, Sizes, kept_layout, lanes_for, sizes_of
from .measure import EPSILON, OFF, SYSTEMATIC
from .normals import enlarge_scales
from .signature import sweep_signature

SEEN = 1e-9  # of a unit vector

__all__ = ["lane_work_layout", "measure_lanes_sweep"]

# Rows of eight numbers: times and lengths; states where steps begin and end; units; what is known of
# these states, and (one number each) of the last one; directions, what steps add to them, scratch; a
# matrix; stretches and squares; scratch of the density.
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
    times, begin, end = as_singles(own.times), as_singles(own.begin), as_singles(own.end)
    scales, same = as_singles(own.scales), True
    for lane in range(LANES):
        k = group + min(lane, here - 1)
        times[lane], times[LANES + lane] = starts[k], lengths[k]
        for r in range(s.rows):
            begin[LANES * r + lane] = kept.state[r] if k == 0 else states[(k - 1) * s.rows + r]
            end[LANES * r + lane] = states[k * s.rows + r]
        grown = True
        while grown:
            grown = enlarge_scales(layout, part(states, k * s.rows, s.rows), kept, lanes_for(s.d))
            same = same and not grown
        for r in range(s.n):
            scales[LANES * r + lane] = kept.scales[r]
    return same


@helper
def shift(end: Any, begin: Any, last: Any, shifted: bool) -> None:
    """Write what is known where steps end to where those after them begin, unless it is there."""
    ends, begins = as_singles(end), as_singles(begin)
    for i in range(len(end)):
        if shifted:
            begins[LANES * i] = last[i]
            for lane in range(1, LANES):
                begins[LANES * i + lane] = ends[LANES * i + lane - 1]
        last[i] = ends[LANES * i + LANES - 1]  # of a step again, if there are fewer


@helper
def reflect_by(n: int, m: int, a: int, C: Any, by: Any, width: int, X: Any, first: int) -> None:
    """Reflect columns of a table of n rows, from `first` on, by column a of C: four at once."""
    fours = (width - first) // 4
    for c in range(first, first + 4 * fours, 4):
        v, at = C[a * m + a], a * width + c
        d0, d1, d2, d3 = v * X[at], v * X[at + 1], v * X[at + 2], v * X[at + 3]
        for r in range(a + 1, n):
            v, at = C[r * m + a], r * width + c
            d0, d1 = fma(v, X[at], d0), fma(v, X[at + 1], d1)
            d2, d3 = fma(v, X[at + 2], d2), fma(v, X[at + 3], d3)
        d0, d1, d2, d3 = -by[a] * d0, -by[a] * d1, -by[a] * d2, -by[a] * d3
        for r in range(a, n):
            v, at = C[r * m + a], r * width + c
            X[at], X[at + 1] = fma(d0, v, X[at]), fma(d1, v, X[at + 1])
            X[at + 2], X[at + 3] = fma(d2, v, X[at + 2]), fma(d3, v, X[at + 3])
    for c in range(first + 4 * fours, width):
        d0 = C[a * m + a] * X[a * width + c]
        for r in range(a + 1, n):
            d0 = fma(C[r * m + a], X[r * width + c], d0)
        d0 = -by[a] * d0
        for r in range(a, n):
            X[r * width + c] = fma(d0, C[r * m + a], X[r * width + c])


@helper
def write_reflections(n: int, m: int, C: Any, by: Any) -> Any:
    """Write Householder's reflections over m columns; return the volume that columns span."""
    volume = like(1.0, by[0])
    for a in range(m):
        square = C[a * m + a] * C[a * m + a]
        for r in range(a + 1, n):
            square = fma(C[r * m + a], C[r * m + a], square)
        norm, first = sqrt(square), C[a * m + a]
        volume = volume * norm
        by[a] = 1.0 / (norm * (norm + abs(first)))
        C[a * m + a] = first + select(first < 0.0, -norm, norm)
        reflect_by(n, m, a, C, by, m, C, a + 1)
    return volume


@helper
def write_known(
    manifold: Any, density: Any, params: Any, t: Any, y: Any, s: Sizes, kept: Kept, own: LaneWork,
    known: Any, numbers: Any, plain: Any,
) -> None:  # fmt: skip
    """Write what has to be known of eight states, in units of pieces and conditions."""
    at, size, zero = parts_at(s, known), 1 + s.at_once, 0.0 * y[0]
    state, values = part(numbers, 0, s.n), part(numbers, s.n, s.m)
    scratch = part(numbers, s.n + s.m, s.scratch)
    rows = as_lanes(plain, 0, len(plain) // LANES)
    for i in range(s.n * size):
        rows[i] = zero
    for r in range(s.n):
        rows[r * size] = y[r]
    for first in range(0, s.n if s.m > 0 else 0, s.at_once):
        count = min(s.at_once, s.n - first)
        for k in range(count):
            rows[(first + k) * size + 1 + k] = own.scales[first + k]
        manifold(params, like(t, state[0]), state, values, scratch)
        for k in range(count):
            rows[(first + k) * size + 1 + k] = zero
            for a in range(s.m):
                slope = rows[(s.n + a) * size + 1 + k]
                at.C[(first + k) * s.m + a] = slope * kept.condition_scales[a]
    volume = write_reflections(s.n, s.m, at.C, at.by) if s.m > 0 else like(1.0, zero)
    at.volume[0] = density(params, t, part(y, 0, s.n), own.scratch) - log(volume)


@helper
def write_tangents(s: Sizes, own: LaneWork) -> None:
    """Write orthonormal directions where steps begin."""
    at = parts_at(s, own.at_begin)
    for i in range(len(own.basis)):
        own.basis[i] = 0.0 * own.begin[0]
    for c in range(s.d):
        own.basis[(s.m + c) * s.d + c] = like(1.0, own.begin[0])
    for step in range(s.m):
        a = s.m - 1 - step
        reflect_by(s.n, s.m, a, at.C, at.by, s.d, own.basis, 0)


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


@helper
def project_lanes(s: Sizes, own: LaneWork) -> None:
    """Take from what is added to directions what leads away from the manifold where steps end.

    It counts by its square: less than `SEEN` of it is left where it is.
    """
    n, m, d, basis, D, X = s.n, s.m, s.d, own.basis, own.D, own.X
    at = parts_at(s, own.at_end)
    for i in range(len(X)):
        X[i] = basis[i] + D[i]
    for a in range(m):
        reflect_by(n, m, a, at.C, at.by, d, X, 0)
    most = 0.0 * X[0]
    for i in range(m * d):
        most = maximum(abs(X[i]), most)
    if top(most) < SEEN:
        return
    for i in range(len(X)):
        X[i] = select(most < SEEN, 0.0 * X[i], X[i]) if i < m * d else 0.0 * most
    for step in range(m):
        reflect_by(n, m, m - 1 - step, at.C, at.by, d, X, 0)
    for i in range(len(X)):
        D[i] = D[i] - X[i]


@helper
def write_changes(n: int, d: int, M: Any, D: Any, S: Any) -> None:
    """Write the lower half of ``S = MᵀD + DᵀM``, four numbers at once."""
    for i in range(d):
        for j in range(0, i + 1, 4):
            if j + 4 <= d:
                s0 = 0.0 * D[0]
                s1, s2, s3 = s0, s0, s0
                for r in range(n):
                    m, b, at = M[r * d + i], D[r * d + i], r * d + j
                    s0, s1 = fma(m, D[at], s0), fma(m, D[at + 1], s1)
                    s2, s3 = fma(m, D[at + 2], s2), fma(m, D[at + 3], s3)
                    s0, s1 = fma(b, M[at], s0), fma(b, M[at + 1], s1)
                    s2, s3 = fma(b, M[at + 2], s2), fma(b, M[at + 3], s3)
                at = i * d + j
                S[at], S[at + 1], S[at + 2], S[at + 3] = s0, s1, s2, s3
            else:
                for c in range(j, i + 1):
                    s0 = 0.0 * D[0]
                    for r in range(n):
                        s0 = fma(M[r * d + i], D[r * d + c], s0)
                        s0 = fma(D[r * d + i], M[r * d + c], s0)
                    S[i * d + c] = s0


@helper
def write_stretch(s: Sizes, own: LaneWork) -> None:
    """Write ``½ log det XᵀX`` of the tangent part X = Q + D, and ‖D‖²."""
    d, basis, D, X, S = s.d, own.basis, own.D, own.X, own.S
    if s.m > 0:
        project_lanes(s, own)
    size = 0.0 * D[0]
    for i in range(len(X)):
        X[i] = fma(0.5, D[i], basis[i])
        size = fma(D[i], D[i], size)
    write_changes(s.n, d, X, D, S)
    product = 0.0 * D[0]  # of 1 + pivot, less 1
    for k in range(d):
        pivot = select(S[k * d + k] > -1.0, S[k * d + k], NAN + 0.0 * D[0])
        product = (product + pivot) + product * pivot
        by = -1.0 / (1.0 + pivot)
        for i in range(k + 1, d):
            factor = by * S[i * d + k]
            for j in range(k + 1, i + 1):
                S[i * d + j] = fma(factor, S[j * d + k], S[i * d + j])
    own.found[0], own.found[1] = 0.5 * log_one_plus_lanes(product), size


@inlined
def log_one_plus_lanes(x: Any) -> Any:
    """Return ``log(1 + x)`` to full relative accuracy for small x (Kahan's quotient)."""
    u = 1.0 + x
    by = select(u == 1.0, like(1.0, u), u - 1.0)
    near = select(u == 1.0, x, log(u) * (x / by))
    return select(abs(x) < 0.5, near, log(u))


@helper
def measure_lanes(
    kernel: Any, functions: Any, manifold: Any, params: Any, coefficients: Any, fractions: Any,
    layout: Any, memory: Any, work: Any, numbers: Any, plain: Any, scratch: Any, conditions: Any,
    conditions_plain: Any, density: Any, starts: Any, lengths: Any, states: Any, out: Any,
) -> None:  # fmt: skip
    """Write the sum of the defects after each of the steps: arguments as those of `measure`.

    `work` is in lanes; `numbers`, `scratch` and `conditions` hold eight tangent numbers a row.
    """
    s = sizes_of(layout)
    method = (kernel, functions, params, coefficients, fractions)
    kept, own = sections(memory, kept_layout(s)), sections(work, lane_work_layout(s))
    volumes, ends = (
        as_singles(parts_at(s, own.at_begin).volume),
        as_singles(parts_at(s, own.at_end).volume),
    )
    found, last, volume, origin, begun = (
        as_singles(own.found),
        as_singles(own.last),
        kept.volume,
        kept.origin,
        kept.begun,
    )
    for group in range(0, len(starts), LANES):
        here = min(LANES, len(starts) - group)
        same = load_steps(layout, s, kept, own, starts, lengths, states, group, here)
        same = same and begun[0] != 0.0
        t0, t1 = own.times[0], own.times[0] + own.times[1]
        write_known(
            manifold, density, params, t1, own.end, s, kept, own, own.at_end, conditions,
            conditions_plain,
        )  # fmt: skip
        if not same:
            write_known(
                manifold, density, params, t0, own.begin, s, kept, own, own.at_begin, conditions,
                conditions_plain,
            )  # fmt: skip
        shift(own.at_end, own.at_begin, last, same)
        write_tangents(s, own)
        if carry_lanes(method, s, own, numbers, plain, scratch) == OK:
            write_stretch(s, own)
        else:
            own.found[0], own.found[1] = NAN + 0.0 * t0, NAN + 0.0 * t0
        for lane in range(here):
            origin[0] = (
                origin[0] + (volumes[lane] - volume[0]) if begun[0] != 0.0 else volumes[lane]
            )
            begun[0], volume[0], squares = 1.0, ends[lane], found[LANES + lane]
            kept.bias[0] = kept.bias[0] + (SYSTEMATIC * squares + OFF * s.m)
            kept.variance[0] = kept.variance[0] + EPSILON * EPSILON * squares
            add_compensated(kept.sum, kept.carry, 0, found[lane])
            out[group + lane] = kept.sum[0] + (kept.carry[0] + (volume[0] - origin[0]))
    for r in range(s.rows):
        kept.state[r] = states[(len(starts) - 1) * s.rows + r]


def measure_lanes_sweep(
    kernel: Bound,
    functions: tuple[Bound, ...],
    density: Bound,
    manifold: Bound,
    numbers: NumberType,
) -> Bound:
    """Return `measure_lanes` for a stepper's loop and its functions in eight tangent numbers."""
    steps = dict.fromkeys(("starts", "lengths", "states", "out"), BLOCK)
    own = {"density": density.signature}
    taken = sweep_signature(None, kernel, functions, manifold, numbers, **own, **steps)
    return Bound(measure_lanes, taken)
