"""Events: where a function of the state changes its sign along a run, isolated and met by real steps.

A step is first looked at along an interpolant of the last eight nodes, which costs a few operations and
no step. Where that does not tell how many roots there are (`geomint.kernels.solve.sign_changes`), and
where there are not eight nodes yet, along the step's own polynomial, if the method has one, and then
the orbit itself is asked: values at nine points by real partial steps, halved until each part has no
root or one. A root is met by the secant method with real partial steps, begun where the polynomial has
it.

The sign of 0 is that before: a root exactly at a node counts once, where the sign has changed, and one
where a run begins does not count.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any

from ..compiling.bound import Bound
from ..compiling.recorded import helper
from ..compiling.signatures import BLOCK, VALUE, WHOLE, Kind, of_stepper
from ..numbers.blocks import part
from .partial import BEGUN, POLYNOMIAL, one_step, whole_step
from .sign_changes import (
    FIVE,
    NODES,
    ONE,
    UNCLEAR,
    WEIGHTS,
    evenly,
    look,
    look_closer,
    of_quartic,
    quartic,
    verdict,
    write_weights,
)
from .status import CHATTER, EVENT_NOT_FINITE, EVENT_UNCLEAR, OK

__all__ = ["MOST_IN_STEP", "NODES", "NOTE", "SCRATCH", "events_in"]

MOST_IN_STEP = 64  # events
ROUNDING = 2.0**-49  # of the event's size
TOUCH = 2.0**-40  # of the event's size: values no larger do not decide
FADED = 2.0**-20  # of the event's size: below that it is looked at anew
SMALLEST = 1e-290  # a size: below that of a function that fades away numbers are no more dense
NARROWEST = 2.0**-22  # of a step
MOST_VAGUE = 4096  # of such parts of a step that cannot be told
NEAREST = 2.0**-48  # of a step: roots are met to this
ROUGH = 2.0**-40  # of a step: no slope is taken from values nearer to each other
GUESSED = 2.0**-20  # of a step: to this the first guess at a root is found on a polynomial
NEARBY = 2.0**-6  # of a step: a partial step begins on another one so near
DEPTH = 30
PIECES = (DEPTH + 2) * (2 + FIVE)
ALONG = 9  # values along a step's polynomial
SCRATCH = WEIGHTS + NODES + PIECES + 2 * FIVE + ALONG
# What went wrong: status, iterations, residual, θ; the node whose step is in `whole`; the node and the
# θ of the partial step that is in `memory`.
NOTE = 7

# What does not change along a run: the stepper, the event, the nodes.
Orbit = namedtuple(
    "Orbit",
    "advance functions params coefficients fractions memory work rows write table whole begun "
    "polynomial powers event y free states times note",
)


@helper
def conditioning(event: Any, params: Any, free: Any, t: float, y: Any) -> float:
    """Return Σ |∂f/∂y_i| max |y| + |t ∂f/∂t|: the roundings of an orbit change f by ε times it."""
    tiny, total, largest = 2.0**-26, 0.0, 0.0
    for r in range(len(y)):
        largest = max(largest, abs(y[r]))
    for r in range(len(y)):
        known = y[r]
        y[r] = known + tiny * largest
        more = event(params, t, y, free)
        y[r] = known - tiny * largest
        total += abs(more - event(params, t, y, free))
        y[r] = known
    more = event(params, t * (1.0 + tiny), y, free)
    total += abs(more - event(params, t * (1.0 - tiny), y, free))
    return 0.5 * total / tiny if total < 1e300 else 1e308


@helper
def begin(orbit: Any, node: int) -> None:
    """Take the whole step from a node, on which partial ones begin, unless it is known."""
    note, t = orbit.note, orbit.times[node]
    if note[4] == node:
        return
    note[4] = node
    if len(orbit.table) > 0:
        whole_step(
            orbit.advance, orbit.functions, orbit.params, orbit.begun, orbit.fractions, orbit.whole,
            orbit.work, orbit.rows, orbit.states, node * orbit.rows, t, orbit.times[node + 1] - t,
        )  # fmt: skip
        orbit.polynomial(orbit.whole, orbit.table, orbit.rows, orbit.powers)


@helper
def real_value(orbit: Any, node: int, theta: float) -> float:
    """Return the event's value on the orbit, θ of a step from a node; leave the state in memory."""
    memory, rows, note = orbit.memory, orbit.rows, orbit.note
    t, h = orbit.times[node], orbit.times[node + 1] - orbit.times[node]
    begin(orbit, node)
    if theta == 0.0 or theta == 1.0:
        at = node if theta == 0.0 else node + 1
        for r in range(rows):
            memory[r] = orbit.states[at * rows + r]
        note[5] = -1.0
    else:
        near = note[5] == node and abs(theta - note[6]) < NEARBY * note[6]
        status, iterations, residual = one_step(
            orbit.advance, orbit.functions, orbit.params, orbit.coefficients, orbit.fractions,
            memory, orbit.work, rows, orbit.write, orbit.table, memory if near else orbit.whole,
            orbit.states, node * rows, t, theta * h, theta / note[6] if near else theta,
        )  # fmt: skip
        note[5], note[6] = node, theta
        if status != OK:
            note[0], note[1], note[2], note[3] = status, iterations, residual, theta
    value = orbit.event(orbit.params, t + theta * h, part(memory, 0, len(orbit.y)), orbit.free)
    if not abs(value) < 1e308 and note[0] == OK:
        note[0], note[1], note[2], note[3] = EVENT_NOT_FINITE, 0, value, theta
    return value


