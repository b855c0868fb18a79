"""The orbit of a run between its nodes: real partial steps, and what is guessed of it.

A function of the state, an event, is looked at along it. What changes nothing of a run is in `Orbit`.
"""

from collections import namedtuple

from ..compiling.bound import Bound
from ..compiling.recorded import helper
from ..compiling.signatures import of_header
from ..numbers.arithmetic import top
from ..numbers.blocks import as_lanes, part
from .partial import one_step, whole_step
from .sign_changes import DECAYED, RESOLVED, UNKNOWN, looked_at, quartic
from .status import EVENT_NOT_FINITE, OK

NEAREST = 2.0**-48  # of a step: roots are met to this
ROUGH = 2.0**-40  # of a step: no slope is taken from values nearer to each other
# A root with a smaller slope, in parts of the values beside it over their distance, may be multiple.
PLAIN = 2.0**-10
MOST, FREE = 64, 16.0  # values at a root; how much wider than by bisection alone a bracket may be
GUESSED = 2.0**-30  # of a part: to this the first guess at a root is found
MOST_HALVED = 30  # halvings towards an end of a part
NEARBY = 2.0**-6  # of a step: a partial step begins on another one so near
# What went wrong: status, iterations, residual, θ; the node whose step is in `whole`; the node and the
# θ of the partial step that is in `memory`; the node whose step is known inside.
NOTE = 8
NINE = 9  # values at 0, ⅛, … 1; there is room for their differences beside them
DOUBT = 16.0  # times the difference of two interpolations: for one number it may be small by chance
INSIDE = 16  # numbers a row, see `geomint.methods.flow.Between`

# What does not change along a run: the stepper, the event, the nodes. What is remembered of the steps
# from the nodes, of the first ones or of none, and of the step before them. Where signs and events go.
Orbit = namedtuple(
    "Orbit",
    "advance functions params coefficients fractions memory work rows write table whole begun "
    "inside places known event component level y free direction states times memories before signs "
    "note nine out",
)


@helper
def conditioning(orbit, node: int, other: int, own: bool):
    """Return Σ |∂f/∂y_i| max |y| + |t ∂f/∂t| at a node: roundings of an orbit change f by ε times it.

    The largest number is that of both ends of a step, the `other` among them; with `own`, each number's
    own size is taken in its place. No time outside of the step is asked for.
    """
    y, rows, t = orbit.y, orbit.rows, orbit.times[node]
    tiny, total, largest = 2.0**-26, 0.0, 0.0
    for r in range(len(y)):
        y[r] = orbit.states[node * rows + r]
        largest = max(largest, max(abs(y[r]), abs(orbit.states[other * rows + r])))
    for r in range(len(y)):
        known = y[r]
        change = tiny * (abs(known) if own else largest)
        y[r] = known + change
        more = looked_at(orbit, t, y)
        y[r] = known - change
        total += abs(more - looked_at(orbit, t, y))
        y[r] = known
    span = orbit.times[other] - t
    change = min(tiny * abs(t), abs(span))
    if change > 0.0:
        later = looked_at(orbit, t + (change if span > 0.0 else -change), y)
        total += 2.0 * abs(later - looked_at(orbit, t, y)) * (tiny * abs(t) / change)
    total = 0.5 * total / tiny
    return total if total < 1e308 else 1e308


@helper
def begin(orbit, node: int):
    """Take the whole step from a node, on which partial ones begin, unless it is known."""
    note, size = orbit.note, len(orbit.whole)
    if note[4] == node:
        return
    note[4] = node
    if (node + 1) * size <= len(orbit.memories):
        for i in range(size):
            orbit.whole[i] = orbit.memories[node * size + i]
    elif len(orbit.table) > 0:
        whole_step(orbit, node, orbit.times[node + 1] - orbit.times[node])


