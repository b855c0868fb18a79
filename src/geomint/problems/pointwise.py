"""Functions at many points, compiled: maps that are no vector fields, as fast as those.

What has no steps, such as an exact flow or a change of coordinates, is written once, for one point,
with the rules of `geomint.field`, and evaluated here for as many as are wanted.
"""

from typing import Any

import numpy as np

from ..arguments import MOST_NUMBERS, Array, as_array, switch, whole
from ..errors import DomainError
from ..kernels.compiling.bound import Bound
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import MAP
from ..kernels.numbers.blocks import Block, scalar_block
from ..kernels.solve.sample import sampler
from .watched_call import watched_call

_fitting: set[tuple[str, int, int, int, int]] = set()
BATCH = 4096  # points of one call, between which Ctrl-C is seen


def pointwise(
    function: Recorded, params: Any, points: Any, rows: int, work: int = 0, *, check: bool = True
) -> Array:
    """Return the values of a function at points.

    Parameters
    ----------
    function : recorded ``f(params, t, x, out, work)``
        Recorded by `geomint.field`; it writes its value at x to `out`. t is 0.
    params : array_like
        Flat.
    points : array_like, shape (..., width)
    rows : int
        Length of a value.
    work : int
        Rows of scratch that the function needs.
    check : bool
        Whether the function is run in plain Python first, once for each set of sizes. Only for
        functions that are known to fit, where that takes long.

    Returns
    -------
    array, shape (..., rows)

    Raises
    ------
    geomint.DomainError
        For points of shape ().
    geomint.DeclarationError
        If the function does not fit the sizes that are given: it is run once at the first point, in
        plain Python, as those of problems are (`geomint.problems.declaration`).
    """
    x = np.ascontiguousarray(as_array("points", points))
    if np.ndim(points) == 0:
        raise DomainError("points", points, "an array whose last axis is a point")
    width, shape = x.shape[-1], x.shape[:-1]
    count = int(np.prod(shape))
    rows = whole("rows", rows, 0, MOST_NUMBERS // max(count, 1))
    work = whole("work", work, 0, MOST_NUMBERS)
    flat, out = x.reshape(-1), np.empty(count * rows)
    block, scratch = Block(as_array("params", params).reshape(-1)), scalar_block(work)
    if count and switch("check", check):
        _check(function, block.data, flat[:width], rows, work)
    sweep = sampler().call(
        values=(Bound(function, MAP),),
        functions=1,
        params=block,
        times=Block(np.zeros(min(count, BATCH))),
        stride=width,
        rows=width,
        work=scratch,
        width=rows,
    )
    for first in range(0, count, BATCH):
        number = min(BATCH, count - first)
        given = Block(flat[first * width : (first + number) * width])
        result = Block(out[first * rows : (first + number) * rows])
        sweep(states=given, out=result, count=number)
    return out.reshape(*shape, rows)


def _check(function: Recorded, params: Array, x: Array, rows: int, work: int) -> None:
    """Raise `DeclarationError` unless the function fits those sizes, which is remembered."""
    key = (function.fingerprint, len(params), len(x), rows, work)
    if key in _fitting:
        return
    given = {"params": params, "t": np.float64(0.0), "x": x, "out": rows, "work": work}
    watched_call(None, function.function.__name__, function, MAP, given)
    _fitting.add(key)
