"""A stepper of any kind behind one signature, for what takes steps beside a run.

What looks for events takes ten seconds to compile. It would be compiled anew for every kind of stepper:
those of fields, of groups, of splittings take other functions. It gets their addresses instead.
"""

import functools

from ..compiling.bound import Bound
from ..compiling.number_types import SCALAR
from ..compiling.recorded import helper
from ..compiling.signatures import STEPPED, Signature, advance
from ..numbers.addresses import function_at, functions_at
from .status import Steps


@functools.cache
def by_address(functions: tuple[Signature, ...]) -> Bound:
    """Return what takes steps by a stepper that takes such functions: it gets their addresses.

    Its argument ``functions`` is the stepper, and after it those that the stepper takes.
    """
    from ..numbers.typing_addresses import kind_of

    kind = kind_of(advance(functions).of(SCALAR))

    def steps(
        functions, params, coefficients, fractions, memory, work, rows: int, t0: float, h: float,
        first: int, count: int, every: int, out, ranks,
    ) -> Steps:  # fmt: skip
        return function_at(functions, 0, kind)(
            functions_at(functions, kind), params, coefficients, fractions, memory, work, rows, t0,
            h, first, count, every, out, ranks,
        )  # fmt: skip

    return Bound(helper(steps), STEPPED)