@helper
def real_value(orbit, node: int, theta):
    """Return the event's value on the orbit, θ of a step from a node; leave the state in memory."""
    memory, rows, note = orbit.memory, orbit.rows, orbit.note
    h = orbit.times[node + 1] - orbit.times[node]
    t = orbit.times[node] + theta * h
    begin(orbit, node)
    if theta == 0.0 or theta == 1.0:
        at = node if theta == 0.0 else node + 1
        t = orbit.times[at]
        for r in range(rows):
            memory[r] = orbit.states[at * rows + r]
        note[5] = -1.0
    else:
        near = note[5] == node and abs(theta - note[6]) < NEARBY * note[6]
        known, part_of = (memory, theta / note[6]) if near else (orbit.whole, theta)
        status, iterations, residual = one_step(orbit, node, known, theta * h, part_of)
        note[5], note[6] = node, theta
        if status != OK:
            note[0], note[1], note[2], note[3] = status, iterations, residual, theta
    value = looked_at(orbit, t, part(memory, 0, len(orbit.y)))
    if not abs(value) < 1e308 and note[0] == OK:
        note[0], note[1], note[2], note[3] = EVENT_NOT_FINITE, 0, value, theta
    return value


@helper
def values_inside(orbit, node: int, first, last):
    """Write the event's values along a step from what is remembered of it; return their likely error.

    `UNKNOWN` where that is not known. States that are not known to a part of `RESOLVED`, and values to
    one of `DECAYED`, say nothing: those of a bounded function may agree by chance.
    """
    size, nine, inside = len(orbit.whole), orbit.nine, orbit.known
    if (node + 1) * size > len(orbit.memories) or (node == 0 and len(orbit.before) == 0):
        return UNKNOWN
    step = part(orbit.memories, node * size, size)
    past = orbit.before if node == 0 else part(orbit.memories, (node - 1) * size, size)
    y, at = orbit.y, node * orbit.rows
    component = orbit.component
    rows = len(y) if component < 0 else 1
    orbit.inside(step, past, orbit.places, orbit.rows, max(component, 0), rows, inside)
    nine[0], nine[8] = first, last
    largest, left = max(abs(first), abs(last)), 0.0
    if component >= 0:
        for k in range(7):
            nine[k + 1] = first + inside[k]
        both = as_lanes(inside, 0, 2)
        left = top(abs(both[0] - both[1]))
        largest = max(largest, top(abs(both[0] + first)))
    else:
        states, apart = 0.0, 0.0
        for r in range(rows):
            states = max(states, abs(orbit.states[at + r]))
            for k in range(7):
                apart = max(apart, abs(inside[INSIDE * r + k] - inside[INSIDE * r + 8 + k]))
        if not apart <= RESOLVED * states:
            return UNKNOWN
        t, h = orbit.times[node], 0.125 * (orbit.times[node + 1] - orbit.times[node])
        for k in range(7):
            for r in range(rows):
                y[r] = orbit.states[at + r] + inside[INSIDE * r + 8 + k]
            plain = looked_at(orbit, t + (k + 1) * h, y)
            for r in range(rows):
                y[r] = orbit.states[at + r] + inside[INSIDE * r + k]
            nine[k + 1] = looked_at(orbit, t + (k + 1) * h, y)
            left = max(left, abs(nine[k + 1] - plain))
            largest = max(largest, abs(nine[k + 1]))
    if not left <= DECAYED * largest:
        return UNKNOWN
    orbit.note[7] = node
    return DOUBT * left


@helper
def write_differences(nine):
    """Write the forward differences of nine values over their factorials, beside them."""
    for k in range(NINE):
        nine[NINE + k] = nine[k]
    for order in range(1, NINE):
        for k in range(NINE - 1, order - 1, -1):
            nine[NINE + k] = (nine[NINE + k] - nine[NINE + k - 1]) / order


@helper
def interpolated(nine, theta):
    """Return the value at θ of the polynomial through values at 0, ⅛, … 1, from their differences."""
    total = nine[2 * NINE - 1]
    for k in range(NINE - 2, -1, -1):
        total = nine[NINE + k] + (8.0 * theta - k) * total
    return total


@helper
def guessed_value(orbit, node: int, theta, x, f):
    """Return about the event's value: from those along the step, or else on the quartic at x."""
    return interpolated(orbit.nine, theta) if orbit.note[7] == node else quartic(f, x)


