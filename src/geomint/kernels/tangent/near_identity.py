"""Determinants and triangular factors of ``1 + S``, to relative accuracy where S is small."""

from ..compiling.recorded import helper
from ..numbers.arithmetic import NAN, fma, sqrt, total
from ..numbers.blocks import as_lanes
from ..numbers.exponential import log
from .layout import lanes_for

SMALL = 0.5  # the norm of S: below that the ones are kept apart


@helper
def log_one_plus(x):
    """Return ``log|1 + x|`` to full relative accuracy for small x (Kahan's quotient)."""
    u = 1.0 + x
    return x if u == 1.0 else log(abs(u)) * (x / (u - 1.0)) if abs(x) < 0.5 else log(abs(u))


@helper
def small(d: int, S) -> bool:
    """Tell whether 1 + S is so near to the identity that the ones are kept apart."""
    groups = lanes_for(d) // 8
    rows = as_lanes(S, 0, d * groups)
    size = 0.0 * rows[0]
    for i in range(d * groups):
        size = fma(rows[i], rows[i], size)
    return total(size) < SMALL * SMALL


@helper
def log_volume(d: int, S, lower, upper):
    """Return ``½ log det(1 + S)``, and write the inverse of the upper factor.

    S is symmetric, and overwritten. ``RᵀR = 1 + S``: the columns of ``X R⁻¹`` are orthonormal if
    ``XᵀX = 1 + S``. Where 1 + S has no such factor the result is NaN.
    """
    width = lanes_for(d)
    groups = width // 8
    rows, inverse = as_lanes(S, 0, d * groups), as_lanes(lower, 0, d * groups)
    factors = as_lanes(upper, 0, width * groups)
    for i in range(d * groups):
        inverse[i] = 0.0 * rows[0]
    for i in range(width * groups):
        factors[i] = 0.0 * rows[0]
    for i in range(d):
        lower[i * width + i] = 1.0
    near = small(d, S)
    logarithms, product = 0.0, 0.0  # of 1 + pivot, less 1
    for k in range(d):
        pivot = S[k * width + k]
        if not pivot > -1.0:
            return NAN
        if near:
            product = (product + pivot) + product * pivot
        else:
            logarithms += log_one_plus(pivot)
        by = 1.0 / (1.0 + pivot)
        for i in range(k + 1, d):
            factor = S[i * width + k] * by
            for g in range(groups):
                at, above = i * groups + g, k * groups + g
                rows[at] = fma(-factor, rows[above], rows[at])
                inverse[at] = fma(-factor, inverse[above], inverse[at])
    for k in range(d):
        root = 1.0 / sqrt(1.0 + S[k * width + k])
        for i in range(d):
            upper[i * width + k] = root * lower[k * width + i]
    return 0.5 * (log_one_plus(product) if near else logarithms)
