"""Commutator-free steps: products of exponentials of sums of stage generators."""

from __future__ import annotations

import functools
from typing import Any

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import like, maximum, top
from ..numbers.blocks import part
from .advance import stepper
from .compensated import add_compensated
from .status import NOT_FINITE, OK

__all__ = ["commutator_free_stepper", "commutator_free_work_size"]

# coefficients: rows, algebra rows, stages, length of layout, rows of scratch of the generator;
# then layout, c, and for each stage and the update: start (stage whose value it starts from; −1: y),
# number of exponentials, and the coefficients of each.
HEADER = 5


def commutator_free_work_size(
    rows: int, algebra_rows: int, stages: int, field_work: int, group_work: int
) -> int:
    """Rows of scratch: generators, moves of the stages and update, exponent, value, increment."""
    own = stages * algebra_rows + (stages + 1) * rows + algebra_rows + 2 * rows
    return own + field_work + group_work


@inlined
def combine_generators(
    table: Any, at: int, stages: int, xi: Any, algebra_rows: int, h: float, v: Any
) -> None:
    """Write ``v = h Σ_j table[at + j] ξ_j``."""
    for r in range(algebra_rows):
        total = 0.0 * v[r]
        for j in range(stages):
            if table[at + j] != 0.0:
                total += table[at + j] * xi[j * algebra_rows + r]
        v[r] = h * total


@functools.cache
def commutator_free_stepper(act: Recorded | None, rows: int, m: int) -> Recorded:
    """Return the stepper of commutator-free methods.

    Parameters
    ----------
    act : Recorded or None
        The action, to be compiled in; the stepper takes (generator,). With None it takes
        (generator, act).
    rows, m : int
        Numbers of rows of states and of the algebra, as constants that unroll the loops over them,
        or 0: any.
    """

    @inlined
    def commutator_free_step(
        generator: Any,
        act: Any,
        params: Any,
        coefficients: Any,
        memory: Any,
        work: Any,
        t: float,
        h: float,
    ) -> tuple[int, int, float]:
        """Build the stages and the update as moves: the differences of their values from the state.

        Summed before they are added to the state, moves lose nothing to its rounding.
        """
        n = rows if rows > 0 else int(coefficients[0])
        d = m if m > 0 else int(coefficients[1])
        stages = int(coefficients[2])
        layout = part(coefficients, HEADER, int(coefficients[3]))
        field_work = int(coefficients[4])
        at = HEADER + len(layout)
        c = part(coefficients, at, stages)
        table = part(coefficients, at + stages, len(coefficients) - at - stages)
        y = part(memory, 0, n)
        carry = part(memory, n, n)
        xi = part(work, 0, stages * d)
        used = stages * d
        moves = part(work, used, (stages + 1) * n)
        used += (stages + 1) * n
        v = part(work, used, d)
        Y = part(work, used + d, n)
        step = part(work, used + d + n, n)
        used += d + 2 * n
        field_scratch = part(work, used, field_work)
        used += field_work
        scratch = part(work, used, len(work) - used)
        for r in range(d):
            v[r] = 0.0 * y[0]
        worst = 0.0 * y[0]
        at = 0
        for i in range(stages + 1):
            start = int(table[at])
            exponentials = int(table[at + 1])
            at += 2
            move = part(moves, i * n, n)
            for r in range(n):
                move[r] = 0.0 * y[r] if start < 0 else moves[start * n + r]
                Y[r] = y[r] + move[r]
            for _ in range(exponentials):
                combine_generators(table, at, stages, xi, d, h, v)
                at += stages
                act(layout, v, Y, step, scratch)
                for r in range(n):
                    move[r] = move[r] + step[r]
                    Y[r] = y[r] + move[r]
            if i < stages:
                generator_out = part(xi, i * d, d)
                generator(params, like(t + c[i] * h, y[0]), Y, generator_out, field_scratch)
                for r in range(d):
                    worst = maximum(abs(generator_out[r]), worst)
        for r in range(n):
            worst = maximum(abs(moves[stages * n + r]), worst)
        largest = top(worst)
        if not largest < 1e300:
            return NOT_FINITE, 1, largest
        for r in range(n):
            add_compensated(y, carry, r, moves[stages * n + r])
        return OK, 1, 0.0

    if act is None:

        def commutator_free(functions, p, c, substep, memory, work, t, h):
            return commutator_free_step(functions[0], functions[1], p, c, memory, work, t, h)

        return stepper(helper(commutator_free), 2)

    def commutator_free_in(functions, p, c, substep, memory, work, t, h):
        return commutator_free_step(functions[0], act, p, c, memory, work, t, h)

    return stepper(helper(commutator_free_in), 1)
