"""Functions of problems as methods take them: for eight numbers at once."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..arguments import Array
from ..errors import SpeedWarning, tell
from ..kernels.compiling.bound import Bound, written
from ..kernels.compiling.compiled import reason_of
from ..kernels.compiling.number_types import LANE
from ..kernels.compiling.recorded import Recorded, helper
from ..kernels.compiling.signatures import BLOCK, FIELD, NUMBER, OUT, SCRATCH, Kind
from ..kernels.numbers.arithmetic import lane
from ..kernels.numbers.blocks import LaneBlock, as_singles, part, set_lane
from ..kernels.numbers.lanes import LANES, Lanes
from ..problems.bound import given_at

if TYPE_CHECKING:
    from .posed import Posed


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


def in_lanes(f: Bound, p: Posed) -> tuple[Bound, int]:
    """Return a function of the problem for eight numbers at once, and its lane values of scratch.

    One that takes a number at a time is called for lane after lane, with a warning that says why.
    """
    fits = f.recorded.made(_tests(f)) if p.compiled else _takes_lanes(f, p)
    return (f.in_lanes, p.problem.work) if fits else _lane_by_lane(f, p.problem.work)


@functools.cache
def _lane_by_lane(f: Bound, work: int) -> tuple[Bound, int]:
    """Make a function for lanes of one that compiles for float64 only, and its lane values of scratch.

    Scratch holds blocks of one lane, after a lane value of what the function returns.
    """
    rows, taken = {**dict(f.rows), "work": work}, f.signature.arguments
    own, first = [], LANES
    for name, kind in taken:
        if kind in (BLOCK, OUT, SCRATCH):
            own.append(f"{name}_1 = part(singles, {first}, {rows[name]})")
            first += rows[name]

    def each(kind: Kind, text: str) -> str:
        return "; ".join(text.format(name) for name, known in taken if known is kind)

    texts: dict[Kind, str] = {BLOCK: "{}_1", OUT: "{}_1", SCRATCH: "{}_1", NUMBER: "lane({}, i)"}
    call = f"f({', '.join(texts.get(kind, '{}').format(name) for name, kind in taken)})"
    gives = f.signature.result is not None
    source = f"""def made({", ".join(f.signature.names)}):
        singles = as_singles(work)
        {"; ".join(own)}
        for i in range({LANES}):
            {each(BLOCK, "take_lane(i, {0}, {0}_1)")}
            {f"set_lane(work, 0, i, {call})" if gives else call}
            {each(OUT, "put_lane(i, {0}_1, {0})")}
        {"return work[0]" * gives}"""
    known = (as_singles, part, lane, set_lane, take_lane, put_lane)
    made = written(source, f.as_helper, **{g.__name__: g for g in known})
    return Bound(made, f.signature).in_lanes, -(-first // LANES)


def _takes_lanes(f: Bound, p: Posed) -> bool:
    """Tell whether a function takes eight numbers at once in plain Python, at the state."""
    rows = dict(f.rows)
    own = {"y": np.resize(p.state, rows.get("y", 0)), "out": rows.get("out", 0)}
    given = given_at(p.problem, p.state, t=Lanes(np.zeros(LANES)), **own)

    def held(numbers: Array) -> LaneBlock:
        return LaneBlock(np.repeat(numbers[:, None], LANES, axis=1))

    try:
        with np.errstate(all="ignore"):
            f.signature.run(f.recorded, held, **given)
    except (TypeError, ValueError):
        return False
    return True


def _tests(bound: Bound) -> Callable[[Recorded], bool]:
    """Return what tells of its function whether it compiles for lanes, and warns if not."""

    def compiles_for_lanes(f: Recorded) -> bool:
        try:
            bound.entry(number_type=LANE)
            return True
        except Exception as error:
            reason = reason_of(error.__cause__ or error, f)
        bound.entry()  # a function that compiles for neither is wrong
        what = "field" if bound.signature is FIELD else "function"
        text = (
            f"{what} {f.function.__name__!r} takes one number at a time, not eight, and runs slower: "
            f"{reason}; see geomint.field"
        )
        tell(SpeedWarning(text, f.function.__name__))
        return False

    compiles_for_lanes.__name__ += str(bound.rows)  # under which it is kept
    return compiles_for_lanes


@Recorded
def no_clock(params, t, y, work):  # type: ignore[no-untyped-def]
    """Return 0: a clock that stands still, for problems that have none."""
    return 0.0 * y[0]
