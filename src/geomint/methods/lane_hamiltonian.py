"""The Hamiltonian form for eight numbers at once, also of functions that take one at a time."""

import functools
from collections import namedtuple

import numpy as np

from ..kernels.compiling.bound import Bound
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import CONSTRAINT, GRADIENTS, VALUE
from ..kernels.numbers.arithmetic import lane
from ..kernels.numbers.blocks import as_singles, part, section, sections, set_lane
from ..kernels.numbers.lanes import LANES
from .binding import put_lane, take_lane, takes_lanes
from .posed import Posed

Work = namedtuple("Work", "q p first second work result")


def lane_hamiltonian(p: Posed) -> tuple[tuple[Bound, ...], int, int, int]:
    """Return (gradients, constraint, clock), all in lanes; n, m, and lane values of scratch."""
    functions, n, m = p.hamiltonian
    work, params, y = p.problem.work, p.problem.params, p.state
    out, scratch = np.zeros(n), np.zeros(work)
    blocks = (
        {"q": y[:n], "p": y[n:], "dq": out, "dp": out},
        {"q": y[:n], "g": np.zeros(m), "G": np.zeros(m * n)},
        {"y": y},
    )
    fit = [
        takes_lanes(f, params, p.compiled, work=scratch, **given)
        for f, given in zip(functions, blocks, strict=True)
    ]
    if all(fit):
        return tuple(f.in_lanes for f in functions), n, m, work
    layout = _adapter_work(n, m, work)
    adapted = _adapted(*(f.recorded for f in functions), layout)
    return tuple(f.in_lanes for f in adapted), n, m, sum(layout) // LANES


def _adapter_work(n: int, m: int, work: int) -> Work:
    """Return the layout of scratch for a function of one state, and for a lane value of results."""
    results = max(n, m * n)
    used = 2 * n + 2 * results + work
    return Work(n, n, results, results, work + -used % LANES, LANES)


@functools.cache
def _adapted(
    gradients: Recorded, constraint: Recorded, clock: Recorded, layout: Work
) -> tuple[Bound, ...]:
    """Make functions for lanes of functions that compile for float64 only: lane after lane."""

    def lane_gradients(params, t, q, p, dq, dp, work):
        q1, p1, dq1, dp1, work1, _ = sections(as_singles(work), layout)
        for i in range(LANES):
            take_lane(i, q, q1)
            take_lane(i, p, p1)
            gradients(params, lane(t, i), q1, p1, dq1, dp1, work1)
            put_lane(i, dq1, dq)
            put_lane(i, dp1, dp)

    def lane_constraint(params, q, g, G, work):
        q1, _, g1, G1, work1, _ = sections(as_singles(work), layout)
        for i in range(LANES):
            take_lane(i, q, q1)
            constraint(params, q1, g1, G1, work1)
            put_lane(i, g1, g)
            put_lane(i, G1, G)

    def lane_clock(params, t, y, work):
        singles, last = as_singles(work), len(work) - 1
        y1, work1 = part(singles, 0, len(y)), section(singles, layout, "work")
        for i in range(LANES):
            take_lane(i, y, y1)
            set_lane(work, last, i, clock(params, lane(t, i), y1, work1))
        return work[last]

    made = ((lane_gradients, GRADIENTS), (lane_constraint, CONSTRAINT), (lane_clock, VALUE))
    return tuple(Bound(Recorded(f), signature) for f, signature in made)
