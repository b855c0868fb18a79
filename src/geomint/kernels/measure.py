"""How much a numerical step stretches the measure ``μ δ(c) dy`` on {c(y) = 0}, along a run.

The defect of a step Φ from y₀ to y₁ is, with orthonormal bases Q of ker Dc and C = Dc, ::

    log|det(Q₁ᵀ DΦ Q₀)| + ½ log det(C₀C₀ᵀ) − ½ log det(C₁C₁ᵀ) + log μ₁ − log μ₀

Only ``log|det(Q₁ᵀ DΦ Q₀)|`` has to be summed. It is taken without the rounding of numbers near one:
with the unit normals N, the tangent part X of ``DΦ Q₀`` and E = Q₀ᵀX − 1, Z = Q₁ᵀN₀, ::

    log|det(Q₁ᵀ X)| = log|det(1 + E)| − ½ log det(1 − ZᵀZ)

where E and Z are of the size of the step, and so are their errors. E comes from differences of the
increments Φ(y) − y, which lanes know to relative precision: state, node and both carries. The eight
lanes are the nodes y + jδq, j = ±1 … ±4, of the central difference of order 8.

All is done in units of the pieces of the state: powers of two that no number of the piece has
exceeded, so that |γ| = 1 beside |p| = 1e-150 loses nothing. Determinants do not depend on them.

The spacing δ of each tangent direction is half the largest power of two at which the seventh
difference of the increments, which comes before what the formula neglects, is not above its
rounding. Half, because that makes what is neglected 2⁸ times smaller: it is a bias, which grows with
the number of steps, and the rounding with its root only. The rounding is measured at a spacing where
nothing else is left. The seventh differences also give the variance of the sum that rounding causes,
and E gives a bound of its bias: together, what the instrument cannot tell from zero.
"""

from __future__ import annotations

import functools
import math
from typing import Any

from .arithmetic import lane, maximum, top, total
from .blocks import as_lanes, part, scalar_block
from .compensated import add_compensated
from .recorded import Recorded, helper
from .reflections import log_det_near_identity, reflect, reflect_back, reflections
from .status import OK

__all__ = [
    "BIAS",
    "CONDITIONS_LARGEST",
    "CONDITION_SPACING",
    "VARIANCE",
    "lane_rows",
    "measure_layout",
    "measure_memory",
    "measure_sweep",
    "work_size",
]

# Three rows of eight: the nodes j, the weights of 840 times the derivative, those of the seventh
# difference. Rounded weights would scale all derivatives by the same 1e-16: a bias, not a noise.
NODES = (
    (1.0, 2.0, 3.0, 4.0, -1.0, -2.0, -3.0, -4.0),
    (672.0, -168.0, 32.0, -3.0, -672.0, 168.0, -32.0, 3.0),
    (-7.0, 7.0, -3.0, 0.5, 7.0, -7.0, 3.0, -0.5),
)
# Variance of the derivative by that of the seventh difference, of the same independent errors.
UNIT = 840.0
NOISE = sum(w * w for w in NODES[1]) / sum(w * w for w in NODES[2]) / UNIT**2

# layout: the nodes; then rows of the state, of the stepper's, conditions, rows of the lane memory
# and of the lane work of the method, rows of scratch of the problem; then the pieces
LAYOUT = 24
HEADER = LAYOUT + 6

# memory: these, then state, scales, scales of the conditions, spacings, roundings, two frames
SUM, CARRY, VARIANCE, BIAS, STEPS, BEGUN, ORIGIN, CONDITION_SPACING = range(8)
OWN = 8

LARGEST, SMALLEST, ROUNDING_ONLY = 2.0**-3, 2.0**-20, 2.0**-22
CONDITIONS_LARGEST, CONDITIONS_SMALLEST = 2.0**-3, 2.0**-12
# Seventh differences, in measured roundings: above the first the spacing is too large; above the second
# it is so for good; up to the third they may be the rounding of an iteration that ended badly.
SOME, MANY, UNUSUAL = 4.0, 32.0, 1024.0
MEASURE, CHECK, SEARCH, USE, DONE = range(5)  # stages of the search for a spacing
PERIOD = 64  # steps after which a larger spacing is tried and the rounding measured anew
CONDITIONS_ROUNDINGS = 256.0
EPSILON = 2.0**-52
# What a relative error common to all derivatives, ε/8, may add in a step: measured are ε/50 and less.
SYSTEMATIC = EPSILON / 8.0
FAILED = 1e300
NAN = float("nan")


