"""Observables along saved states, and functions at many points."""

import functools

from ..compiling.bound import Bound
from ..compiling.number_types import SCALAR
from ..compiling.recorded import helper
from ..compiling.signatures import ADDRESSES, FIELD, of_header
from ..numbers.addresses import function_at
from ..numbers.blocks import part


@functools.cache
def sampler() -> Bound:
    """Return what evaluates functions ``f(params, t, y, out, work)`` at many states."""
    from ..numbers.typing_addresses import kind_of

    kind = kind_of(FIELD.of(SCALAR))

    def sample(
        values, functions: int, params, times, states, stride: int, rows: int, count: int, work,
        out, width: int,
    ):  # fmt: skip
        """Write `width` numbers of each function for `count` states, `stride` rows apart."""
        for k in range(functions):
            f = function_at(values, k, kind)
            for i in range(count):
                y, row = part(states, i * stride, rows), part(out, (k * count + i) * width, width)
                f(params, times[i], y, row, work)

    recorded = helper(sample)
    return Bound(recorded, of_header(recorded, values=ADDRESSES))
