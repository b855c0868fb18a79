"""How often a function changes its sign in an interval, told from values with known errors.

The quartic through five equally spaced values is written by Bernstein's polynomials, whose coefficients
bound it: all of one sign, by more than the errors, no root; one change of sign, one root. Where only
the ends of a step are known, the values between are interpolated through those at the last eight nodes.
"""

from ..compiling.recorded import helper, inlined
from ..numbers.blocks import part

NODES = 8  # of the interpolant
STEEP = 32.0  # how much faster than b an error may rise from an end, where it is 0
DECAYED = 2.0**-6  # of the largest value
RESOLVED = 2.0**-7  # of the state's size
UNKNOWN = float("inf")  # an error
MARGIN = 2.0  # of the estimated error of interpolation
NONE, ONE, UNCLEAR = 0, 1, 2
FIVE = 5
WEIGHTS = 7 * NODES  # at ¼, ½, ¾; at ½ without one, two, three nodes; the places they are for


@inlined
def bernstein(f, out):
    """Write Bernstein's coefficients of the quartic through five values, equally spaced."""
    out[0] = f[0]
    out[1] = (-13.0 * f[0] + 48.0 * f[1] - 36.0 * f[2] + 16.0 * f[3] - 3.0 * f[4]) / 12.0
    out[2] = (13.0 * f[0] - 64.0 * f[1] + 120.0 * f[2] - 64.0 * f[3] + 13.0 * f[4]) / 18.0
    out[3] = (-3.0 * f[0] + 16.0 * f[1] - 36.0 * f[2] + 48.0 * f[3] - 13.0 * f[4]) / 12.0
    out[4] = f[4]


@helper
def verdict(f, b, tail, rounding) -> tuple[int, float]:
    """Return how many roots there are, `NONE`, `ONE` or `UNCLEAR`, and the sign before them.

    The ends are values, known to `rounding`; what lies between is known to `tail`. An end that is 0 is
    no root here: whether the sign has changed is seen by what comes after.
    """
    bernstein(f, b)
    first, last, changes = 0.0, 0.0, 0
    doubtful, unclear = 0, False
    for k in range(FIVE):
        inside = 0 < k < FIVE - 1
        limit = tail if inside else rounding
        if (k == 1 and abs(b[0]) <= tail) or (k == FIVE - 2 and abs(b[FIVE - 1]) <= tail):
            limit = STEEP * tail
        if abs(b[k]) <= limit:
            doubtful += int(inside)
            continue
        sign = 1.0 if b[k] > 0.0 else -1.0
        if sign == last:
            unclear = unclear or doubtful > 0
        elif last == 0.0:
            first, unclear = sign, doubtful > 0
        else:
            changes += 1
            unclear = unclear or doubtful > 1  # one is between both signs, or has one of them
        last, doubtful = sign, 0
    if last == 0.0 or doubtful > 0 or unclear or changes > 1:
        return UNCLEAR, first
    return (ONE if changes == 1 else NONE), first


@helper
def quartic(f, x):
    """Return the quartic through values at 0, ¼, ½, ¾, 1."""
    s = 4.0 * x
    d1, d2 = f[1] - f[0], f[2] - 2.0 * f[1] + f[0]
    d3 = f[3] - 3.0 * f[2] + 3.0 * f[1] - f[0]
    d4 = f[4] - 4.0 * f[3] + 6.0 * f[2] - 4.0 * f[1] + f[0]
    inner = (s - 2.0) / 3.0 * (d3 + (s - 3.0) / 4.0 * d4)
    return f[0] + s * (d1 + (s - 1.0) / 2.0 * (d2 + inner))


@helper
def lagrange(places, first: int, count: int, t, out):
    """Write the weights at t of the interpolation through `count` places from `first` on."""
    for j in range(count):
        weight = 1.0
        for k in range(count):
            if k != j:
                span = places[first + j] - places[first + k]
                weight *= (t - places[first + k]) / span
        out[j] = weight