def measure_layout(
    pieces: Any, rows: int, m: int, memory_rows: int, work_rows: int, scratch: int
) -> Any:
    """Return the block of sizes: the problem's pieces, the stepper's rows, m conditions, the lanes'."""
    n = sum(size for _, size in pieces)
    numbers = [w for row in NODES for w in row] + [n, rows, m, memory_rows, work_rows, scratch]
    numbers += [float(i) for i, (_, size) in enumerate(pieces) for _ in range(size)]
    block = scalar_block(len(numbers))
    block.data[:] = numbers
    return block


def measure_memory(start: Any, sizes: Any, m: int) -> Any:
    """Return the memory at the start: `start` is the stepper's state, `sizes` the problem's rows'."""
    n, rows = len(sizes), len(start)
    at = OWN + rows + n + m
    d = n - m
    block = scalar_block(at + 2 * d + 2 * (m * n + 1))
    block.data[CONDITION_SPACING] = CONDITIONS_LARGEST
    block.data[OWN : OWN + rows] = start
    for i in range(n):
        block.data[OWN + rows + i] = 2.0 ** math.ceil(math.log2(min(max(sizes[i], 1e-290), 1e290)))
    block.data[at - m : at] = 1.0
    block.data[at : at + d] = 0.5 * LARGEST
    return block


def lane_rows(n: int, m: int, memory_rows: int, work_rows: int, scratch: int) -> int:
    """Lane rows of scratch: the method's, the nodes with their carries, the conditions'."""
    return memory_rows + work_rows + 2 * n + m + scratch


def work_size(n: int, m: int, scratch: int) -> int:
    """Numbers of scratch beside the lanes: E, Z, ZᵀZ, gradients, three vectors, the density's."""
    d = n - m
    return d * d + m * d + m * m + m * n + 2 * m + 3 * n + scratch


@helper
def enlarge_scales(layout: Any, y: Any, scales: Any) -> bool:
    """Double the scale of each piece until no number of y exceeds it; return whether one did."""
    n = len(scales)
    grown = False
    r = 0
    while r < n:
        end = r
        largest = 0.0
        while end < n and layout[HEADER + end] == layout[HEADER + r]:
            largest = maximum(abs(y[end]), largest)
            end += 1
        while scales[r] < largest and scales[r] < 1e300:
            for i in range(r, end):
                scales[i] = 2.0 * scales[i]
            grown = True
        r = end
    return grown


@helper
def condition_gradients(
    manifold: Any,
    params: Any,
    numbers: Any,
    t: float,
    y: Any,
    scales: Any,
    spacing: float,
    nodes: Any,
    values: Any,
    scratch: Any,
    sizes: Any,
    C: Any,
) -> float:
    """Write the scaled gradients of the conditions, row after row.

    Returns the largest seventh difference in roundings of the numbers of its row.
    """
    n = len(scales)
    m = len(values)
    zero = 0.0 * numbers[0]
    for a in range(2 * m):
        sizes[a] = 0.0
    for i in range(n):
        nodes[i] = zero + y[i]
    for i in range(n):
        nodes[i] = y[i] + numbers[0] * (spacing * scales[i])
        manifold(params, zero + t, nodes, values, scratch)
        nodes[i] = zero + y[i]
        for a in range(m):
            difference = values[a] - lane(values[a], 0)
            C[a * n + i] = total(numbers[1] * difference) / (UNIT * spacing)
            sizes[2 * a] = maximum(abs(C[a * n + i]), sizes[2 * a])
            seventh = abs(total(numbers[2] * difference))
            sizes[2 * a + 1] = maximum(seventh, sizes[2 * a + 1])
    worst = 0.0
    for a in range(m):
        worst = maximum(sizes[2 * a + 1] / (EPSILON * sizes[2 * a]), worst)
    return worst


