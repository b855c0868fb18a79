"""The derivative of a numerical step along a tangent vector, by eight neighbouring trajectories.

Increments Φ(y) − y are differenced, which lanes know to relative precision: state, node and both
carries. The eight lanes are the nodes y + jδq, j = ±1 … ±4, of the central difference of order 8.

The spacing δ of each tangent direction is half the largest power of two at which the seventh
difference of the increments, which comes before what the formula neglects, is not above its
rounding. Half, because that makes what is neglected 2⁸ times smaller: it is a bias, which grows with
the number of steps, and the rounding with its root only. The rounding is measured at a spacing where
nothing else is left. The seventh differences also give the variance that rounding causes.
"""

from __future__ import annotations

from typing import Any

from ..compiling.recorded import helper
from ..numbers.arithmetic import lane, maximum, top, total
from ..numbers.blocks import as_lanes, part
from ..solve.compensated import add_compensated
from ..solve.status import OK
from .memory import EPSILON, LARGEST, NODES, UNIT, Lanes, Memory

__all__ = ["tangent_column"]

# Variance of the derivative by that of the seventh difference, of the same independent errors.
NOISE = sum(w * w for w in NODES[1]) / sum(w * w for w in NODES[2]) / UNIT**2
SMALLEST, ROUNDING_ONLY = 2.0**-20, 2.0**-22  # spacings
# Seventh differences, in measured roundings: above the first the spacing is too large; above the second
# it is so for good; up to the third they may be the rounding of an iteration that ended badly.
SOME, MANY, UNUSUAL = 4.0, 32.0, 1024.0
MEASURE, CHECK, SEARCH, USE, DONE = range(5)  # stages of the search for a spacing
PERIOD = 64  # steps after which a larger spacing is tried and the rounding measured anew
FAILED = 1e300


@helper
def difference(
    method: Any,
    layout: Any,
    t: float,
    h: float,
    y: Any,
    q: Any,
    scales: Any,
    spacing: float,
    lanes: Lanes,
    D: Any,
    seventh: Any,
) -> tuple[float, float]:
    """Write the scaled derivative of the increment of a step along q, and its seventh difference.

    `method` is what takes a step: (kernel, functions, params, coefficients, fractions).
    Returns the largest seventh difference and an estimate of the size of what was rounded; `FAILED` for
    a step that fails at a node.
    """
    kernel, functions, params, coefficients, fractions = method
    n, rows = len(scales), len(y)
    numbers = as_lanes(layout, 0, 3)
    zero = 0.0 * numbers[0]
    memory, work, nodes, carries, _, _ = lanes
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
        # One step, of which nothing is saved.
        status, _, used, _ = kernel(
            functions, params, coefficients, fractions, memory, work, rows, t, h, 0, 1, 2, memory
        )
        if status != OK:
            for r in range(len(memory)):
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
    method: Any,
    layout: Any,
    t: float,
    h: float,
    q: Any,
    kept: Memory,
    k: int,
    lanes: Lanes,
    D: Any,
    seventh: Any,
) -> bool:
    """Write the derivative of the increment along tangent vector k, and add its variance.

    Returns whether the step succeeds at the nodes of any spacing.
    """
    scales, variance = kept.scales, kept.variance
    spacings, roundings = kept.spacings, kept.roundings
    periodic = kept.begun[0] == 0.0 or (int(kept.steps[0]) + k) % PERIOD == 0
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
            method, layout, t, h, kept.state, q, scales, spacing, lanes, D, seventh
        )
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
    for r in range(len(scales)):
        error = q[r] * seventh[r] / spacing
        variance[0] = variance[0] + NOISE * error * error
    return worst < FAILED
