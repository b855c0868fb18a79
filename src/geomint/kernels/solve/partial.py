"""Partial steps: states between the steps of a run, by real steps of its method from the step before.

A state so found is as accurate as the run, on the manifold if the method's states are, and the run
knows nothing of it. It depends on the state and the step there alone, not on chunks, nor on what else
is asked for. The stepper's loop is handed over by its address: nothing of a method is compiled anew,
and these kernels are the same for all methods.
"""

from collections import namedtuple

from ..compiling.bound import Bound
from ..compiling.recorded import helper, inlined
from ..compiling.signatures import VALUE, of_header, of_stepper
from ..numbers.blocks import part
from .status import OK, Step, Steps

CLOCK_CAP = 50  # iterations
# Of a step: a state is moved so far along the step's polynomial instead of by another step, if it has
# powers enough and what its slope misses, which the clock's own rate tells, is unseen then. The clock
# may be known better than the state by chance: at 2⁻²⁹ |γ| = 1 was off by 1e-14, with two powers too.
SHIFTED = 2.0**-34
ENOUGH = 4
UNSEEN = 2.0**-56


@helper
def cold(coefficients, table, theta: float):
    """Do nothing: where a partial step begins with nothing."""


@helper
def none(memory, table, rows: int, out):
    """Write nothing: where there is no polynomial."""


# What takes steps from nodes, and how they begin.
Drive = namedtuple(
    "Drive",
    "advance functions params coefficients fractions memory work rows write table whole begun states "
    "times",
)


@inlined
def whole_step(s, node: int, h):
    """Leave in the `whole` memory what a step of length h leaves, from a node on; 0 if it fails."""
    whole, at = s.whole, node * s.rows
    for r in range(len(whole)):
        whole[r] = 0.0
    for r in range(s.rows):
        whole[r] = s.states[at + r]
    status, _, _, _ = s.advance(
        s.functions, s.params, s.begun, s.fractions, whole, s.work, s.rows, s.times[node], h, 0, 1, 2,
        s.work, part(s.fractions, 0, 0),
    )  # fmt: skip
    if status != OK:
        for r in range(len(whole)):
            whole[r] = 0.0


@inlined
def one_step(s, node: int, known, h, theta) -> Step:
    """Leave in `memory` what a step of length h from a node leaves, begun on what is `known` of it."""
    memory, rows, at = s.memory, s.rows, node * s.rows
    for r in range(rows):
        memory[r] = s.states[at + r]
        memory[rows + r] = 0.0
    for r in range(2 * rows, len(memory)):
        memory[r] = known[r]
    s.write(s.coefficients, s.table, theta)
    status, _, iterations, residual = s.advance(
        s.functions, s.params, s.coefficients, s.fractions, memory, s.work, rows, s.times[node], h, 0,
        1, 2, s.work, part(s.fractions, 0, 0),
    )  # fmt: skip
    return status, iterations, residual


@helper
def partial(
    advance, functions, params, coefficients, fractions, memory, work, rows: int, write, table,
    whole, begun, span: float, states, times, nodes, lengths, count: int, out,
) -> Steps:  # fmt: skip
    """Write `count` states, each by a step of its length from its node; one of length 0 is the node.

    Parameters
    ----------
    write, table, whole, begun, span : function, block, block, block, float
        How partial steps begin, see `geomint.methods.flow.Between`, or `cold` with an empty table;
        memory and coefficients of the whole step from a node, which is as long as the way to the next
        node, or `span` from the last.
    states, times : block
        The nodes: states one after the other, `rows` numbers each, and their times.
    nodes, lengths : block, shape (count,)
        From which node, a whole number, and how far.

    Returns
    -------
    status, done, iterations, residual
    """
    drive = Drive(
        advance, functions, params, coefficients, fractions, memory, work, rows, write, table, whole,
        begun, states, times,
    )  # fmt: skip
    last = -1
    length = span
    for i in range(count):
        node = int(nodes[i])
        if lengths[i] == 0.0:
            for r in range(rows):
                out[i * rows + r] = states[node * rows + r]
            continue
        if node != last and len(table) > 0:
            length = times[node + 1] - times[node] if node + 1 < len(times) else span
            whole_step(drive, node, length)
        last = node
        status, iterations, residual = one_step(drive, node, whole, lengths[i], lengths[i] / length)
        if status != OK:
            return status, i, iterations, residual
        for r in range(rows):
            out[i * rows + r] = memory[r]
    return OK, count, 0, 0.0


@inlined
def first_guess(x, begin, end, pace, last, span):
    """Return how far from the node the clock shows x: by cubic Hermite interpolation of the inverse."""
    slope, after = (end - begin) / (pace * span), (end - begin) / (last * span)
    s = (x - begin) / (end - begin)
    guess = s * s * (3.0 - 2.0 * s) + s * (1.0 - s) * ((1.0 - s) * slope - s * after)
    return span * (guess if 0.0 < guess < 1.0 else s)


