"""Events: where a function of the state changes its sign along a run, isolated and met by real steps.

A step is looked at along what its method remembers of it; where that is nothing, along an interpolant
of the last eight nodes. Either costs a few operations and no step. Where that does not tell how many
roots there are (`geomint.kernels.solve.sign_changes`) the orbit itself is asked: values at nine points
by real partial steps, halved until each part has no root or one. A root is met by real partial steps,
begun where interpolation has it, within a bracket (`geomint.kernels.solve.orbit`).

The sign of 0 is that before: a root exactly at a node counts once, where the sign has changed, one
where a run begins or ends does not count, and of a stretch of zeros between two signs the end does. A
value at a node is 0 if it is within what rounding of the orbit does to it. What does not decide, for it
is small beside other values, is passed over; where the sign is seen to have changed behind it, the root
is looked for between.
"""

from ..compiling.bound import Bound
from ..compiling.recorded import helper, inlined
from ..compiling.signatures import VALUE, of_stepper
from ..numbers.blocks import part
from .orbit import (
    INSIDE_STEP,
    NEAREST,
    NINE,
    NOTE,
    Orbit,
    clear_of,
    conditioning,
    crossing,
    real_value,
    root,
    values_inside,
)
from .partial import WRITE
from .sign_changes import (
    FIVE,
    NODES,
    ONE,
    UNCLEAR,
    UNKNOWN,
    WEIGHTS,
    evenly,
    look,
    look_closer,
    looked_at,
    of_quartic,
    quartic,
    verdict,
    write_weights,
)
from .status import CHATTER, EVENT_NOT_FINITE, EVENT_UNCLEAR, OK, Steps

__all__ = ["EVENTS", "MOST_IN_STEP", "NODES", "NOTE", "SCRATCH"]

MOST_IN_STEP = 64  # events
ROUNDING = 2.0**-49  # of the event's size
# What may be left, where a run begins, of an event that has ended another one: of the numbers that
# it is made of, and of the values in the first step.
LEFT, BESIDE = 2.0**-43, 2.0**-30
TOUCH = 2.0**-40  # of the event's size: values no larger do not decide
FADED = 2.0**-20  # of the event's size: below that it is looked at anew
SMALLEST = 1e-290  # a size: below that of a function that fades away numbers are no more dense
BENT = 0.25  # of a second difference: twice as far as a parabola is from its chord
NARROWEST = 2.0**-22  # of a step
MOST_VAGUE = 4096  # of such parts of a step that cannot be told
DEPTH = 30
PIECES = (DEPTH + 2) * (2 + FIVE)
SCRATCH = WEIGHTS + NODES + PIECES + 2 * FIVE + 2 * NINE


@helper
def keep(orbit, node: int, theta, sign, at: int):
    """Write an event: its time, its direction, and the state that is in memory."""
    rows = orbit.rows
    row = part(orbit.out, at * (rows + 2), rows + 2)
    t, h = orbit.times[node], orbit.times[node + 1] - orbit.times[node]
    row[0], row[1] = t + theta * h, sign
    for r in range(rows):
        row[2 + r] = orbit.memory[r]


@helper
def rounded(orbit, node: int, other: int, value):
    """Return a small value at an end of a step, or 0 if that is what it is to rounding."""
    return value if abs(value) > ROUNDING * conditioning(orbit, node, other, False) else 0.0


@helper
def at_start(orbit, node: int, value, after, size):
    """Return the value where a run begins, or 0 if that may be what is left of an event there."""
    left = LEFT * conditioning(orbit, node, node + 1, False)
    if ROUNDING * size < abs(value) <= left:
        left = BESIDE * max(abs(after), abs(real_value(orbit, node, 0.5)))
    return value if abs(value) > left else 0.0


@inlined
def sign_of(value):
    """Return 1, −1, or 0 of 0."""
    return 1.0 if value > 0.0 else -1.0 if value < 0.0 else 0.0