@helper
def make_frame(
    density: Any,
    manifold: Any,
    params: Any,
    layout: Any,
    t: float,
    y: Any,
    memory: Any,
    frame: Any,
    lanes: Any,
    work: Any,
) -> None:
    """Write the reflections that split normals and tangents at y, and ``log μ − ½ log det(CCᵀ)``.

    Up to the scales of the conditions, which are constants of the run. The spacing of the
    differences of c is the largest at which they have no error but rounding: for polynomials of
    degree up to 6 the first.
    """
    n = int(layout[LAYOUT])
    rows = int(layout[LAYOUT + 1])
    m = int(layout[LAYOUT + 2])
    scratch_rows = int(layout[LAYOUT + 5])
    scales = part(memory, OWN + rows, n)
    condition_scales = part(memory, OWN + rows + n, m)
    volume = 0.0
    if m > 0:
        at = int(layout[LAYOUT + 3]) + int(layout[LAYOUT + 4])
        nodes = part(lanes, at, n)
        values = part(lanes, at + 2 * n, m)
        scratch = part(lanes, at + 2 * n + m, scratch_rows)
        sizes = part(work, 0, 2 * m)
        C = part(work, 2 * m, m * n)
        numbers = as_lanes(layout, 0, 3)
        spacing = memory[CONDITION_SPACING]
        worst = 2.0 * CONDITIONS_ROUNDINGS
        while worst > CONDITIONS_ROUNDINGS and spacing > CONDITIONS_SMALLEST:
            worst = condition_gradients(
                manifold, params, numbers, t, y, scales, spacing, nodes, values, scratch, sizes, C
            )
            if worst > CONDITIONS_ROUNDINGS:
                spacing = 0.5 * spacing
        memory[CONDITION_SPACING] = spacing
        for a in range(m):
            while memory[BEGUN] == 0.0 and condition_scales[a] < sizes[2 * a] < 1e300:
                condition_scales[a] = 2.0 * condition_scales[a]
            for i in range(n):
                C[a * n + i] = C[a * n + i] / condition_scales[a]
        volume -= reflections(n, m, C, part(frame, 1, m * n))
    density_work = part(work, 0, scratch_rows)
    frame[0] = volume + density(params, t, part(y, 0, n), density_work)


@helper
def one_step(
    kernel: Any,
    f: Any,
    params: Any,
    coefficients: Any,
    fractions: Any,
    memory: Any,
    work: Any,
    rows: int,
    t: float,
    h: float,
) -> tuple[int, int]:
    """Take one step of a loop with the functions f, and save nothing; return status and iterations.

    The compiler knows the length of f and sees one of the branches only.
    """
    if len(f) == 0:
        status, _, iterations, _ = kernel(
            params, coefficients, fractions, memory, work, rows, t, h, 0, 1, 2, memory
        )
    elif len(f) == 1:
        status, _, iterations, _ = kernel(
            f[0], params, coefficients, fractions, memory, work, rows, t, h, 0, 1, 2, memory
        )
    elif len(f) == 2:
        status, _, iterations, _ = kernel(
            f[0], f[1], params, coefficients, fractions, memory, work, rows, t, h, 0, 1, 2, memory
        )
    else:
        status, _, iterations, _ = kernel(
            f[0], f[1], f[2], params, coefficients, fractions, memory, work, rows, t, h, 0, 1, 2,
            memory,
        )  # fmt: skip
    return status, iterations


@helper
def difference(
    kernel: Any,
    functions: Any,
    params: Any,
    coefficients: Any,
    fractions: Any,
    layout: Any,
    t: float,
    h: float,
    y: Any,
    q: Any,
    scales: Any,
    spacing: float,
    lanes: Any,
    D: Any,
    seventh: Any,
) -> tuple[float, float]:
    """Write the scaled derivative of the increment of a step along q, and its seventh difference.

    Returns the largest seventh difference and an estimate of the size of what was rounded; `FAILED` for
    a step that fails at a node.
    """
    n = int(layout[LAYOUT])
    rows = int(layout[LAYOUT + 1])
    memory_rows = int(layout[LAYOUT + 3])
    numbers = as_lanes(layout, 0, 3)
    zero = 0.0 * numbers[0]
    work_rows = int(layout[LAYOUT + 4])
    memory = part(lanes, 0, memory_rows)
    work = part(lanes, memory_rows, work_rows)
    nodes = part(lanes, memory_rows + work_rows, n)
    carries = part(lanes, memory_rows + work_rows + n, n)
    carry = part(memory, rows, rows)
    # A second time if the step iterates: what the first has left of its errors depends smoothly on
    # the node, which is a bias; from where that has ended only rounding is left.
    substeps = len(fractions) // 2
    used = substeps + 1
    passes = 0
    while passes < 2 and used > substeps:
        for r in range(rows):
            memory[r] = zero + y[r]
            carry[r] = zero
        for r in range(n):
            add_compensated(memory, carry, r, numbers[0] * (spacing * scales[r] * q[r]))
            nodes[r] = memory[r]
            carries[r] = carry[r]
        status, used = one_step(
            kernel, functions, params, coefficients, fractions, memory, work, rows, t, h
        )
        if status != OK:
            for r in range(memory_rows):
                memory[r] = zero
            return FAILED, 0.0
        passes += 1
    worst = 0.0
    moved = zero
    rate = 0.0
    for r in range(n):
        increment = (memory[r] - nodes[r]) + (carry[r] - carries[r])
        change = increment - lane(increment, 0)
        unit = 1.0 / scales[r]
        D[r] = total(numbers[1] * change) * unit / (UNIT * spacing)
        seventh[r] = total(numbers[2] * change) * unit
        worst = maximum(abs(seventh[r]), worst)
        moved = maximum(abs(increment) * unit, moved)
        rate = maximum(abs(D[r]), rate)
    return worst, EPSILON * (top(moved) + rate)


