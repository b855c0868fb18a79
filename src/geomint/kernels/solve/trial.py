"""Trials of a step: two runs from one state, and how far they part.

The stepper's loop is handed over by its address, as in `geomint.kernels.solve.partial`.
"""

from ..compiling.bound import Bound
from ..compiling.recorded import helper
from ..compiling.signatures import of_header, of_stepper
from ..numbers.blocks import part
from .status import OK, Steps


@helper
def parting(coarse, fine, rows: int, count: int, factor: float, y0, ends, sizes, errors):
    """Write for each of `count` states the largest deviation, relative to the size of its piece.

    States have `rows` numbers, the first of which are those of y0. Deviations are differences over
    `factor`. Pieces end at `ends`; the size of one is its largest
    number in y0 or along `fine`, or that of all where it is 0.
    """
    whole = 0.0
    for r in range(len(y0)):
        largest = abs(y0[r])
        for k in range(count):
            largest = max(largest, abs(fine[k * rows + r]))
        sizes[r] = largest
        whole = max(whole, largest)
    first = 0
    for p in range(len(ends)):
        last = int(ends[p])
        largest = 0.0
        for r in range(first, last):
            largest = max(largest, sizes[r])
        for r in range(first, last):
            sizes[r] = largest or whole or 1.0
        first = last
    for k in range(count):
        errors[k] = 0.0
        for r in range(len(y0)):
            off = (coarse[k * rows + r] - fine[k * rows + r]) / factor
            error = abs(off) / sizes[r]
            if error > errors[k] or error != error:  # which stays
                errors[k] = error


@helper
def trial(
    advance, functions, params, coefficients, fractions, memory, work, rows: int, t: float,
    h: float, shorter: float, coarse: int, fine: int, out, count: int, factor: float, y0, ends,
    sizes, errors,
) -> Steps:  # fmt: skip
    """Write `count` states of a run by steps `h`, and of one by `shorter` ones, and how they part.

    States are those after every `coarse` steps, and `fine` shorter ones.

    Returns
    -------
    status, runs, iterations, residual
        Iterations of the first run, if both succeed.
    """
    size = count * rows
    first = 0
    for k in range(2):
        for r in range(len(memory)):
            memory[r] = 0.0
        for r in range(len(y0)):
            memory[r] = y0[r]
        every = coarse if k == 0 else fine
        status, _, iterations, residual = advance(
            functions, params, coefficients, fractions, memory, work, rows, t,
            h if k == 0 else shorter, 0, count * every, every, part(out, k * size, size),
            part(fractions, 0, 0),
        )  # fmt: skip
        if status != OK:
            return status, k, iterations, residual
        if k == 0:
            first = iterations
    both = part(out, 0, size), part(out, size, size)
    parting(both[0], both[1], rows, count, factor, y0, ends, sizes, errors)
    return OK, 2, first, 0.0


@helper
def stretches(
    advance, functions, params, coefficients, fractions, memory, work, rows: int, t: float,
    lengths, counts, again: int, y0, out, ends, sizes, errors,
) -> Steps:  # fmt: skip
    """Write the states after stretches of `counts` steps of such `lengths`, one after the other.

    Each begins with the state alone that the one before has led to; the first one, and that of number
    `again`, with y0 at t. The first states are compared with the last ones, as many as there are
    `errors`, as by `parting`.
    """
    n, time = len(y0), t
    for k in range(len(counts)):
        for r in range(len(memory)):
            memory[r] = 0.0
        for r in range(n):
            memory[r] = y0[r] if k == 0 or k == again else out[(k - 1) * n + r]
        time = t if k == again else time
        count = int(counts[k])
        if count > 0:
            status, _, iterations, residual = advance(
                functions, params, coefficients, fractions, memory, work, rows, time, lengths[k], 0,
                count, count + 1, part(out, 0, 0), part(fractions, 0, 0),
            )  # fmt: skip
            if status != OK:
                return status, k, iterations, residual
        time += count * lengths[k]
        for r in range(n):
            out[k * n + r] = memory[r]
    for k in range(len(errors)):
        one, other = part(out, k * n, n), part(out, (len(counts) - len(errors) + k) * n, n)
        parting(one, other, n, 1, 1.0, y0, ends, sizes, part(errors, k, 1))
    return OK, len(counts), 0, 0.0


PARTING = Bound(parting, of_header(parting))
TRIAL = Bound(trial, of_stepper(trial))
STRETCHES = Bound(stretches, of_stepper(stretches))