@inlined
def better_guess(powers, gain, theta):
    """Return where a polynomial without constant is `gain`, by Newton's method from near there."""
    for _ in range(5):
        value, slope = 0.0, 0.0
        for k in range(len(powers) - 1, -1, -1):
            value = (value + powers[k]) * theta
            slope = slope * theta + (k + 1) * powers[k]
        theta += (gain - value) / slope
    return theta


@inlined
def slope_of(powers, first: int, count: int, theta):
    """Return the derivative at θ of a polynomial without constant, whose powers begin at `first`."""
    slope = 0.0
    for k in range(count - 1, -1, -1):
        slope = slope * theta + (k + 1) * powers[first + k]
    return slope


@inlined
def shift(memory, powers, theta, change, row):
    """Write the state in memory, at θ of a step, moved along the step's polynomial."""
    count = len(powers) // len(row)
    for r in range(len(row)):
        row[r] = memory[r] + change * slope_of(powers, r * count, count, theta)


@helper
def to_clock(
    advance, functions, params, coefficients, fractions, memory, work, rows: int, write, table,
    whole, begun, span: float, polynomial, powers, rate, states, times, nodes, wanted, roundings,
    count: int, scratch, lengths, out,
) -> Steps:  # fmt: skip
    """Write `count` states at times of the clock, their last row, and how long the steps to them are.

    Newton's iteration for the length, the derivative being the clock's `rate`; the best state is kept,
    or one that is a real step but for a rounding of its length (`SHIFTED`).

    Parameters
    ----------
    polynomial, powers : function, block
        The whole step's polynomial, see `geomint.methods.flow.Between`, and room for it.
    wanted, roundings : block, shape (count,)
        Times of the clock, and how near is near enough: implicit steps of a length in the last bits of
        the time would only add noise.
    """
    drive = Drive(
        advance, functions, params, coefficients, fractions, memory, work, rows, write, table, whole,
        begun, states, times,
    )  # fmt: skip
    last, each = -1, len(powers) // rows
    length, end, pace, end_pace = span, 0.0, 0.0, 0.0
    for i in range(count):
        node = int(nodes[i])
        known = part(states, node * rows, rows)
        row = part(out, i * rows, rows)
        for r in range(rows):
            row[r] = known[r]
        smallest = abs(wanted[i] - known[rows - 1])
        best = 0.0
        if smallest > roundings[i]:
            if node != last:
                length = times[node + 1] - times[node] if node + 1 < len(times) else span
                whole_step(drive, node, length)
                end = whole[rows - 1]
                pace = rate(params, times[node], part(known, 0, rows - 1), scratch)
                end_pace = rate(params, times[node] + length, part(whole, 0, rows - 1), scratch)
                polynomial(whole, table, rows, powers)
            last = node
            far = first_guess(wanted[i], known[rows - 1], end, pace, end_pace, length)
            if len(table) > 0:
                clock = part(powers, (rows - 1) * each, each)
                far = length * better_guess(clock, wanted[i] - known[rows - 1], far / length)
            if not 0.0 < far / length <= 1.0:
                far = (wanted[i] - known[rows - 1]) / pace
            theta = far / length
            for k in range(CLOCK_CAP):
                status, iterations, residual = one_step(
                    drive, node, whole if k == 0 else memory, far, theta
                )
                if status != OK:
                    lengths[i] = far
                    return status, i, iterations, residual
                missing = wanted[i] - memory[rows - 1]
                if abs(missing) < smallest:
                    smallest, best = abs(missing), far
                    for r in range(rows):
                        row[r] = memory[r]
                elif abs(missing) <= roundings[i]:
                    break
                now = rate(params, times[node] + far, part(memory, 0, rows - 1), scratch)
                change = missing / now
                if abs(missing) <= 0.5 * roundings[i] or far + change == far:
                    break
                if each >= ENOUGH and abs(change) <= SHIFTED * abs(length):
                    slope = slope_of(powers, (rows - 1) * each, each, far / length)
                    if abs(change * (slope / (now * length) - 1.0)) <= UNSEEN * abs(length):
                        shift(memory, powers, far / length, change / length, row)
                        best = far + change
                        break
                theta = (far + change) / far  # the next one begins on this one
                far += change
        row[rows - 1] = wanted[i]
        lengths[i] = best
    return OK, count, 0, 0.0


WRITE = of_header(cold)
_POLYNOMIAL = of_header(none)
PARTIAL = Bound(partial, of_stepper(partial, write=WRITE))
TO_CLOCK = Bound(to_clock, of_stepper(to_clock, write=WRITE, polynomial=_POLYNOMIAL, rate=VALUE))


def bound_write(write=cold) -> Bound:
    """Return a function that changes coefficients, with its signature."""
    return Bound(write, WRITE)


def bound_polynomial(polynomial=none) -> Bound:
    """Return a function that writes a polynomial, with its signature."""
    return Bound(polynomial, _POLYNOMIAL)
