"""Cayley coordinates of SO(n) for any n, and the closed form of dexp⁻¹ for n = 3.

``cay(ξ) = (1 − ξ/2)⁻¹ (1 + ξ/2)`` is orthogonal where ξ is skew, and reaches all rotations by less
than π. Layouts and algebra elements are those of `geomint.kernels.groups.so_n`; translations are
their own coordinates.
"""

from ..compiling.recorded import helper
from ..numbers.arithmetic import NAN, select
from ..numbers.blocks import part
from .so3 import CHART as EXP_CHART, dexpinv_coefficient
from .so_n import multiply, so_n_bracket, so_n_move, unpack_skew

# Beyond this |ξ| = (Σ ξ_ij²)^½, i < j, rotations come near to π, and elimination without pivoting
# loses |ξ|² roundings: Cayley coordinates are refused there.
CHART = 8.0


@helper
def solve_near_one(n: int, a, b):
    """Replace the n×n matrix b by a⁻¹ b, by elimination without pivoting; a is overwritten.

    The symmetric part of a must be 1: then so is at least that of every Schur complement, and
    no pivot is less than 1.
    """
    for k in range(n):
        pivot = 1.0 / a[k * n + k]
        for i in range(k + 1, n):
            factor = a[i * n + k] * pivot
            for j in range(k + 1, n):
                a[i * n + j] -= factor * a[k * n + j]
            for j in range(n):
                b[i * n + j] -= factor * b[k * n + j]
    for k in range(n - 1, -1, -1):
        pivot = 1.0 / a[k * n + k]
        for j in range(n):
            total = b[k * n + j]
            for i in range(k + 1, n):
                total -= a[k * n + i] * b[i * n + j]
            b[k * n + j] = pivot * total


@helper
def so_n_cayley(layout, xi, y, out, work):
    """Write ``cay(ξ)·y − y``, from ``cay(ξ) − 1 = (1 − ξ/2)⁻¹ ξ``; NaN where |ξ| > `CHART`."""
    n = int(layout[0])
    size = n * n
    m = part(work, 0, size)
    a = part(work, size, size)
    unpack_skew(n, xi, m)
    square = 0.0 * xi[0]
    for i in range(n * (n - 1) // 2):
        square += xi[i] * xi[i]
    one = select(square <= CHART * CHART, 1.0 + 0.0 * square, NAN + 0.0 * square)
    for i in range(size):
        a[i] = -0.5 * m[i]
    for i in range(0, size, n + 1):
        a[i] = one + a[i]
    solve_near_one(n, a, m)
    so_n_move(layout, xi, m, y, out, part(work, size, 2 * size))


@helper
def so_n_dcayinv(layout, u, v, out, work):
    """Write ``dcay_u⁻¹ v = (1 − u/2) v (1 + u/2) = v − ½ [u, v] − ¼ u v u``: exact, no series."""
    n = int(layout[0])
    size = n * n
    left = part(work, 0, size)
    vu = part(work, size, size)
    uvu = part(work, 2 * size, size)
    unpack_skew(n, u, left)
    unpack_skew(n, v, uvu)
    multiply(n, uvu, left, vu)
    multiply(n, left, vu, uvu)
    at = 0
    for i in range(n):
        for j in range(i + 1, n):
            bracket = vu[j * n + i] - vu[i * n + j]
            out[at] = v[at] - (0.5 * bracket + 0.25 * uvu[i * n + j])
            at += 1
    for row in range(at, len(v)):
        out[row] = v[row]


@helper
def so_3_dexpinv(layout, u, v, out, work):
    """Write ``dexp_u⁻¹ v = v − ½ [u, v] + c [u, [u, v]]`` for flat triangles of n = 3."""
    c = dexpinv_coefficient(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])
    bracket = part(work, 18, len(v))
    so_n_bracket(layout, u, v, bracket, work)
    so_n_bracket(layout, u, bracket, out, work)
    for i in range(len(v)):
        out[i] = v[i] + (c * out[i] - 0.5 * bracket[i])


@helper
def so_n_extent(layout, u, work):
    """Return ``Σ u_ij² / CHART²``, i < j: at most 1 where no angle exceeds that of SO(3)'s chart."""
    n = int(layout[0])
    total = 0.0 * u[0]
    for r in range(n * (n - 1) // 2):
        total += u[r] * u[r]
    return total * (1.0 / (EXP_CHART * EXP_CHART))