@inlined
def met(orbit, node: int, a, b, f, roots: int, sign, found: int) -> int:
    """Take a part of a step with no root or one; return how many events have been found.

    `sign` is that before the root; without one that of the whole part.
    """
    if roots != ONE and orbit.signs[0] == sign and f[4] * sign > 0.0:
        orbit.signs[2] = b
        return found
    return changed(orbit, node, a, b, f, roots, sign, found)


@helper
def changed(orbit, node: int, a, b, f, roots: int, sign, found: int) -> int:
    """Take a part as `met` does, where the sign changes, or is not known at the end."""
    signs, direction = orbit.signs, orbit.direction
    if signs[0] == -sign and direction * sign >= 0.0:
        last = signs[2]  # the root was before this part, or at its begin
        high = a + (b - a) * clear_of(orbit, node, a, b, 0.0, sign)
        x = min(last + NEAREST, 0.5 * (last + high))
        theta = crossing(orbit, node, last, high, x, 0.0, False, sign > 0.0)
        if theta <= NEAREST:
            theta = 0.0
            real_value(orbit, node, theta)
        keep(orbit, node, theta, sign, found)
        found += 1
    # What touches an end may cross it by the rounding of times: the sign behind is to be seen.
    if roots == ONE and (
        abs(f[4]) > ROUNDING * signs[1] or clear_of(orbit, node, a, b, 1.0, -sign) < 1.0
    ):
        sign = -sign
        if direction * sign >= 0.0:
            theta = root(orbit, node, a, b, f, sign > 0.0, ROUNDING * signs[1])
            keep(orbit, node, theta, sign, found)
            found += 1
    signs[0], signs[2] = sign, b
    if not f[4] * sign > 0.0:  # the sign is known before the end
        signs[2] = a + (b - a) * clear_of(orbit, node, a, b, 1.0, sign)
    return found


@inlined
def look_inside(orbit, node: int, f, b, found: int) -> int:
    """Find the events of a step along what is remembered of it; return −1 if that is not clear.

    The whole step at once if that is enough, or else its halves.
    """
    nine = orbit.nine
    left = values_inside(orbit, node, f[0], f[4])
    if left >= UNKNOWN:
        return -1
    rounding = ROUNDING * orbit.signs[1]
    tail = left + rounding
    least, bend = abs(nine[0]), 0.0
    sign = 1.0 if nine[0] > 0.0 else -1.0
    for k in range(1, NINE - 1):
        least = min(least, sign * nine[k])
        bend = max(bend, abs(nine[k - 1] - 2.0 * nine[k] + nine[k + 1]))
    if min(least, sign * nine[8]) > tail + BENT * bend:
        return met(orbit, node, 0.0, 1.0, f, 0, sign, found)
    for k in range(FIVE):
        f[k] = nine[2 * k]
    roots, sign = verdict(f, b, tail + of_quartic(f), rounding)
    if roots != UNCLEAR:
        return changed(orbit, node, 0.0, 1.0, f, roots, sign, found)
    # A middle whose sign is not known would be taken for a root there.
    clear = abs(nine[4]) > tail
    for k in (0, 8):
        clear = clear and (abs(nine[k]) > tail or abs(nine[k]) <= rounding)
    for half in range(2):
        for k in range(FIVE):
            f[k] = nine[4 * half + k]
        roots, _ = verdict(f, b, tail + of_quartic(f), tail)
        clear = clear and roots != UNCLEAR
    for half in range(2 if clear else 0):
        for k in range(FIVE):
            f[k] = nine[4 * half + k]
        roots, sign = verdict(f, b, tail + of_quartic(f), tail)
        found = changed(orbit, node, 0.5 * half, 0.5 * half + 0.5, f, roots, sign, found)
    return found if clear else -1


