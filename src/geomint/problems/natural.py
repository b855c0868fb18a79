"""Natural systems as splittings: a kick, and the free motion, which is straight or a great circle."""

from ..kernels.compiling.recorded import Recorded, helper
from ..kernels.groups.great_circle import great_circle, kick_along_sphere
from ..kernels.numbers.blocks import part
from .forms import Splitting


def natural_in_space(acceleration: Recorded) -> Splitting:
    """Return the splitting of q̈ = a(t, q) on states (q, v) of R^2n.

    ::

        part 0:  v ↦ v + h a(t, q)
        part 1:  q ↦ q + h v

    With `Verlet` this is the method of Störmer and Verlet: symplectic where a = −M⁻¹ ∂V/∂q.

    Parameters
    ----------
    acceleration : recorded ``f(params, t, q, out, work)``
        Writes a(t, q) to `out`.

    Examples
    --------
    >>> import geomint as gi
    >>> @gi.helper
    ... def spring(params, t, q, out, work):
    ...     out[0] = -q[0]
    >>> gi.natural_in_space(spring).parts
    2
    """

    @helper
    def flow(k, params, t, h, y, out, work):
        n = len(y) // 2
        if k == 0:
            acceleration(params, t, part(y, 0, n), part(out, n, n), work)
            for i in range(n):
                out[i] = 0.0 * h
                out[n + i] = h * out[n + i]
        else:
            for i in range(n):
                out[i] = h * y[n + i]
                out[n + i] = 0.0 * h

    return Splitting(flow, 2)


def natural_on_sphere(gradient: Recorded) -> Splitting:
    """Return the splitting of H = ½(p, p) + V(t, q) on T*S^(n−1).

    ::

        part 0:  p ↦ p − h (1 − qqᵀ) ∂V/∂q(t, q)
        part 1:  the great circle through q along p, over h

    With `Verlet` this is the method of Störmer and Verlet on the sphere: explicit, symplectic,
    with |q| = 1 and (q, p) = 0 to rounding over any number of steps.

    Parameters
    ----------
    gradient : recorded ``f(params, t, q, out, work)``
        Writes ∂V/∂q to `out`, in the coordinates of R^n; its part along q does not matter.

    Notes
    -----
    For problems whose state is (q, p), of any n ≥ 2. Unit mass; time and energy in the units of V.
    """

    @helper
    def flow(k, params, t, h, y, out, work):
        n = len(y) // 2
        if k == 0:
            gradient(params, t, part(y, 0, n), part(out, n, n), work)
            kick_along_sphere(h, y, out)
        else:
            great_circle(h, y, out)

    return Splitting(flow, 2)
