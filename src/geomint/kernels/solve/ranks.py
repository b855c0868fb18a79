"""Which steps of a run err most: a number for each step that ranks them, at next to no cost.

An order among the steps is enough to know where to measure an error (`geomint.run.local_error`).
Gauss methods hand over the change of their first iteration: how far a step is from what the one
before extrapolates to. Of other methods differences of the last states are taken, after every few
steps.
"""

from collections import namedtuple

from ..compiling.recorded import helper, inlined
from ..numbers.arithmetic import fma, top, total
from ..numbers.blocks import as_lanes, sections

Ranks = namedtuple(
    "Ranks",
    "window rows every missing slot own before total records largest padding numbers ats inverse marks "
    "ring weights",
)

MARKS = 4  # the last steps that were the worst so far
SATURATED = 0.03  # changes, which are relative to increments, that tell no step from the next
HUGE = 1e100  # what is more counts as this


@inlined
def ranks_layout(window: int, groups: int) -> Ranks:
    """Return the layout of what is known of a run's steps.

    A number is one of the last `window` steps, after `every` so many; states are `missing` for the
    first. Then the slot of the last state in the ring, and its step's `own` number; the one `before`;
    the total of all numbers, or their squares; how many records there were, and the largest number;
    of the last records numbers and steps done; 1/size of each row; the states where windows of the
    last records begin; the ring of the last states; the weights of differences, twice. States are in
    lane values, so many `groups`.
    """
    rows = 8 * groups
    return Ranks(
        window=1, rows=1, every=1, missing=1, slot=1, own=1, before=1, total=1, records=1, largest=1,
        padding=6, numbers=MARKS, ats=MARKS, inverse=rows, marks=MARKS * rows,
        ring=(window + 1) * rows, weights=2 * window + 2,
    )  # fmt: skip


@inlined
def _parts(ranks) -> Ranks:
    return sections(ranks, ranks_layout(int(ranks[0]), (int(ranks[1]) + 7) // 8))


@inlined
def counts(ranks) -> tuple[int, int, int, int]:
    """Return what a loop need not load again: window, rows, steps for a number, the last slot."""
    return int(ranks[0]), int(ranks[1]), int(ranks[2]), int(ranks[4])


@inlined
def keep(ranks, window: int, rows: int, slot: int, memory) -> int:
    """Take the state after a step, and return its slot; `slot` was that of the one before."""
    groups = (rows + 7) // 8
    known = sections(ranks, ranks_layout(window, groups))
    slot = slot + 1 if slot < window else 0
    known.slot[0] = float(slot)
    for r in range(rows):
        known.ring[slot * 8 * groups + r] = top(memory[r])
    return slot


@inlined
def rank_by_own_number(ranks, done: int, steps: int, own):
    """Rank the last of so many steps, which is the one before `done`, by a number of its `own`.

    Not at once after `keep`: what was stored in numbers waits to be loaded in lanes. Numbers of
    `SATURATED` or more are multiplied by how much the states differ.
    """
    _parts(ranks).own[0], number = own, own
    if number >= SATURATED:
        number *= 1.0 + _differences(ranks)
    _rank(ranks, done, steps, number, True)


@helper
def rank_by_differences(ranks, done: int, steps: int, own):
    """Rank the last of so many steps by differences, for all of them.

    It is a call of its own: loops of short steps become slower than that by what stands in them.
    """
    _rank(ranks, done, steps, _differences(ranks), False)


@inlined
def _rank(ranks, done: int, steps: int, number, squared: bool):
    """Add a number to the total, once there are states enough, and keep it if it is the largest."""
    known = _parts(ranks)
    known.missing[0] -= steps
    if known.missing[0] > 0.0:
        return
    if not number <= HUGE:  # or none at all
        number = HUGE
    if squared:
        known.total[0] += number * number
    else:
        known.total[0] += steps * 0.5 * (known.before[0] + number)
        known.before[0] = number
    if number > known.largest[0]:
        _record(ranks, number, done)


@inlined
def _differences(ranks):
    """Return how much the last states differ, relative to the sizes of their pieces."""
    groups, places, known = (int(ranks[1]) + 7) // 8, int(ranks[0]) + 1, _parts(ranks)
    last = places + int(known.slot[0])
    ring = as_lanes(known.ring, 0, places * groups)
    inverse = as_lanes(known.inverse, 0, groups)
    apart = 0.0 * inverse[0]
    for g in range(groups):
        sum = known.weights[last] * ring[g]
        more = 0.0 * sum  # two chains of sums take half the time of one
        for i in range(1, places - 1, 2):
            sum = fma(known.weights[last - i], ring[i * groups + g], sum)
            more = fma(known.weights[last - i - 1], ring[(i + 1) * groups + g], more)
        if places % 2 == 0:
            sum = fma(known.weights[last - places + 1], ring[(places - 1) * groups + g], sum)
        apart = fma(abs(sum + more), inverse[g], apart)
    return total(apart)


@helper
def _record(ranks, number, done: int):
    """Keep the state where the window begins whose number is the largest."""
    window, width, known = int(ranks[0]), 8 * ((int(ranks[1]) + 7) // 8), _parts(ranks)
    slot, mark = int(known.slot[0]), int(known.records[0]) % MARKS
    known.largest[0] = number
    known.records[0] += 1.0
    known.numbers[mark], known.ats[mark] = number, float(done)
    first = slot + 1 if slot < window else 0
    for r in range(width):
        known.marks[mark * width + r] = known.ring[first * width + r]
