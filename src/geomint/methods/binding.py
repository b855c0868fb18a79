"""Fields as methods take them: for eight numbers at once."""

import functools
from collections import namedtuple
from collections.abc import Callable

import numpy as np

from ..arguments import Array
from ..errors import SpeedWarning, tell
from ..kernels.compiling.bound import Bound
from ..kernels.compiling.compiled import reason_of
from ..kernels.compiling.number_types import LANE, SCALAR
from ..kernels.compiling.recorded import Recorded, helper
from ..kernels.compiling.signatures import FIELD, Signature
from ..kernels.numbers.arithmetic import lane
from ..kernels.numbers.blocks import Block, LaneBlock, as_singles, sections, set_lane
from ..kernels.numbers.lanes import LANES, Lanes

Work = namedtuple("Work", "y out work padding")


def _adapter_work(rows: int, work: int) -> Work:
    """Return the layout of an adapter's scratch, in whole lane values of single numbers."""
    return Work(rows, rows, work, -(2 * rows + work) % LANES)


@helper
def take_lane(i, rows, out):  # type: ignore[no-untyped-def]
    """Write one lane of all rows."""
    for r in range(len(out)):
        out[r] = lane(rows[r], i)


@helper
def put_lane(i, numbers, out):  # type: ignore[no-untyped-def]
    """Write numbers into one lane of all rows."""
    for r in range(len(out)):
        set_lane(out, r, i, numbers[r])


@functools.cache
def _adapted(f: Recorded, rows: int, work_rows: int) -> Bound:
    """Make a lane field of a field that compiles for float64 only: lane after lane."""
    layout = _adapter_work(rows, work_rows)

    def adapted(params, t, y, out, work):  # type: ignore[no-untyped-def]
        y1, out1, work1, _ = sections(as_singles(work), layout)
        for i in range(LANES):
            take_lane(i, y, y1)
            f(params, lane(t, i), y1, out1, work1)
            put_lane(i, out1, out)

    adapted.__name__ = adapted.__qualname__ = f.function.__name__
    return Bound(Recorded(adapted), FIELD)


def lane_field(
    field: Bound, params: Array, y: Array, work: int, compiled: bool
) -> tuple[Bound, int]:
    """Return a field for eight numbers at once, and the lane values of scratch that it needs.

    One that takes a number at a time is called for lane after lane, with a warning that says why.
    """
    f, out, scratch = field.recorded, np.zeros(len(y)), np.zeros(work)
    if takes_lanes(field, params, compiled, y=y, out=out, work=scratch):
        return field.in_lanes, work
    return _adapted(f, len(y), work).in_lanes, sum(_adapter_work(len(y), work)) // LANES


def takes_lanes(f: Bound, params: Array, compiled: bool, **blocks: Array) -> bool:
    """Tell whether a function takes eight numbers at once; if not, warn and say why.

    `blocks` are what it is tried on in plain Python, by name.
    """
    if compiled:
        return f.recorded.made(_tests(f.signature))
    values = {"params": Block(params), "t": Lanes(np.zeros(LANES))}
    for name, numbers in blocks.items():
        values[name] = LaneBlock(np.repeat(numbers[:, None], LANES, axis=1))
    try:
        with np.errstate(all="ignore"):
            f.recorded(*(values[name] for name, _ in f.signature.arguments))
    except (TypeError, ValueError):
        return False
    return True


@functools.cache
def _tests(signature: Signature) -> Callable[[Recorded], bool]:
    """Return what tells of a function of that signature whether it compiles for lanes."""

    def compiles_for_lanes(f: Recorded) -> bool:
        bound = Bound(f, signature)
        try:
            bound.entry(number_type=LANE)
            return True
        except Exception as error:
            reason = reason_of(error.__cause__ or error, f)
        bound.entry(number_type=SCALAR)  # a function that compiles for neither is wrong
        what = "field" if signature is FIELD else "function"
        text = (
            f"{what} {f.function.__name__!r} takes one number at a time, not eight, and runs slower: "
            f"{reason}; see geomint.field"
        )
        tell(SpeedWarning(text, f.function.__name__))
        return False

    return compiles_for_lanes


@Recorded
def no_clock(params, t, y, work):  # type: ignore[no-untyped-def]
    """Return 0: a clock that stands still, for problems that have none."""
    return 0.0 * y[0]