@helper
def write_weights(times, last: int, even: bool, weights):
    """Write all weights between the node before `last` and it, of the eight nodes that end there.

    Those of equally spaced nodes are for 0 … 7: times differ by their rounding, and weights that are
    kept for many steps would be those of the first of a chunk.
    """
    places = part(weights, 6 * NODES, NODES)
    for k in range(NODES):
        places[k] = 1.0 * k if even else times[last + 1 - NODES + k]
    begin, span = places[NODES - 2], places[NODES - 1] - places[NODES - 2]
    for k in range(3):
        at = begin + 0.25 * (k + 1) * span
        lagrange(places, 0, NODES, at, part(weights, k * NODES, NODES))
    for less in (1, 2, 3):
        lower = part(weights, (2 + less) * NODES, NODES)
        for k in range(less):
            lower[k] = 0.0
        lagrange(places, less, NODES - less, begin + 0.5 * span, part(lower, less, NODES - less))


@helper
def evenly(times, last: int) -> bool:
    """Tell whether the eight nodes that end there are equally spaced."""
    span = times[last] - times[last - 1]
    for k in range(last + 1 - NODES, last - 1):
        if abs(times[k + 1] - times[k] - span) > 1e-9 * abs(span):
            return False
    return True


@inlined
def blended(values, first: int, stride: int, weights, k: int):
    """Return the sum of eight values, from `first` on, with the weights of set k."""
    total = 0.0
    for j in range(NODES):
        total += weights[k * NODES + j] * values[first + j * stride]
    return total


@helper
def look(values, weights, f):
    """Write the values within the last of seven steps; return their error, estimated."""
    size = 0.0
    for k in range(NODES):
        size = max(size, abs(values[k]))
    for k in range(3):
        f[k + 1] = blended(values, 0, 1, weights, k)
    seven, six = blended(values, 0, 1, weights, 3), blended(values, 0, 1, weights, 4)
    left = left_out(f[2], seven, six, blended(values, 0, 1, weights, 5))
    return MARGIN * left + of_quartic(f) if left <= DECAYED * size else UNKNOWN


@inlined
def looked_at(orbit, t, y):
    """Return the event's value at a state: a component, or what the function gives, less the level."""
    at = orbit.component
    value = y[at] if at >= 0 else orbit.event(orbit.params, t, y, orbit.free)
    return value - orbit.level


@helper
def look_closer(orbit, last: int, weights, f):
    """Write the values at interpolated states: a function may do more than its values at nodes show.

    States that are not known to a part of `RESOLVED` say nothing: values of a bounded function may
    then agree by chance.
    """
    y, rows, states = orbit.y, orbit.rows, orbit.states
    first = (last + 1 - NODES) * rows
    begin, span = orbit.times[last - 1], orbit.times[last] - orbit.times[last - 1]
    seven, six, five, size, left = 0.0, 0.0, 0.0, 0.0, 0.0
    for r in range(len(y)):
        y[r] = blended(states, first + r, rows, weights, 1)
        size = max(size, abs(y[r]))
        left = max(left, abs(y[r] - blended(states, first + r, rows, weights, 3)))
    if left > RESOLVED * size:
        return UNKNOWN
    for k in range(6):
        for r in range(len(y)):
            y[r] = blended(states, first + r, rows, weights, k)
        value = looked_at(orbit, begin + 0.25 * (k + 1 if k < 3 else 2) * span, y)
        if k < 3:
            f[k + 1] = value
        elif k == 3:
            seven = value
        elif k == 4:
            six = value
        else:
            five = value
    return MARGIN * left_out(f[2], seven, six, five) + of_quartic(f)


@inlined
def left_out(eight, seven, six, five):
    """Return the error of interpolation from lower orders.

    From several: at an extremum the odd derivatives vanish, and just there crossings would be missed.
    """
    return MARGIN * abs(eight - seven) + abs(seven - six) + abs(six - five)


@inlined
def of_quartic(f):
    """Return the error of the quartic, from its fourth and third differences for the same reason."""
    fourth = f[4] - 4.0 * f[3] + 6.0 * f[2] - 4.0 * f[1] + f[0]
    third = f[4] - 2.0 * f[3] + 2.0 * f[1] - f[0]
    return 0.25 * abs(fourth) + 0.03 * abs(third)