@helper
def polynomial_value(orbit: Any, node: int, theta: float, less: int) -> float:
    """Return the event's value along the whole step's polynomial, without its last `less` powers."""
    y, powers = orbit.y, orbit.powers
    count = len(powers) // orbit.rows
    for r in range(len(y)):
        total = 0.0
        for k in range(count - 1 - less, -1, -1):
            total = (total + powers[r * count + k]) * theta
        y[r] = orbit.states[node * orbit.rows + r] + total
    t, h = orbit.times[node], orbit.times[node + 1] - orbit.times[node]
    return orbit.event(orbit.params, t + theta * h, y, orbit.free)


@helper
def guessed_value(orbit: Any, node: int, theta: float, x: float, f: Any) -> float:
    """Return the event's value along the whole step's polynomial; without one, on the quartic at x."""
    if len(orbit.powers) == 0:
        return quartic(f, x)
    return polynomial_value(orbit, node, theta, 0)


@helper
def guess(orbit: Any, node: int, a: float, b: float, f: Any, rising: bool) -> tuple[float, float]:
    """Return about where the event is 0 between a and b, at whose ends its signs differ; its slope."""
    low, high, x = 0.0, 1.0, 0.5
    before, value_before, slope = 0.0, f[0], f[4] - f[0]
    for k in range(30):
        if slope != 0.0:
            x = before - value_before / slope
        if not low < x < high or k % 8 == 7:
            x = 0.5 * (low + high)
        value = guessed_value(orbit, node, a + (b - a) * x, x, f)
        if (value > 0.0) == rising:
            high = x
        else:
            low = x
        if abs(x - before) <= GUESSED:  # too near for a slope, which rounding would decide
            break
        slope = (value - value_before) / (x - before)
        before, value_before = x, value
    return a + (b - a) * x, slope / (b - a)


@helper
def root(orbit: Any, node: int, a: float, b: float, f: Any, rising: bool) -> float:
    """Return θ where the event is 0 between a and b, at whose ends its signs differ.

    By the secant method on the orbit, kept within the bracket.
    """
    begin(orbit, node)
    x, slope = guess(orbit, node, a, b, f, rising)
    before, value_before = x, 0.0
    for k in range(60):
        value = real_value(orbit, node, x)
        if value == 0.0 or orbit.note[0] != OK:
            return x
        if (value > 0.0) == rising:
            b = x
        else:
            a = x
        if k > 0 and abs(x - before) > ROUGH:
            slope = (value - value_before) / (x - before)
        before, value_before = x, value
        x = before - value / slope if slope != 0.0 else b
        if abs(x - before) <= NEAREST or b - a <= NEAREST:
            return before
        if not a < x < b or k % 8 == 7:
            x = 0.5 * (a + b)
    return before


@helper
def keep(orbit: Any, node: int, theta: float, sign: float, at: int, out: Any) -> None:
    """Write an event: its time, its direction, and the state that is in memory."""
    rows = orbit.rows
    row = part(out, at * (rows + 2), rows + 2)
    t, h = orbit.times[node], orbit.times[node + 1] - orbit.times[node]
    row[0], row[1] = t + theta * h, sign
    for r in range(rows):
        row[2 + r] = orbit.memory[r]


