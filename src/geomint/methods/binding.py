"""A problem's functions, bound to its sizes and compiled for one kind of number.

A bound function has the row counts of its blocks as constants, which lets LLVM unroll its loops;
its signature is the same for all problems, so steppers are compiled once. All binders are cached:
the same function and sizes give the same recorded function, compiled once a process, and again when
what it reaches has changed: the bound function reaches what the given one does.
"""

from __future__ import annotations

import functools
import warnings
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import GeomintWarning
from ..kernels.compiling.compiled import compiled, reason_of
from ..kernels.compiling.recorded import Recorded
from ..kernels.numbers.arithmetic import lane
from ..kernels.numbers.blocks import Block, LaneBlock, as_scalars, fixed_rows, part
from ..kernels.numbers.lanes import LANES, Lanes

__all__ = [
    "bind_constraint",
    "bind_field",
    "bind_flow",
    "bind_gradients",
    "bind_value",
    "compiles_for_lanes",
    "lane_adapter",
    "no_clock",
    "runs_on_lanes",
    "with_clock",
]


def _renamed(function: Any, recorded: Recorded) -> Recorded:
    function.__name__ = function.__qualname__ = recorded.function.__name__
    return Recorded(function)


@functools.cache
def bind_field(f: Recorded, params_rows: int, rows: int, out_rows: int) -> Recorded:
    """Bind a field or a generator."""

    def bound(params, t, y, out, work):  # type: ignore[no-untyped-def]
        f(
            fixed_rows(params, params_rows),
            t,
            fixed_rows(y, rows),
            fixed_rows(out, out_rows),
            work,
        )

    return _renamed(bound, f)


@functools.cache
def bind_value(f: Recorded, params_rows: int, rows: int) -> Recorded:
    """Bind an invariant, an observable or a clock."""

    def bound(params, t, y, work):  # type: ignore[no-untyped-def]
        return f(fixed_rows(params, params_rows), t, fixed_rows(y, rows), work)

    return _renamed(bound, f)


@functools.cache
def bind_gradients(f: Recorded, params_rows: int, n: int) -> Recorded:
    """Bind the gradients of a Hamiltonian."""

    def bound(params, t, q, p, dq, dp, work):  # type: ignore[no-untyped-def]
        f(
            fixed_rows(params, params_rows),
            t,
            fixed_rows(q, n),
            fixed_rows(p, n),
            fixed_rows(dq, n),
            fixed_rows(dp, n),
            work,
        )

    return _renamed(bound, f)


@functools.cache
def bind_constraint(f: Recorded, params_rows: int, n: int, m: int) -> Recorded:
    """Bind the constraints and their Jacobian."""
    size = m * n

    def bound(params, q, g, G, work):  # type: ignore[no-untyped-def]
        f(
            fixed_rows(params, params_rows),
            fixed_rows(q, n),
            fixed_rows(g, m),
            fixed_rows(G, size),
            work,
        )

    return _renamed(bound, f)


@functools.cache
def bind_flow(f: Recorded, params_rows: int, rows: int) -> Recorded:
    """Bind the flows of a splitting's parts."""

    def bound(k, params, t, h, y, out, work):  # type: ignore[no-untyped-def]
        f(
            k,
            fixed_rows(params, params_rows),
            t,
            h,
            fixed_rows(y, rows),
            fixed_rows(out, rows),
            work,
        )

    return _renamed(bound, f)


@functools.cache
def with_clock(f: Recorded, clock: Recorded, params_rows: int, rows: int) -> Recorded:
    """Bind a field with one more row, whose derivative is the clock dt/dτ."""

    def bound(params, t, y, out, work):  # type: ignore[no-untyped-def]
        p = fixed_rows(params, params_rows)
        state = fixed_rows(part(y, 0, rows), rows)
        f(p, t, state, fixed_rows(part(out, 0, rows), rows), work)
        out[rows] = clock(p, t, state, work)

    return _renamed(bound, f)


@functools.cache
def lane_adapter(f: Recorded, rows: int, work_rows: int) -> Recorded:
    """Make a lane field of a field that compiles for float64 only: lane after lane."""

    def adapted(params, t, y, out, work):  # type: ignore[no-untyped-def]
        source = as_scalars(y)
        target = as_scalars(out)
        scratch = as_scalars(work)
        y1 = part(scratch, 0, rows)
        out1 = part(scratch, rows, rows)
        work1 = part(scratch, 2 * rows, work_rows)
        for i in range(LANES):
            for r in range(rows):
                y1[r] = source[r * LANES + i]
            f(params, lane(t, i), y1, out1, work1)
            for r in range(rows):
                target[r * LANES + i] = out1[r]

    return _renamed(adapted, f)


def compiles_for_lanes(f: Recorded) -> bool:
    """Tell whether a bound field compiles for lane values, and warn, with the reason, if not."""
    return bool(f.made(_compiles_for_lanes))


def _compiles_for_lanes(f: Recorded) -> bool:
    from ..kernels.compiling import signatures
    from ..kernels.compiling.compile import LANE, SCALAR

    try:
        compiled(f, signatures.field(LANE))
        return True
    except Exception as error:
        reason = reason_of(error.__cause__ or error, f)
    compiled(f, signatures.field(SCALAR))  # a field that compiles for neither is wrong
    warnings.warn(
        f"field {f.function.__name__!r} takes one number at a time, not eight, and runs slower: "
        f"{reason}; see geomint.field",
        GeomintWarning,
        stacklevel=8,
    )
    return False


def runs_on_lanes(f: Recorded, params: Block, y: npt.NDArray[np.float64], work: int) -> bool:
    """Tell whether a bound field, in plain Python, takes lane values."""
    lanes = LaneBlock(np.repeat(y[:, None], LANES, axis=1))
    out, scratch = (LaneBlock(np.zeros((size, LANES))) for size in (len(y), work))
    try:
        with np.errstate(all="ignore"):
            f(params, Lanes(np.zeros(LANES)), lanes, out, scratch)
    except (TypeError, ValueError):
        return False
    return True


@Recorded
def no_clock(params, t, y, work):  # type: ignore[no-untyped-def]
    """Return 0: a clock that stands still, for problems that have none."""
    return 0.0 * y[0]
