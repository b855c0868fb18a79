"""Fields as methods take them: for eight numbers at once."""

from __future__ import annotations

import functools
from collections import namedtuple

import numpy as np
import numpy.typing as npt

from ..kernels.compiling.bound import Bound
from ..kernels.compiling.compiled import reason_of
from ..kernels.compiling.number_types import LANE, SCALAR
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import FIELD
from ..kernels.numbers.arithmetic import lane
from ..kernels.numbers.blocks import Block, LaneBlock, as_singles, sections, set_lane
from ..kernels.numbers.lanes import LANES, Lanes
from ..problems.spaces.repair import warn
from .method import Start

__all__ = ["lane_field", "lane_functions", "no_clock"]


Work = namedtuple("Work", "y out work padding")


def _adapter_work(rows: int, work: int) -> Work:
    """Return the layout of an adapter's scratch, in whole lane values of single numbers."""
    return Work(y=rows, out=rows, work=work, padding=-(2 * rows + work) % LANES)


@functools.cache
def _adapted(f: Recorded, rows: int, work_rows: int) -> Bound:
    """Make a lane field of a field that compiles for float64 only: lane after lane."""
    layout = _adapter_work(rows, work_rows)

    def adapted(params, t, y, out, work):  # type: ignore[no-untyped-def]
        y1, out1, work1, _ = sections(as_singles(work), layout)
        for i in range(LANES):
            for r in range(rows):
                y1[r] = lane(y[r], i)
            f(params, lane(t, i), y1, out1, work1)
            for r in range(rows):
                set_lane(out, r, i, out1[r])

    adapted.__name__ = adapted.__qualname__ = f.function.__name__
    return Bound(Recorded(adapted), FIELD)


def lane_field(
    field: Bound,
    params: npt.NDArray[np.float64],
    y: npt.NDArray[np.float64],
    work: int,
    compiled: bool,
) -> tuple[Bound, int]:
    """Return a field for eight numbers at once, and the lane values of scratch that it needs.

    One that takes a number at a time is called for lane after lane, with a warning that says why.
    """
    f = field.recorded
    if f.made(_compiles_for_lanes) if compiled else _runs_on_lanes(f, Block(params), y, work):
        return field.in_lanes, work
    return _adapted(f, len(y), work).in_lanes, sum(_adapter_work(len(y), work)) // LANES


def _compiles_for_lanes(f: Recorded) -> bool:
    field = Bound(f, FIELD)
    try:
        field.entry(number_type=LANE)
        return True
    except Exception as error:
        reason = reason_of(error.__cause__ or error, f)
    field.entry(number_type=SCALAR)  # a field that compiles for neither is wrong
    warn(
        f"field {f.function.__name__!r} takes one number at a time, not eight, and runs slower: "
        f"{reason}; see geomint.field"
    )
    return False


def _runs_on_lanes(f: Recorded, params: Block, y: npt.NDArray[np.float64], work: int) -> bool:
    """Tell whether a bound field, in plain Python, takes lane values."""
    lanes = LaneBlock(np.repeat(y[:, None], LANES, axis=1))
    out, scratch = (LaneBlock(np.zeros((size, LANES))) for size in (len(y), work))
    try:
        with np.errstate(all="ignore"):
            f(params, Lanes(np.zeros(LANES)), lanes, out, scratch)
    except (TypeError, ValueError):
        return False
    return True


def lane_functions(
    functions: tuple[Bound, ...], s: Start, n: int, m: int
) -> tuple[tuple[Bound, ...], int]:
    """Return (gradients, constraint, clock) for eight numbers at once, and their rows of scratch.

    """
    return tuple(f.in_lanes for f in functions), s.problem.work


@Recorded
def no_clock(params, t, y, work):  # type: ignore[no-untyped-def]
    """Return 0: a clock that stands still, for problems that have none."""
    return 0.0 * y[0]