@helper
def halved(pieces, at: int, low, high, f, odd):
    """Write both halves of a part, the first on top: its ends and five values each."""
    width = 2 + FIVE
    second, first = part(pieces, at * width, width), part(pieces, (at + 1) * width, width)
    middle = 0.5 * (low + high)
    first[0], first[1], second[0], second[1] = low, middle, middle, high
    for k in range(FIVE):
        first[2 + k] = f[k // 2] if k % 2 == 0 else odd[k // 2]
        second[2 + k] = f[2 + k // 2] if k % 2 == 0 else odd[2 + k // 2]


@helper
def search(orbit, node: int, pieces, values, found: int) -> int:
    """Find the events of a step on the orbit itself, part by part; return how many there are then.

    The values at its ends are there.
    """
    f, b = part(values, 0, FIVE), part(values, FIVE, FIVE)
    note, signs, width = orbit.note, orbit.signs, 2 + FIVE
    pieces[0], pieces[1] = 0.0, 1.0
    for k in range(1, FIVE - 1):
        pieces[2 + k] = real_value(orbit, node, 0.25 * k)
    waiting, vague = 1, 0
    begun = found
    while waiting > 0 and note[0] == OK:
        waiting -= 1
        piece = part(pieces, waiting * width, width)
        low, high = piece[0], piece[1]
        size = 0.0
        for k in range(FIVE):
            f[k] = piece[2 + k]
            size = max(size, abs(f[k]))
        signs[1] = max(signs[1], size)
        if size <= TOUCH * signs[1]:
            continue
        tail = 0.0
        odd = b  # free until the verdict
        for k in range(FIVE - 1):
            x = 0.25 * k + 0.125
            odd[k] = real_value(orbit, node, low + (high - low) * x)
            tail = max(tail, 1.5 * abs(odd[k] - quartic(f, x)))
        halved(pieces, waiting, low, high, f, odd)
        rounding = ROUNDING * signs[1]
        roots, sign = verdict(f, b, tail + rounding, rounding)
        if roots != UNCLEAR:
            found = changed(orbit, node, low, high, f, roots, sign, found)
            if found - begun > MOST_IN_STEP - 2:
                note[0], note[3] = CHATTER, high
        elif high - low < NARROWEST:
            vague += 1
            if size > 2.0**-20 * signs[1] or vague > MOST_VAGUE:
                note[0], note[2], note[3] = EVENT_UNCLEAR, size, low
        else:
            waiting += 2
    return found


@helper
def find(
    advance, functions, params, coefficients, fractions, memory, work, rows: int, write, table,
    whole, begun, inside, places, known, event, component: int, level: float, y, free, direction: int,
    states, times, memories, before, first: int, signs, scratch, note, room: int, out,
) -> Steps:  # fmt: skip
    """Write the events between nodes, from node `first` on: time, direction, state.

    Parameters
    ----------
    inside, places, known : function, block, block
        What tells of a step inside, see `geomint.methods.flow.Between`, and room for it, or none.
    event, component, level, y, free : function, int, float, block, block
        The event as an observable; the row that it is in its place, so that its values are as smooth as
        that, or −1; the value that is looked for; room for a state as it takes it; its scratch.
    direction : int
        1: where it rises, −1: where it falls, 0: both.
    states, times : block
        Nodes, the first of which may be there for the interpolant alone.
    memories, before : block
        What is remembered of the steps from the first nodes on, as many as it is known of, and of the
        step before these, or nothing.
    signs : block, shape (3,)
        The last sign that was not 0, or 0; the event's size: the largest value so far, or since it
        faded away, and what it is the difference of; where in a step that sign is known. Changed.
    note : block, shape (NOTE,)
        What went wrong, and what is in memory.
    room : int
        Events that `out` has room for.

    Returns
    -------
    status, node, found, residual
        If there is no room for those of another step, the node to go on from.
    """
    weights, values = part(scratch, 0, WEIGHTS), part(scratch, WEIGHTS, NODES)
    pieces = part(scratch, WEIGHTS + NODES, PIECES)
    five = part(scratch, WEIGHTS + NODES + PIECES, 2 * FIVE)
    f, b = part(five, 0, FIVE), part(five, FIVE, FIVE)
    nine = part(scratch, WEIGHTS + NODES + PIECES + 2 * FIVE, 2 * NINE)
    orbit = Orbit(
        advance, functions, params, coefficients, fractions, memory, work, rows, write, table, whole,
        begun, inside, places, known, event, component, level, y, free, direction, states, times,
        memories, before, signs, note, nine, out,
    )  # fmt: skip
    note[0], note[4], note[5], note[7] = OK, -1.0, -1.0, -1.0
    found, even = 0, False
    from_nodes = len(places) == 0
    for node in range(max(first + 2 - NODES, 0) if from_nodes else first, len(times)):
        for k in range(0 if from_nodes else NODES - 2, NODES - 1):
            values[k] = values[k + 1]
        here = part(states, node * rows, len(y))
        values[NODES - 1] = looked_at(orbit, times[node], here)
        if node <= first:
            continue
        last = node - 1
        if found + MOST_IN_STEP > room:
            return OK, last, found, 0.0
        f[0], f[4] = values[NODES - 2], values[NODES - 1]
        if not (abs(f[0]) < 1e308 and abs(f[4]) < 1e308):
            note[3] = 0.0 if not abs(f[0]) < 1e308 else 1.0
            return EVENT_NOT_FINITE, last, found, 0.0
        size, start = max(abs(f[0]), abs(f[4])), signs[1] == 0.0
        if abs(f[0]) <= ROUNDING * signs[1]:
            f[0] = rounded(orbit, last, node, f[0])
        if size < FADED * signs[1]:  # fading away, or what is left of larger numbers
            made_of = conditioning(orbit, node, last, False)
            signs[1] = min(signs[1], max(size, max(made_of, SMALLEST)))
        elif start:  # small differences of large numbers are known no better than these
            signs[1] = conditioning(orbit, node, last, True)
        signs[1] = max(signs[1], size)
        if abs(f[4]) <= ROUNDING * signs[1]:
            f[4] = rounded(orbit, node, last, f[4])
        end = f[4]
        if start:
            f[0] = at_start(orbit, last, f[0], end, signs[1])
            signs[0] = sign_of(f[0])
        pieces[2], pieces[1 + FIVE], signs[2] = f[0], end, 0.0
        roots, sign, rounding = UNCLEAR, 0.0, ROUNDING * signs[1]
        if from_nodes and node >= NODES - 1:
            now = evenly(times, node)
            if not (even and now):
                write_weights(times, node, now, weights)
                even = now
            if component >= 0:
                tail = look(values, weights, f)
            else:
                tail = look_closer(orbit, node, weights, f)
            roots, sign = verdict(f, b, tail + rounding, rounding)
        earlier = found
        if roots != UNCLEAR:
            found = met(orbit, last, 0.0, 1.0, f, roots, sign, found)
        else:
            clear = -1 if from_nodes else look_inside(orbit, last, f, b, found)
            found = clear if clear >= 0 else search(orbit, last, pieces, five, found)
        if note[0] == OK and end != 0.0 and end * signs[0] <= 0.0:  # behind what does not decide
            f[4], sign = end, sign_of(end)
            found = changed(orbit, last, 1.0, 1.0, f, 0, sign, found)
        for k in range(earlier, found):  # what is before a node is not at it, by rounding
            h = times[node] - times[last]
            if (out[k * (rows + 2)] - times[node]) * h >= 0.0:
                late = max(abs(times[node]) * 2.0**-52, abs(h) * 2.0**-53)
                out[k * (rows + 2)] = times[node] - (late if h > 0.0 else -late)
        if note[0] != OK:
            return int(note[0]), last, found, note[2]
    return OK, len(times) - 1, found, 0.0


EVENTS = Bound(find, of_stepper(find, write=WRITE, inside=INSIDE_STEP, event=VALUE))