@helper
def met(
    orbit: Any, node: int, a: float, b: float, f: Any, roots: int, sign: float, direction: int,
    signs: Any, found: int, out: Any,
) -> int:  # fmt: skip
    """Take a part of a step with no root or one; return how many events have been found.

    `sign` is that before the root; without one that of the whole part.
    """
    if signs[0] == -sign and direction * sign >= 0.0:  # the root was where this part begins
        real_value(orbit, node, a)
        keep(orbit, node, a, sign, found, out)
        found += 1
    if roots == ONE:
        sign = -sign
        if direction * sign >= 0.0:
            theta = root(orbit, node, a, b, f, sign > 0.0)
            keep(orbit, node, theta, sign, found, out)
            found += 1
    signs[0] = sign
    return found


@helper
def look_along(
    orbit: Any, node: int, direction: int, signs: Any, f: Any, b: Any, values: Any, found: int,
    out: Any,
) -> int:  # fmt: skip
    """Find the events of a step along its polynomial, in two halves; return −1 if that is not clear.

    What the polynomial leaves out is estimated by its last powers, and by where it ends.
    """
    begin(orbit, node)
    values[0], values[8] = f[0], f[4]
    for k in range(1, 8):
        values[k] = polynomial_value(orbit, node, 0.125 * k, 0)
    tail = abs(polynomial_value(orbit, node, 1.0, 0) - f[4])
    for less in (1, 2):  # one may be small by chance
        tail = max(tail, abs(polynomial_value(orbit, node, 0.875, less) - values[7]) / less)
    rounding = ROUNDING * signs[1]
    tail += rounding
    # A middle whose sign is not known would be taken for a root there.
    clear = abs(values[4]) > tail
    for k in (0, 8):
        clear = clear and (abs(values[k]) > tail or abs(values[k]) <= rounding)
    for half in range(2):
        for k in range(FIVE):
            f[k] = values[4 * half + k]
        roots, _ = verdict(f, b, tail + of_quartic(f), tail)
        clear = clear and roots != UNCLEAR
    for half in range(2 if clear else 0):
        for k in range(FIVE):
            f[k] = values[4 * half + k]
        roots, sign = verdict(f, b, tail + of_quartic(f), tail)
        found = met(
            orbit, node, 0.5 * half, 0.5 * half + 0.5, f, roots, sign, direction, signs, found, out
        )
    return found if clear else -1


