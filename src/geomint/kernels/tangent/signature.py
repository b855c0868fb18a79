"""What the sweeps of directions along a run have in common: the kinds of their arguments."""

from __future__ import annotations

from ..compiling.bound import Bound
from ..compiling.number_types import NumberType
from ..compiling.signatures import BLOCK, MEMORY, Functions, Kind, OfType, Signature, takes
from .normals import CONDITIONS

__all__ = ["sweep_signature"]

_BLOCKS = ("params", "coefficients", "fractions", "layout", "memory")


def sweep_signature(
    result: Kind | None,
    kernel: Bound,
    functions: tuple[Bound, ...],
    manifold: Bound,
    numbers: NumberType,
    **own,
) -> Signature:
    """Return the signature of a sweep: what carries directions along, then its own arguments.

    Parameters
    ----------
    kernel, functions, manifold : Bound, tuple of Bound, Bound
        A stepper's loop of `geomint.kernels.solve.advance`, what it is called with, the conditions of
        the manifold: all in tangent numbers.
    numbers : NumberType
        Those in which steps are taken.
    """
    memory = OfType(MEMORY, numbers)
    return takes(
        result,
        kernel=kernel.signature,
        functions=Functions(tuple(f.signature for f in functions)),
        manifold=manifold.signature,
        **dict.fromkeys(_BLOCKS, BLOCK),
        work=BLOCK,
        numbers=memory,
        plain=BLOCK,
        scratch=memory,
        conditions=OfType(BLOCK, CONDITIONS),
        conditions_plain=BLOCK,
        **own,
    )
