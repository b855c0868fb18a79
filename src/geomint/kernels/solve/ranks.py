"""Which steps of a run err most: a number for each step that ranks them, at next to no cost.

An order among the steps is enough to know where to measure an error (`geomint.run.local_error`).
Gauss methods hand over the change of their first iteration: how far a step is from what the one
before extrapolates to. Of other methods differences of the last states are taken.
"""

from __future__ import annotations

from collections import namedtuple

from ..compiling.recorded import inlined
from ..numbers.arithmetic import fma, maximum, top
from ..numbers.blocks import as_lanes, sections

__all__ = ["MARKS", "SATURATED", "keep", "rank", "ranks_layout"]

Ranks = namedtuple(
    "Ranks",
    "window rows power missing slot own total records largest padding numbers ats inverse marks ring "
    "weights",
)

MARKS = 4  # the last steps that were the worst so far
SATURATED = 0.03  # changes, which are relative to increments, that tell no step from the next
HUGE = 1e100  # what is more counts as this


@inlined
def ranks_layout(window: int, groups: int) -> Ranks:
    """Return the layout of what is known of a run's steps.

    A number is one of the last `window` steps, and errors are as its `power`; states that are still
    `missing` for one; the slot of the last state in the ring, and its step's `own` number; the total of
    all numbers to their power; how many records there were, and the largest number; of the last records
    numbers and steps done; 1/size of each row; the states where windows of the last records begin; the
    ring of the last states; the weights of differences, twice. States are in `groups` lane values.
    """
    rows = 8 * groups
    return Ranks(
        window=1, rows=1, power=1, missing=1, slot=1, own=1, total=1, records=1, largest=1, padding=7,
        numbers=MARKS, ats=MARKS, inverse=rows, marks=MARKS * rows, ring=(window + 1) * rows,
        weights=2 * window + 2,
    )  # fmt: skip


@inlined
def keep(ranks, memory, own: float) -> None:
    """Take the state after a step, which has a number of its `own`."""
    window, rows = int(ranks[0]), int(ranks[1])
    groups = (rows + 7) // 8
    known = sections(ranks, ranks_layout(window, groups))
    slot = int(known.slot[0]) + 1
    if slot > window:
        slot = 0
    known.slot[0] = float(slot)
    known.own[0] = own
    for r in range(rows):
        known.ring[slot * 8 * groups + r] = top(memory[r])


@inlined
def rank(ranks, done: int) -> None:
    """Rank the last step, which is the one before `done`.

    Not at once after `keep`: what was stored in numbers waits to be loaded in lanes. Own numbers of
    `SATURATED` or more are multiplied by how much the states differ.
    """
    window, rows = int(ranks[0]), int(ranks[1])
    groups = (rows + 7) // 8
    known = sections(ranks, ranks_layout(window, groups))
    if known.missing[0] > 0.0:
        known.missing[0] -= 1.0
        return
    slot, places = int(known.slot[0]), window + 1
    number = known.own[0]
    if known.power[0] == 1.0 or number >= SATURATED:
        ring = as_lanes(known.ring, 0, places * groups)
        inverse = as_lanes(known.inverse, 0, groups)
        worst = 0.0 * inverse[0]
        for g in range(groups):
            sum = known.weights[places + slot] * ring[g]
            for i in range(1, places):
                sum = fma(known.weights[places + slot - i], ring[i * groups + g], sum)
            worst = maximum(abs(sum) * inverse[g], worst)
        number = top(worst) if known.power[0] == 1.0 else number * (1.0 + top(worst))
    if not number <= HUGE:  # or none at all
        number = HUGE
    known.total[0] += number if known.power[0] == 1.0 else number * number
    if number > known.largest[0]:
        known.largest[0] = number
        mark = int(known.records[0]) % MARKS
        known.records[0] += 1.0
        known.numbers[mark], known.ats[mark] = number, float(done)
        first = slot + 1 if slot < window else 0
        for r in range(8 * groups):
            known.marks[mark * 8 * groups + r] = known.ring[first * 8 * groups + r]
