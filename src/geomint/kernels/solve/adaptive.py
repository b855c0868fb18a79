"""The loop of adaptive steppers: tries, the error of each, and the step that follows from it.

A method's attempt has the signature ::

    attempt(functions, params, numbers, reuse, y, carry, first, known, work, t, h) -> (status, residual)

It changes neither the state y nor its carry, but writes to the scratch `work`, in this order: the
increment of the state, its estimated error, a second estimate of lower order where there is one (its
rows are there in any case), and the last stage's derivative. `first` is the derivative at (t, y): the
attempt takes it as it is if `known` is 1, else computes and leaves it there. `reuse` says that the
last stage is the new value.

The problem's own time is one more row of the state, summed with compensation like the others and
handed out with them. `memory` is the state, the carries, then what `REMEMBERED` numbers, then
`first`. Scalar numbers only: lanes would each need steps of their own.
"""

from __future__ import annotations

from typing import Any

from ..compiling.recorded import Recorded, helper
from ..numbers.blocks import part
from .advance import entry_of
from .compensated import add_compensated
from .status import OK, STEP_TOO_SMALL
from .step_control import error_size, logarithm, next_factor, retry_factor

__all__ = ["END", "LARGEST", "NEXT", "REMEMBERED", "SMALLEST", "adaptive_stepper"]

# coefficients: these, the piece of each row of the state, the numbers of the method.
RTOL, ATOL, MAX_STEP, END, ORDER, ESTIMATES, REUSE, CONTROLS = 0, 1, 2, 3, 4, 5, 6, 7
# memory after state and carries; steps that the end of the run cuts short do not count as smallest
# or largest.
NEXT, FORMER, SMALLEST, LARGEST, KNOWN, REMEMBERED = 0, 1, 2, 3, 4, 5

HUGE = 1e300
MAX_REJECTIONS = 60
SPACINGS = 16.0 * 2.0**-52  # a step shorter than this, relative to t, does not advance it well
LEAST_FORMER = 1e-4  # an error much below the tolerance shall not weigh on the next step


def _step(attempt: Recorded) -> Recorded:
    @helper
    def step(
        functions: Any, params: Any, coefficients: Any, memory: Any, work: Any, rows: int
    ) -> tuple[int, int, float]:
        """Take one step as long as the tolerance allows; return (status, tries, residual)."""
        n = rows - 1
        pieces = part(coefficients, CONTROLS, n)
        numbers = part(coefficients, CONTROLS + n, len(coefficients) - CONTROLS - n)
        estimates = int(coefficients[ESTIMATES])
        reuse = int(coefficients[REUSE])
        order = coefficients[ORDER]
        states = part(memory, 0, rows)
        carries = part(memory, rows, rows)
        y = part(memory, 0, n)
        carry = part(memory, rows, n)
        control = part(memory, 2 * rows, REMEMBERED)
        first = part(memory, 2 * rows + REMEMBERED, len(memory) - 2 * rows - REMEMBERED)
        increment = part(work, 0, n)
        last = part(work, 3 * n, len(first))
        t = states[n]
        remaining = (coefficients[END] - t) - carries[n]
        tries = 0
        failure = STEP_TOO_SMALL  # unless a try could not even be judged
        error = 0.0
        while True:
            h = control[NEXT]
            ends = abs(remaining) <= abs(h)
            cut = abs(remaining) < 2.0 * abs(h)
            if ends:
                h = remaining
            elif cut:  # two equal steps, not one and a tiny rest
                h = 0.5 * remaining
            tiny = not ends and abs(h) < SPACINGS * abs(t)
            tries += 1
            known = int(control[KNOWN])
            status, error = attempt(
                functions, params, numbers, reuse, y, carry, first, known, work, t, h
            )
            if status == OK:
                control[KNOWN] = 1.0
                error = error_size(
                    coefficients[RTOL],
                    coefficients[ATOL],
                    pieces,
                    y,
                    increment,
                    part(work, n, n),
                    part(work, 2 * n, n),
                    estimates,
                )
                if error <= 1.0 and not tiny:
                    break
            else:
                failure = status
            if tiny or tries > MAX_REJECTIONS:
                return failure, tries, error
            control[NEXT] = retry_factor(order, error if status == OK else HUGE) * h
        for r in range(n):
            add_compensated(y, carry, r, increment[r])
        if ends:
            states[n] = coefficients[END]
            carries[n] = 0.0
        else:
            add_compensated(states, carries, n, h)
        if not cut:
            control[SMALLEST] = min(abs(h), control[SMALLEST])
            control[LARGEST] = max(abs(h), control[LARGEST])
        if reuse == 1:
            for r in range(len(first)):
                first[r] = last[r]
        control[KNOWN] = 1.0 * reuse
        factor = next_factor(order, error, control[FORMER])
        if tries > 1:
            factor = min(factor, 1.0)
        longest = coefficients[MAX_STEP]
        proposed = factor * h
        control[NEXT] = min(max(proposed, -longest), longest)
        control[FORMER] = logarithm(max(error, LEAST_FORMER))
        return OK, tries, error

    return step


def _loop(attempt: Recorded) -> Recorded:
    step = _step(attempt)

    @helper
    def advance(
        functions: Any,
        params: Any,
        coefficients: Any,
        fractions: Any,
        memory: Any,
        work: Any,
        rows: int,
        t0: float,
        h: float,
        first: int,
        count: int,
        every: int,
        out: Any,
    ) -> tuple[int, int, int, float]:
        """Take up to `count` steps, none beyond the end; write every `every`-th state and the end's.

        Arguments and results are those of `geomint.kernels.solve.advance`, but that time and step
        are in `memory`, and that iterations are the tries, rejected ones included.
        """
        saved = 0
        tries = 0
        end = coefficients[END]
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

    return advance


def adaptive_stepper(attempt: Recorded, functions: int) -> Recorded:
    """Return the entry of an adaptive method with `functions` functions."""
    return entry_of(_loop(attempt), functions, attempt.function.__name__)
