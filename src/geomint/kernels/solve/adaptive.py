"""The loop of adaptive steppers: tries, the error of each, and the step that follows from it.

A method's attempt has the signature ::

    attempt(functions, params, numbers, reuse, y, carry, first, known, work, t, h) -> (status, residual)

It changes neither the state y nor its carry, but writes to the scratch `work` (`adaptive_work`): the
increment of the state, its estimated error and a second estimate of lower order where there is one
(its rows are there in any case), and the last stage's derivative. `first` is the derivative at
(t, y): the attempt takes it as it is if `known` is 1, else computes and leaves it there. `reuse` says
that the last stage is the new value.

The problem's own time is one more row of the state, summed with compensation like the others and
handed out with them (`adaptive_memory`). Scalar numbers only: lanes would each need steps of their own.
"""

from collections import namedtuple

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.blocks import REST, part, section, sections
from .compensated import add_compensated
from .status import OK, STEP_TOO_SMALL, Step, Steps
from .step_control import error_size, logarithm, next_factor, retry_factor

Coefficients = namedtuple(
    "Coefficients", "rtol atol max_step end order estimates reuse pieces numbers"
)
Memory = namedtuple("Memory", "states carries next former smallest largest known first")
Work = namedtuple("Work", "increment errors last attempt")

HUGE = 1e300
MAX_REJECTIONS = 60
SPACINGS = 16.0 * 2.0**-52  # a step shorter than this, relative to t, does not advance it well
LEAST_FORMER = 1e-4  # an error much below the tolerance shall not weigh on the next step


@inlined
def adaptive_coefficients(n: int, numbers: int) -> Coefficients:
    """Return the layout of coefficients: the piece of each of n rows, the numbers of the method."""
    return Coefficients(1, 1, 1, 1, 1, 1, 1, n, numbers)


@inlined
def adaptive_memory(rows: int, derivative_rows: int) -> Memory:
    """Return the layout of memory; `rows` are those of the state and one of the time.

    Steps that the end of the run cuts short do not count as smallest or largest.
    """
    return Memory(rows, rows, 1, 1, 1, 1, 1, derivative_rows)


@inlined
def adaptive_work(n: int, derivative_rows: int, attempt: int) -> Work:
    """Return the layout of scratch: what an attempt tells, and its own."""
    return Work(n, 2 * n, derivative_rows, attempt)


def _step(attempt: Recorded) -> Recorded:
    @helper
    def step(functions, params, coefficients, memory, work, rows: int) -> Step:
        """Take one step as long as the tolerance allows; return (status, tries, residual)."""
        n = rows - 1
        given = sections(coefficients, adaptive_coefficients(n, REST))
        rtol, atol, order, end = given.rtol[0], given.atol[0], given.order[0], given.end[0]
        estimates, reuse = int(given.estimates[0]), int(given.reuse[0])
        states, carries, following, former, smallest, largest, known, first = sections(
            memory, adaptive_memory(rows, REST)
        )
        y, carry = part(states, 0, n), part(carries, 0, n)
        increment, errors, last, _ = sections(work, adaptive_work(n, len(first), REST))
        high, low = part(errors, 0, n), part(errors, n, n)
        t = states[n]
        remaining = (end - t) - carries[n]
        tries = 0
        failure = STEP_TOO_SMALL  # unless a try could not even be judged
        error = 0.0
        while True:
            h = following[0]
            ends = abs(remaining) <= abs(h)
            cut = abs(remaining) < 2.0 * abs(h)
            if ends:  # without the carry, if with it the sum is beyond the end
                h = remaining if (t + remaining - end) * remaining <= 0.0 else end - t
            elif cut:  # two equal steps, not one and a tiny rest
                h = 0.5 * remaining
            tiny = not ends and abs(h) < SPACINGS * abs(t)
            tries += 1
            status, error = attempt(
                functions, params, given.numbers, reuse, y, carry, first, int(known[0]), work, t, h
            )
            if status == OK:
                known[0] = 1.0
                error = error_size(rtol, atol, given.pieces, y, increment, high, low, estimates)
                if error <= 1.0 and not tiny:
                    break
            else:
                failure = status
            if tiny or tries > MAX_REJECTIONS:
                return failure, tries, error
            following[0] = retry_factor(order, error if status == OK else HUGE) * h
        for r in range(n):
            add_compensated(y, carry, r, increment[r])
        if ends:
            states[n] = end
            carries[n] = 0.0
        else:
            add_compensated(states, carries, n, h)
        if not cut:
            smallest[0] = min(abs(h), smallest[0])
            largest[0] = max(abs(h), largest[0])
        if reuse == 1:
            for r in range(len(first)):
                first[r] = last[r]
        known[0] = 1.0 * reuse
        factor = next_factor(order, error, former[0])
        if tries > 1:
            factor = min(factor, 1.0)
        longest = given.max_step[0]
        proposed = factor * h
        if ends and abs(proposed) < abs(following[0]):  # what an end leaves is no measure
            proposed = following[0]
        following[0] = min(max(proposed, -longest), longest)
        former[0] = logarithm(max(error, LEAST_FORMER))
        return OK, tries, error

    return step


def adaptive_stepper(attempt: Recorded) -> Recorded:
    """Return the loop of an adaptive method."""
    step = _step(attempt)

    def advance(
        functions, params, coefficients, fractions, memory, work, rows: int, t0: float, h: float,
        first: int, count: int, every: int, out, ranks,
    ) -> Steps:  # fmt: skip
        """Take up to `count` steps, none beyond the end; write every `every`-th state and the end's.

        Arguments and results are those of `geomint.kernels.solve.advance`, but that time and step
        are in `memory`, and that iterations are the tries, rejected ones included.
        """
        saved = 0
        tries = 0
        end = section(coefficients, adaptive_coefficients(rows - 1, REST), "end")[0]
        for k in range(count):
            if memory[rows - 1] == end:
                return OK, k, tries, 0.0
            status, used, residual = step(functions, params, coefficients, memory, work, rows)
            tries += used
            if status != OK:
                return status, k, tries, residual
            if (first + k + 1) % every == 0 or memory[rows - 1] == end:
                for r in range(rows):
                    out[saved * rows + r] = memory[r]
                saved += 1
        return OK, count, tries, 0.0

    advance.__name__ = attempt.function.__name__  # what "compiling …" says
    return helper(advance)