@helper
def clear_of(orbit, node: int, a, b, end, sign):
    """Return a part of the way from a to b where the event's sign is known to be that beside an end.

    At the end, 0 or 1, it is 0 to rounding: a search between there and the other sign may end there,
    although the root is inside.
    """
    away = 0.5
    for _ in range(MOST_HALVED):
        x = abs(end - away)
        value = real_value(orbit, node, a + (b - a) * x)
        if value * sign > 0.0 or orbit.note[0] != OK:
            return x
        away *= 0.5
    return end


@helper
def guess(orbit, node: int, a, b, f, low, high, rising: bool) -> tuple[float, float]:
    """Return about where the event is 0 on the way from a to b, between parts of it; the slope."""
    x = 0.5
    before, value_before, slope = 0.0, f[0], f[4] - f[0]
    if orbit.note[7] == node:
        write_differences(orbit.nine)
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
        if abs(x - before) <= GUESSED:
            break
        slope = (value - value_before) / (x - before)
        before, value_before = x, value
    away = 2.0**-16
    more = guessed_value(orbit, node, a + (b - a) * (x + away), x + away, f)
    less = guessed_value(orbit, node, a + (b - a) * (x - away), x - away, f)
    return a + (b - a) * x, 0.5 * (more - less) / (away * (b - a))


@helper
def crossing(orbit, node: int, a, b, x, slope, plain: bool, rising: bool):
    """Return θ where the event's sign turns to that after, which it has at b and not at a.

    The bracket decides, which no secant can keep from shrinking, in a few values more than bisection
    takes (I. F. D. Oliveira and R. H. C. Takahashi, ACM Trans. Math. Softw. 47 (2021) 5). Where the
    slope is `plain`, and stays about what it is at x, the last move does: at a multiple root moves
    get small far away from it. The sign of 0 is that before.
    """
    first, width = slope, FREE * (b - a)
    before, value_before = x, 0.0
    for k in range(MOST):
        value = real_value(orbit, node, x)
        if value > 0.0 if rising else value < 0.0:
            b, far = x, a - x
        else:
            a, far = x, b - x
        if k > 0 and abs(x - before) > ROUGH:
            slope = (value - value_before) / (x - before)
            plain = plain and abs(slope) > 0.25 * abs(first)
        share = -value / slope / far if slope != 0.0 else 0.5
        near = plain and abs(share * far) <= NEAREST
        if near or b - a <= NEAREST or orbit.note[0] != OK:
            return x
        before, value_before = x, value
        width *= 0.5
        x += far * (max(share, 0.5 * NEAREST / abs(far)) if share >= 0.0 else 0.5)
        reach = min(0.5 * (width - (b - a)), 0.5 * (b - a) - 0.25 * NEAREST)
        x = min(max(x, 0.5 * (a + b) - reach), 0.5 * (a + b) + reach)
    return before


@helper
def root(orbit, node: int, a, b, f, rising: bool, rounding):
    """Return θ where the event is 0 between a and b, with one sign before it and the other after."""
    begin(orbit, node)
    sign = 1.0 if rising else -1.0
    low = clear_of(orbit, node, a, b, 0.0, -sign) if abs(f[0]) <= rounding else 0.0
    high = clear_of(orbit, node, a, b, 1.0, sign) if abs(f[4]) <= rounding else 1.0
    x, slope = guess(orbit, node, a, b, f, low, high, rising)
    plain = abs(slope) * (b - a) > PLAIN * max(abs(f[0]), abs(f[4]))
    return crossing(orbit, node, a + (b - a) * low, a + (b - a) * high, x, slope, plain, rising)


@helper
def nothing(memory, before, places, rows: int, first: int, count: int, out):
    """Write nothing: where nothing is remembered of a step."""


INSIDE_STEP = of_header(nothing)


def bound_inside(inside=nothing) -> Bound:
    """Return a function that tells of a step inside, with its signature."""
    return Bound(inside, INSIDE_STEP)
