"""Commutator-free steps: products of exponentials of sums of stage generators."""

import functools
from collections import namedtuple

from ..compiling.recorded import Recorded, inlined
from ..numbers.arithmetic import like, maximum, top
from ..numbers.blocks import REST, part, section, sections
from .advance import stepper, with_maps
from .compensated import add_compensated, compensated_state
from .status import NOT_FINITE, OK, Step

Coefficients = namedtuple(
    "Coefficients", "rows algebra_rows stages layout_rows field_work layout c flows"
)
Work = namedtuple("Work", "xi moves v Y step field_scratch scratch")


@inlined
def commutator_free_coefficients(layout_rows: int, stages: int, flows: int) -> Coefficients:
    """Return the layout of coefficients: sizes, the group's own `layout`, c, flows.

    A flow is for each stage, and for the update: its start (the stage whose value it starts from; −1:
    y), its number of exponentials, and the coefficients of each. Sizes lie where they do in any.
    """
    return Coefficients(1, 1, 1, 1, 1, layout_rows, stages, flows)


@inlined
def commutator_free_work(rows: int, m: int, stages: int, field_work: int, scratch: int) -> Work:
    """Return the layout of scratch: generators, moves of stages and update, exponent, value, move."""
    return Work(stages * m, (stages + 1) * rows, m, rows, rows, field_work, scratch)


@inlined
def combine_generators(table, at: int, stages: int, xi, algebra_rows: int, h, v):
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
    def commutator_free(
        generator, maps, params, coefficients, substep: int, memory, work, t, h
    ) -> Step:
        """Build the stages and the update as moves: the differences of their values from the state.

        Summed before they are added to the state, moves lose nothing to its rounding.
        """
        act = maps[0]
        header = commutator_free_coefficients(0, 0, REST)
        layout_rows = int(section(coefficients, header, "layout_rows")[0])
        stages = int(section(coefficients, header, "stages")[0])
        given = sections(coefficients, commutator_free_coefficients(layout_rows, stages, REST))
        n = rows if rows > 0 else int(given.rows[0])
        d = m if m > 0 else int(given.algebra_rows[0])
        layout, c, table = given.layout, given.c, given.flows
        y, carry = sections(memory, compensated_state(n))
        own = commutator_free_work(n, d, stages, int(given.field_work[0]), REST)
        xi, moves, v, Y, step, field_scratch, scratch = sections(work, own)
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
                    move[r] += step[r]
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

    return stepper(with_maps(commutator_free, act))