@helper
def tangent_column(
    kernel: Any,
    functions: Any,
    params: Any,
    coefficients: Any,
    fractions: Any,
    layout: Any,
    t: float,
    h: float,
    y: Any,
    q: Any,
    memory: Any,
    k: int,
    lanes: Any,
    D: Any,
    seventh: Any,
) -> bool:
    """Write the derivative of the increment along tangent vector k, and add its variance.

    Returns whether the step succeeds at the nodes of any spacing.
    """
    n = int(layout[LAYOUT])
    rows = int(layout[LAYOUT + 1])
    m = int(layout[LAYOUT + 2])
    scales = part(memory, OWN + rows, n)
    at = OWN + rows + n + m
    spacings = part(memory, at, n - m)
    roundings = part(memory, at + n - m, n - m)
    periodic = memory[BEGUN] == 0.0 or (int(memory[STEPS]) + k) % PERIOD == 0
    stage = MEASURE if periodic else CHECK
    spacing = ROUNDING_ONLY if periodic else spacings[k]
    lasting = periodic
    before = FAILED
    not_fallen = 0
    worst = FAILED
    while stage != DONE:
        if stage == USE:
            stage = DONE
        worst, rounded = difference(
            kernel, functions, params, coefficients, fractions, layout, t, h, y, q, scales,
            spacing, lanes, D, seventh,
        )  # fmt: skip
        if stage == MEASURE:
            if worst < FAILED:
                roundings[k] = maximum(maximum(worst, 4.0 * rounded), 0.5 * roundings[k])
            stage = SEARCH
            spacing = min(4.0 * spacings[k], LARGEST)
        elif stage == CHECK:
            stage = DONE if worst <= SOME * roundings[k] else SEARCH
            lasting = worst > MANY * roundings[k]
        elif (
            stage == SEARCH
        ):  # what is neglected falls by 2⁷ at half the spacing, rounding does not
            not_fallen += 1 if worst > 0.125 * before and worst < FAILED else 0
            noise = not_fallen == 2 or (not_fallen == 1 and before <= UNUSUAL * roundings[k])
            if noise or worst <= SOME * roundings[k] or spacing <= SMALLEST:
                stage = USE
            before = worst
            spacing = 0.5 * spacing
    if lasting:
        spacings[k] = spacing
    for r in range(n):
        error = q[r] * seventh[r] / spacing
        memory[VARIANCE] = memory[VARIANCE] + NOISE * error * error
    return worst < FAILED


@helper
def normals_turned(n: int, m: int, old: Any, new: Any, x: Any, Z: Any, G: Any) -> float:
    """Return ``log|det(N₁ᵀ N₀)|`` of the normals of two frames, as ``½ log det(1 − ZᵀZ)``."""
    d = n - m
    for a in range(m):
        for i in range(n):
            x[i] = 1.0 if i == a else 0.0
        reflect_back(m, old, x)
        reflect(m, new, x)
        for i in range(d):
            Z[a * d + i] = x[m + i]
    for a in range(m):
        for b in range(m):
            product = 0.0
            for i in range(d):
                product += Z[a * d + i] * Z[b * d + i]
            G[a * m + b] = -product
    return 0.5 * log_det_near_identity(m, G)


