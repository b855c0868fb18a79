"""What the sweeps of directions along a run have in common: the kinds of their arguments."""

from ..compiling.bound import Bound
from ..compiling.number_types import NumberType
from ..compiling.recorded import Recorded
from ..compiling.signatures import BLOCK, MEMORY, Functions, OfType, Signature, of_header
from .normals import CONDITIONS


def sweep(
    loop: Recorded,
    kernel: Bound,
    functions: tuple[Bound, ...],
    manifold: Bound,
    numbers: NumberType,
    **own: Signature,
) -> Bound:
    """Return the loop of a sweep with its signature.

    Parameters
    ----------
    kernel, functions, manifold : Bound, tuple of Bound, Bound
        A stepper's loop of `geomint.kernels.solve.advance`, what it is called with, the conditions of
        the manifold: all in tangent numbers.
    numbers : NumberType
        Those in which steps are taken.
    own : Signature
        Of functions that this sweep alone takes.
    """
    taken = of_header(
        loop,
        kernel=kernel.signature,
        functions=Functions(tuple(f.signature for f in functions)),
        manifold=manifold.signature,
        conditions=OfType(BLOCK, CONDITIONS),
        **dict.fromkeys(("numbers", "scratch"), OfType(MEMORY, numbers)),
        **own,
    )
    return Bound(loop, taken)
