"""Gauss collocation for eight trajectories at once: their states in lanes, the stages in a loop.

The same map as that of `geomint.kernels.solve.gauss`, to rounding: the same coefficients, the same
criterion of an end, a compensated state whose carry enters the stages. There the lanes hold the
stages of one trajectory. Here each lane iterates until it has stagnated and then changes no more, so
that what it gives does not depend on the others.
"""

from __future__ import annotations

import functools
from collections import namedtuple
from typing import Any

from ..compiling.recorded import Recorded, helper, inlined
from ..numbers.arithmetic import like, maximum, select, top
from ..numbers.blocks import REST, part, section, sections
from .advance import stepper
from .compensated import add_compensated
from .fixed_point import (
    BEGINNING,
    COARSE,
    failure,
    finite,
    inverse_size,
    rounding_left,
    solved,
)
from .status import NOT_CONVERGED, OK

__all__ = [
    "gauss_trajectories_coefficients",
    "gauss_trajectories_memory",
    "gauss_trajectories_stepper",
    "gauss_trajectories_work",
]

Coefficients = namedtuple("Coefficients", "rows stages cap tolerance pieces c b mu")
Memory = namedtuple("Memory", "y carry increments")
Work = namedtuple("Work", "Y F inverse scratch")


@inlined
def gauss_trajectories_coefficients(rows: int, s: int, mu: int) -> Coefficients:
    """Return the layout of coefficients: the rows' pieces, c, b, μ row after row."""
    return Coefficients(rows=1, stages=1, cap=1, tolerance=1, pieces=rows, c=s, b=s, mu=mu)


@inlined
def gauss_trajectories_memory(rows: int, stages: int) -> Memory:
    """Return the layout of memory: the increments of the stages of all substeps are begun with."""
    return Memory(y=rows, carry=rows, increments=stages * rows)


@inlined
def gauss_trajectories_work(rows: int, scratch: int) -> Work:
    """Return the layout of scratch: a stage, its derivative, the scales, the field's own."""
    return Work(Y=rows, F=rows, inverse=rows, scratch=scratch)


@helper
def inverse_sizes(pieces: Any, y: Any, L: Any, stages: int, coarse: Any, inverse: Any) -> None:
    """Write 1 / (size of the row's piece) to the lanes that are `coarse`; 0 for rows of no piece."""
    rows = len(inverse)
    r = 0
    while r < rows:
        end = r
        size = 0.0 * y[r]
        while end < rows and pieces[end] == pieces[r]:
            size = maximum(abs(y[end]), size)
            for i in range(stages):
                size = maximum(abs(L[i * rows + end]), size)
            end += 1
        counts = 1.0 if pieces[r] >= 0.0 else 0.0
        by = counts * inverse_size(size)
        for i in range(r, end):
            inverse[i] = select(coarse > 0.0, by, inverse[i])
        r = end


@helper
def gauss_trajectories_step(
    functions: Any,
    params: Any,
    coefficients: Any,
    substep: int,
    memory: Any,
    work: Any,
    t: float,
    h: float,
) -> tuple[int, int, float]:
    """Solve ``L_i = h b_i f(t + c_i h, y + Σ_j μ_ij L_j)``, one stage after the other, and add ΣL."""
    field = functions[0]
    header = gauss_trajectories_coefficients(0, 0, REST)
    rows = int(section(coefficients, header, "rows")[0])
    stages = int(section(coefficients, header, "stages")[0])
    given = sections(coefficients, gauss_trajectories_coefficients(rows, stages, stages * stages))
    cap, tolerance, pieces = int(given.cap[0]), given.tolerance[0], given.pieces
    c, b, mu = given.c, given.b, given.mu
    y, carry, increments = sections(memory, gauss_trajectories_memory(rows, REST))
    L = part(increments, substep * stages * rows, stages * rows)
    Y, F, inverse, scratch = sections(work, gauss_trajectories_work(rows, REST))
    zero = 0.0 * y[0]
    last = like(BEGINNING, y[0])
    before = like(BEGINNING, y[0])
    going = like(1.0, y[0])  # 0 in the lanes that have converged
    coarse = like(1.0, y[0])  # 1 in the lanes whose sizes are still to be found
    for iteration in range(cap):
        if top(coarse) > 0.0:
            inverse_sizes(pieces, y, L, stages, coarse, inverse)
        delta = zero
        for i in range(stages):
            for r in range(rows):
                total = zero
                for j in range(stages):
                    total += mu[i * stages + j] * L[j * rows + r]
                Y[r] = y[r] + (carry[r] + total)
            field(params, like(t + c[i] * h, y[0]), Y, F, scratch)
            for r in range(rows):
                new = (h * b[i]) * F[r]
                old = L[i * rows + r]
                delta = maximum(abs(new - old) * inverse[r], delta)
                L[i * rows + r] = select(going > 0.0, new, old)
        worst = top(delta)
        if not finite(worst):
            return failure(iteration), iteration + 1, worst
        rounding = rounding_left(delta, zero)
        done = solved(delta, last, before, tolerance, rounding, iteration + 1 == cap)
        going = select(done, zero, going)
        if top(going) == 0.0:
            for r in range(rows):
                total = zero
                for i in range(stages // 2):
                    total += L[i * rows + r] + L[(stages - 1 - i) * rows + r]
                if stages % 2 == 1:
                    total += L[stages // 2 * rows + r]
                add_compensated(y, carry, r, total)
            return OK, iteration + 1, worst
        coarse = select(delta > COARSE, going, zero)
        before = last
        last = delta
    return NOT_CONVERGED, cap, top(last)


@functools.cache
def gauss_trajectories_stepper() -> Recorded:
    """Return the stepper of Gauss methods for trajectories in lanes; it takes (field)."""
    return stepper(gauss_trajectories_step)