@helper
def halved(pieces: Any, at: int, low: float, high: float, f: Any, odd: Any) -> None:
    """Write both halves of a part, the first on top: its ends and five values each."""
    width = 2 + FIVE
    second, first = part(pieces, at * width, width), part(pieces, (at + 1) * width, width)
    middle = 0.5 * (low + high)
    first[0], first[1], second[0], second[1] = low, middle, middle, high
    for k in range(FIVE):
        first[2 + k] = f[k // 2] if k % 2 == 0 else odd[k // 2]
        second[2 + k] = f[2 + k // 2] if k % 2 == 0 else odd[2 + k // 2]


@helper
def search(
    orbit: Any, node: int, direction: int, signs: Any, pieces: Any, values: Any, found: int,
    out: Any,
) -> int:  # fmt: skip
    """Find the events of a step on the orbit itself, part by part; return how many there are then."""
    f, b = part(values, 0, FIVE), part(values, FIVE, FIVE)
    note, width = orbit.note, 2 + FIVE
    pieces[0], pieces[1] = 0.0, 1.0
    for k in range(FIVE):
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
            found = met(orbit, node, low, high, f, roots, sign, direction, signs, found, out)
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
    advance: Any, functions: Any, params: Any, coefficients: Any, fractions: Any, memory: Any,
    work: Any, rows: int, write: Any, table: Any, whole: Any, begun: Any, polynomial: Any,
    powers: Any, event: Any, linear: int, y: Any, free: Any, direction: int, states: Any,
    times: Any, first: int, signs: Any, scratch: Any, note: Any, room: int, out: Any,
) -> tuple[int, int, int, float]:  # fmt: skip
    """Write the events between nodes, from node `first` on: time, direction, state.

    Parameters
    ----------
    polynomial, powers : function, block
        The whole step's polynomial, see `geomint.methods.stepper.Between`, and room for it, or none.
    event, linear, y, free : function, int, block, block
        The event as an observable; whether it is linear in the state, so that its values are as smooth
        as that; room for a state as it takes it; its scratch.
    direction : int
        1: where it rises, −1: where it falls, 0: both.
    states, times : block
        Nodes, the first of which may be there for the interpolant alone.
    signs : block, shape (2,)
        The last sign that was not 0, or 0; the event's size: the largest value so far, or since it
        faded away. Changed.
    note : block, shape (NOTE,)
        What went wrong, and what is in memory.
    room : int
        Events that `out` has room for.

    Returns
    -------
    status, node, found, residual
        If there is no room for those of another step, the node to go on from.
    """
    orbit = Orbit(
        advance, functions, params, coefficients, fractions, memory, work, rows, write, table, whole,
        begun, polynomial, powers, event, y, free, states, times, note,
    )  # fmt: skip
    weights, values = part(scratch, 0, WEIGHTS), part(scratch, WEIGHTS, NODES)
    pieces = part(scratch, WEIGHTS + NODES, PIECES)
    nine = part(scratch, WEIGHTS + NODES + PIECES, 2 * FIVE)
    along = part(scratch, WEIGHTS + NODES + PIECES + 2 * FIVE, ALONG)
    f, b = part(nine, 0, FIVE), part(nine, FIVE, FIVE)
    note[0], note[4], note[5] = OK, -1.0, -1.0
    found, even = 0, False
    for node in range(max(first + 2 - NODES, 0), len(times)):
        for k in range(NODES - 1):
            values[k] = values[k + 1]
        for r in range(len(y)):
            y[r] = states[node * rows + r]
        values[NODES - 1] = event(params, times[node], y, free)
        if node <= first:
            continue
        before = node - 1
        if found + MOST_IN_STEP > room:
            return OK, before, found, 0.0
        f[0], f[4] = values[NODES - 2], values[NODES - 1]
        if not (abs(f[0]) < 1e308 and abs(f[4]) < 1e308):
            note[3] = 0.0 if not abs(f[0]) < 1e308 else 1.0
            return EVENT_NOT_FINITE, before, found, 0.0
        size = max(abs(f[0]), abs(f[4]))
        if size < FADED * signs[1]:  # fading away, or what is left of larger numbers
            made_of = conditioning(event, params, free, times[node], y)
            signs[1] = min(signs[1], max(size, max(made_of, SMALLEST)))
        signs[1] = max(signs[1], size)
        roots, sign, rounding = UNCLEAR, 0.0, ROUNDING * signs[1]
        if node >= NODES - 1:
            now = evenly(times, node)
            if not (even and now):
                write_weights(times, node, now, weights)
                even = now
            if linear:
                tail = look(values, weights, f)
            else:
                tail = look_closer(event, params, free, states, times, rows, node, weights, y, f)
            roots, sign = verdict(f, b, tail + rounding, rounding)
        earlier = found
        if roots != UNCLEAR:
            found = met(orbit, before, 0.0, 1.0, f, roots, sign, direction, signs, found, out)
        else:
            clear = -1
            if len(powers) > 0:
                clear = look_along(orbit, before, direction, signs, f, b, along, found, out)
            if clear >= 0:
                found = clear
            else:
                found = search(orbit, before, direction, signs, pieces, nine, found, out)
        for k in range(earlier, found):  # what is before a node is not at it, by rounding
            h = times[node] - times[before]
            if (out[k * (rows + 2)] - times[node]) * h >= 0.0:
                late = max(abs(times[node]) * 2.0**-52, abs(h) * 2.0**-53)
                out[k * (rows + 2)] = times[node] - (late if h > 0.0 else -late)
        if note[0] != OK:
            return int(note[0]), before, found, note[2]
    return OK, len(times) - 1, found, 0.0


_FIND: dict[str, Kind] = {
    **{name: kind for name, kind in BEGUN.items() if name != "span"},
    "polynomial": POLYNOMIAL,
    "powers": BLOCK,
    "event": VALUE,
    "linear": WHOLE,
    "y": BLOCK,
    "free": BLOCK,
    "direction": WHOLE,
    "states": BLOCK,
    "times": BLOCK,
    "first": WHOLE,
    "signs": BLOCK,
    "scratch": BLOCK,
    "note": BLOCK,
    "room": WHOLE,
    "out": BLOCK,
}


def events_in(functions: tuple[Bound, ...]) -> Bound:
    """Return `find` for a stepper that takes such functions."""
    return Bound(find, of_stepper((f.signature for f in functions), **_FIND))
