"""The derivatives of a field by the state at eight stages at once, exact: by tangent numbers."""

import functools

from ..compiling.recorded import Recorded, inlined
from ..numbers.arithmetic import like
from ..numbers.blocks import part
from ..numbers.tangent import as_tangents

DIRECTIONS = 2  # at once: more of them leave registers, as stages are in lanes beside them


@inlined
def jacobian_evaluations(rows: int) -> int:
    """Return how many evaluations of the field those of its Jacobians are counted as."""
    return (rows + DIRECTIONS - 1) // DIRECTIONS * (1 + DIRECTIONS)


def jacobian_scratch(rows: int, work: int) -> int:
    """Return the lane values of scratch for a field with so many rows of its own."""
    return (1 + DIRECTIONS) * (2 * rows + work)


@functools.cache
def jacobians_of(field: Recorded) -> Recorded:
    """Return ``jacobians(params, t, y, out, work)``, which takes and gives lane values.

    `out` gets ∂f_i/∂y_j in row ``i n + j``, where `y` has n rows.
    """

    def jacobians(params, t, y, out, work):
        n, each = len(y), 1 + DIRECTIONS
        numbers = as_tangents(work, DIRECTIONS)
        own, found = part(numbers, 0, n), part(numbers, n, n)
        scratch = part(numbers, 2 * n, len(numbers) - 2 * n)
        one, zero = like(1.0, y[0]), like(0.0, y[0])
        for r in range(n):
            work[each * r] = y[r]
        for first in range(0, n, DIRECTIONS):
            for r in range(n):
                for k in range(DIRECTIONS):
                    work[each * r + 1 + k] = one if r == first + k else zero
            field(params, like(t, own[0]), own, found, scratch)
            for r in range(n):
                for k in range(min(DIRECTIONS, n - first)):
                    out[r * n + first + k] = work[each * (n + r) + 1 + k]

    jacobians.__name__ = f"jacobians_of_{field.function.__name__}"
    return Recorded(jacobians)