@helper
def log_stretch(
    kernel: Any,
    functions: Any,
    params: Any,
    coefficients: Any,
    fractions: Any,
    layout: Any,
    t: float,
    h: float,
    memory: Any,
    lanes: Any,
    work: Any,
) -> float:
    """Return ``log|det(Q₁ᵀ DΦ Q₀)|`` for the step from the state in memory, between the two frames."""
    n = int(layout[LAYOUT])
    rows = int(layout[LAYOUT + 1])
    m = int(layout[LAYOUT + 2])
    d = n - m
    y = part(memory, OWN, rows)
    frames = OWN + rows + n + m + 2 * d
    old = part(memory, frames + 1, m * n)
    new = part(memory, frames + 2 + m * n, m * n)
    E = part(work, 0, d * d)
    Z = part(work, d * d, m * d)
    G = part(work, d * d + m * d, m * m)
    at = d * d + m * d + m * m
    q = part(work, at, n)
    D = part(work, at + n, n)
    x = part(work, at + 2 * n, n)  # also the seventh difference
    good = True
    for k in range(d):
        for i in range(n):
            q[i] = 1.0 if i == m + k else 0.0
        reflect_back(m, old, q)
        good &= tangent_column(
            kernel, functions, params, coefficients, fractions, layout, t, h, y, q, memory, k, lanes,
            D, x,
        )  # fmt: skip
        if (
            m > 0
        ):  # the part of q + D that leaves the manifold, which has only rounding if Φ does not
            for i in range(n):
                x[i] = q[i] + D[i]
            reflect(m, new, x)
            for i in range(d):
                x[m + i] = 0.0
            reflect_back(m, new, x)
            for i in range(n):
                D[i] = D[i] - x[i]
            reflect(m, old, D)
        for i in range(d):
            E[i * d + k] = D[m + i]
    for i in range(d * d):
        memory[BIAS] = memory[BIAS] + SYSTEMATIC * E[i] * E[i]
    stretch = log_det_near_identity(d, E)
    if m > 0:
        stretch -= normals_turned(n, m, old, new, x, Z, G)
    return stretch if good else NAN


@helper
def sweep(
    kernel: Any,
    functions: Any,
    density: Any,
    manifold: Any,
    params: Any,
    coefficients: Any,
    fractions: Any,
    layout: Any,
    memory: Any,
    lane_numbers: Any,
    work: Any,
    starts: Any,
    lengths: Any,
    states: Any,
    out: Any,
) -> None:
    """Write the sum of the defects after each of the steps that lead to `states`.

    Parameters
    ----------
    kernel : function
        A stepper's loop of `geomint.kernels.advance`, compiled for lanes; a call takes one step.
    functions : tuple
        What it is to be called with.
    starts, lengths : blocks
        Of the steps. The first begins at the state in memory.
    states : block
        The states after the steps, one after the other.
    """
    n = int(layout[LAYOUT])
    rows = int(layout[LAYOUT + 1])
    m = int(layout[LAYOUT + 2])
    lanes = as_lanes(lane_numbers, 0, len(lane_numbers) // 8)
    y = part(memory, OWN, rows)
    scales = part(memory, OWN + rows, n)
    size = m * n + 1
    at = OWN + rows + n + m + 2 * (n - m)
    old = part(memory, at, size)
    new = part(memory, at + size, size)
    for k in range(len(starts)):
        t = starts[k]
        h = lengths[k]
        state = part(states, k * rows, rows)
        begins = memory[BEGUN] == 0.0
        remake = enlarge_scales(layout, state, scales) or begins
        before = old[0]
        for end in range(0 if remake else 1, 2):
            x, frame = (y, old) if end == 0 else (state, new)
            make_frame(
                density, manifold, params, layout, t + end * h, x, memory, frame, lanes, work
            )
        if remake:
            memory[ORIGIN] = old[0] if begins else memory[ORIGIN] + (old[0] - before)
        stretch = log_stretch(
            kernel, functions, params, coefficients, fractions, layout, t, h, memory, lanes, work
        )
        memory[BEGUN] = 1.0
        memory[STEPS] = memory[STEPS] + 1.0
        add_compensated(memory, part(memory, CARRY, 1), SUM, stretch)
        out[k] = memory[SUM] + (memory[CARRY] + (new[0] - memory[ORIGIN]))
        for i in range(size):
            old[i] = new[i]
        for r in range(rows):
            y[r] = state[r]


@functools.cache
def measure_sweep(functions: int) -> Recorded:
    """Return the compiled entry of `sweep` for loops that take `functions` functions."""

    def none(k, d, g, p, c, fr, lay, m, lanes, w, starts, lengths, states, out):
        sweep(k, (), d, g, p, c, fr, lay, m, lanes, w, starts, lengths, states, out)

    def one(k, f0, d, g, p, c, fr, lay, m, lanes, w, starts, lengths, states, out):
        sweep(k, (f0,), d, g, p, c, fr, lay, m, lanes, w, starts, lengths, states, out)

    def two(k, f0, f1, d, g, p, c, fr, lay, m, lanes, w, starts, lengths, states, out):
        sweep(k, (f0, f1), d, g, p, c, fr, lay, m, lanes, w, starts, lengths, states, out)

    def three(k, f0, f1, f2, d, g, p, c, fr, lay, m, lanes, w, starts, lengths, states, out):
        sweep(k, (f0, f1, f2), d, g, p, c, fr, lay, m, lanes, w, starts, lengths, states, out)

    entry = (none, one, two, three)[functions]
    entry.__name__ = "measure"  # what "compiling …" says
    return helper(entry)
