"""Strang's composition of the flows of parts: with two parts, the method of Störmer and Verlet."""

import functools
from collections import namedtuple

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import like, maximum, top
from ..numbers.blocks import REST, sections
from .advance import stepper
from .compensated import add_compensated
from .status import NOT_FINITE, OK, Step

Coefficients = namedtuple("Coefficients", "rows parts clock_rows substeps merged")
Memory = namedtuple("Memory", "y clock carry clock_carry")
Work = namedtuple("Work", "increment owed scratch")

SPLITTING = Coefficients(1, 1, 1, 1, 1)  # the layout of coefficients


@inlined
def splitting_memory(rows: int, clock: int) -> Memory:
    """Return the layout of memory: state and clock, the carries of both."""
    return Memory(rows, clock, rows, clock)


@inlined
def splitting_work(rows: int, scratch: int) -> Work:
    """Return the layout of scratch: one increment, half a flow that is owed, the flows' own."""
    return Work(rows, 1, scratch)


@helper
def splitting_step(functions, params, coefficients, substep: int, memory, work, t, h) -> Step:
    """Compose ``φ_0(h/2) … φ_(m−2)(h/2) φ_(m−1)(h) φ_(m−2)(h/2) … φ_0(h/2)``.

    All flows get the middle of the step as their time. Of a composition the half flows of part 0 at
    the seam of two substeps are one flow, where `merged` says that no part depends on time; at the
    seam of two steps they are not, because the state between them is what is saved and observed.
    A clock row is moved by half a step before φ_(m−1) and by half after it: symmetric, so
    compositions raise its order too.
    """
    flow, clock = functions
    given = sections(coefficients, SPLITTING)
    rows, parts, clock_rows = int(given.rows[0]), int(given.parts[0]), int(given.clock_rows[0])
    merged = given.merged[0] > 0.0
    y, passed, carry, passed_carry = sections(memory, splitting_memory(rows, clock_rows))
    increment, owed, scratch = sections(work, splitting_work(rows, REST))
    middle = like(t + 0.5 * h, y[0])
    whole = like(h, y[0])
    half = 0.5 * whole
    first = half + owed[0] if merged and substep > 0 else half
    flows = 2 * parts - 1
    if merged and substep + 1 < int(given.substeps[0]):
        owed[0] = half
        flows -= 1
    worst = 0.0 * half
    for i in range(flows):
        k = min(i, 2 * parts - 2 - i)
        if clock_rows > 0 and k == parts - 1:
            by = half * clock(params, like(t, y[0]), y, scratch)
            worst = maximum(abs(by), worst)
            add_compensated(passed, passed_carry, 0, by)
        time = whole if k == parts - 1 else first if i == 0 else half
        flow(k, params, middle, time, y, increment, scratch)
        for r in range(rows):
            worst = maximum(abs(increment[r]), worst)
            add_compensated(y, carry, r, increment[r])
        if clock_rows > 0 and k == parts - 1:
            by = half * clock(params, like(t + h, y[0]), y, scratch)
            worst = maximum(abs(by), worst)
            add_compensated(passed, passed_carry, 0, by)
    largest = top(worst)
    if not largest < 1e300:
        return NOT_FINITE, 1, largest
    return OK, 1, 0.0


@functools.cache
def splitting_stepper() -> Recorded:
    """Return the stepper of splittings; it takes (flow, clock)."""
    return stepper(splitting_step)
