"""How much steps stretch the measure, eight of them at once: for steppers that work lane by lane.

`geomint.kernels.tangent.measure` says what is computed; here every step has orthonormal directions of
its own, those that Householder's reflections of the conditions' gradients at its first state leave,
so that no step waits for another one: a lane is a step. There is no matrix to turn directions by.
"""

from __future__ import annotations

from typing import Any

from ..compiling.bound import Bound
from ..compiling.number_types import NumberType
from ..compiling.recorded import helper, inlined
from ..compiling.signatures import BLOCK
from ..numbers.arithmetic import NAN, fma, like, log, maximum, select, top
from ..numbers.blocks import as_singles, sections
from ..numbers.lanes import LANES
from ..solve.compensated import add_compensated
from ..solve.status import OK
from .householder import reflect_by
from .lane_steps import (
    LaneWork,
    carry_lanes,
    lane_work_layout,
    load_steps,
    parts_at,
    shift,
    write_known,
    write_tangents,
)
from .layout import Kept, Sizes, kept_layout, sizes_of
from .measure import EPSILON, OFF, SYSTEMATIC
from .signature import sweep_signature
from .supports import Supports, supports_of

__all__ = ["PARTS", "measure_lanes_sweep"]

SEEN = 1e-9  # of a unit vector
PARTS = 4  # numbers that are known of a step


@helper
def project_lanes(s: Sizes, supports: Supports, own: LaneWork) -> None:
    """Take from what is added to directions what leads away from the manifold where steps end.

    It counts by its square: less than `SEEN` of it is left where it is.
    """
    m, d, basis, D, X = s.m, s.d, own.basis, own.D, own.X
    at = parts_at(s, own.at_end)
    for i in range(len(X)):
        X[i] = basis[i] + D[i]
    for a in range(m):
        reflect_by(supports, a, at.C, at.by, d, X, 0)
    most = 0.0 * X[0]
    for a in range(m):
        first = int(supports.pivots[a]) * d
        for i in range(first, first + d):
            most = maximum(abs(X[i]), most)
    if top(most) < SEEN:
        return
    for c in range(d):
        first = int(supports.free[c]) * d
        for i in range(first, first + d):
            X[i] = 0.0 * most
    for a in range(m):
        first = int(supports.pivots[a]) * d
        for i in range(first, first + d):
            X[i] = select(most < SEEN, 0.0 * X[i], X[i])
    for step in range(m):
        reflect_by(supports, m - 1 - step, at.C, at.by, d, X, 0)
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
def write_stretch(s: Sizes, supports: Supports, own: LaneWork) -> None:
    """Write ``½ log det XᵀX`` of the tangent part X = Q + D, and ‖D‖²."""
    d, basis, D, X, S = s.d, own.basis, own.D, own.X, own.S
    if s.m > 0:
        project_lanes(s, supports, own)
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
def add_up(s: Sizes, kept: Kept, parts: Any, out: Any) -> None:
    """Write the sum of the defects after each of the steps, of what is known of each."""
    volume, origin, begun = kept.volume, kept.origin, kept.begun
    for k in range(len(out)):
        defect, squares = parts[PARTS * k], parts[PARTS * k + 1]
        before, after = parts[PARTS * k + 2], parts[PARTS * k + 3]
        origin[0] = origin[0] + (before - volume[0]) if begun[0] != 0.0 else before
        begun[0], volume[0] = 1.0, after
        kept.bias[0] = kept.bias[0] + (SYSTEMATIC * squares + OFF * s.m)
        kept.variance[0] = kept.variance[0] + EPSILON * EPSILON * squares
        add_compensated(kept.sum, kept.carry, 0, defect)
        out[k] = kept.sum[0] + (kept.carry[0] + (volume[0] - origin[0]))


@helper
def measure_lanes(
    kernel: Any, functions: Any, manifold: Any, params: Any, coefficients: Any, fractions: Any,
    layout: Any, memory: Any, work: Any, numbers: Any, plain: Any, scratch: Any, conditions: Any,
    conditions_plain: Any, density: Any, starts: Any, lengths: Any, states: Any, parts: Any, out: Any,
) -> None:  # fmt: skip
    """Write what is known of each of the steps, and the sums of the defects after those of `out`.

    Other arguments are as those of `measure`; `work` is in lanes; `numbers`, `scratch` and
    `conditions` hold eight tangent numbers a row. Steps wait for nothing but units of pieces, so that
    they may be taken in several calls at once, with a memory each; then one without steps adds up.

    Parameters
    ----------
    parts : block
        Of each step its defect but for volumes, ‖D‖², and the volumes where it begins and ends.
    out : block
        Empty, or one number for each of `parts`.
    """
    s = sizes_of(layout)
    supports = supports_of(layout, s)
    method = (kernel, functions, params, coefficients, fractions)
    kept, own = sections(memory, kept_layout(s)), sections(work, lane_work_layout(s))
    volumes, ends = (
        as_singles(parts_at(s, own.at_begin).volume),
        as_singles(parts_at(s, own.at_end).volume),
    )
    found = as_singles(own.found)
    begun = kept.begun[0] != 0.0
    for group in range(0, len(starts), LANES):
        here = min(LANES, len(starts) - group)
        same = load_steps(layout, s, kept, own, starts, lengths, states, group, here)
        same = same and begun
        begun = True
        t0, t1 = own.times[0], own.times[0] + own.times[1]
        write_known(
            manifold, density, params, t1, own.end, s, supports, kept, own, own.at_end,
            conditions, conditions_plain,
        )  # fmt: skip
        if not same:
            write_known(
                manifold, density, params, t0, own.begin, s, supports, kept, own, own.at_begin,
                conditions, conditions_plain,
            )  # fmt: skip
        shift(own.at_end, own.at_begin, own.last, same)
        write_tangents(s, supports, own)
        if carry_lanes(method, s, own, numbers, plain, scratch) == OK:
            write_stretch(s, supports, own)
        else:
            own.found[0], own.found[1] = NAN + 0.0 * t0, NAN + 0.0 * t0
        for lane in range(here):
            at = PARTS * (group + lane)
            parts[at], parts[at + 1] = found[lane], found[LANES + lane]
            parts[at + 2], parts[at + 3] = volumes[lane], ends[lane]
    for r in range(s.rows if len(starts) > 0 else 0):
        kept.state[r] = states[(len(starts) - 1) * s.rows + r]
    add_up(s, kept, parts, out)


def measure_lanes_sweep(
    kernel: Bound,
    functions: tuple[Bound, ...],
    density: Bound,
    manifold: Bound,
    numbers: NumberType,
) -> Bound:
    """Return `measure_lanes` for a stepper's loop and its functions in eight tangent numbers."""
    steps = dict.fromkeys(("starts", "lengths", "states", "parts", "out"), BLOCK)
    own = {"density": density.signature}
    taken = sweep_signature(None, kernel, functions, manifold, numbers, **own, **steps)
    return Bound(measure_lanes, taken)
