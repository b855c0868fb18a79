"""SO(n) acting on vectors, on so(n)* and on frames; algebra elements as flat upper triangles.

Beside it R^m may act on m more rows of the state by translation: the group is then SO(n) × R^m, and
an algebra element is a flat triangle followed by m numbers.

A skew n×n matrix X is stored as ``X_12, X_13, …, X_1n, X_23, …, X_(n−1)n``. Layout:
``[n, piece, piece, …]`` with the piece codes `VECTOR` (v ↦ E v, n rows), `ADJOINT` (the flat triangle
of X ↦ E X Eᵀ), `FRAME` (an n×n matrix g, row after row, g ↦ g Eᵀ), where E = exp ξ, and `SHIFTED`
(r ↦ r + ξ_r, m rows: the last piece).
"""

from ..compiling.recorded import helper
from ..numbers.arithmetic import NAN, maximum, select, top
from ..numbers.blocks import part

VECTOR, ADJOINT, FRAME, SHIFTED = 0, 1, 2, 3
REACH = 0.25  # Taylor's polynomial of degree 12 is exact to 2⁻⁵⁶ up to this norm
CLEAN = 4  # doublings up to which the rounding of the result is left as it is
MAX_DOUBLINGS = 24  # beyond, at turns of millions, the result has lost half of its digits: NaN


def so_n_work(n: int) -> int:
    """Rows of scratch that all functions of SO(n) need."""
    return 6 * n * n


@helper
def unpack_skew(n: int, flat, full):
    """Write the n×n matrix of a flat upper triangle."""
    at = 0
    for i in range(n):
        full[i * n + i] = 0.0 * flat[0]
        for j in range(i + 1, n):
            full[i * n + j] = flat[at]
            full[j * n + i] = -flat[at]
            at += 1


@helper
def multiply(n: int, x, y, out):
    """Write the product of two n×n matrices; `out` must be neither of them."""
    for i in range(n):
        for j in range(n):
            total = x[i * n] * y[j]
            for k in range(1, n):
                total += x[i * n + k] * y[k * n + j]
            out[i * n + j] = total


@helper
def polynomial_term(n: int, c0, c1, c2, x, x2, product, out):
    """Write ``product + c0 + c1 x + c2 x²``."""
    for i in range(n * n):
        out[i] = product[i] + (c1 * x[i] + c2 * x2[i])
    for i in range(0, n * n, n + 1):
        out[i] += c0


@helper
def orthogonalize(n: int, m, gram, out):
    """Write E (3 − EᵀE)/2 − 1 for E = 1 + M; `gram` is scratch of the same size."""
    for i in range(n):
        for j in range(n):
            total = m[i * n + j] + m[j * n + i]
            for k in range(n):
                total += m[k * n + i] * m[k * n + j]
            gram[i * n + j] = total
    multiply(n, m, gram, out)
    for i in range(n * n):
        out[i] = m[i] - 0.5 * (gram[i] + out[i])


@helper
def exponential_increment(n: int, xi, result, work):
    """Write exp(X) − 1 for the skew matrix X of a flat triangle; `work` holds five n×n matrices.

    Scaling by powers of two, Taylor's polynomial of degree 12 (five products, Paterson and
    Stockmeyer 1973), and doubling by ``exp(2X) − 1 = M² + 2M``, M = exp(X) − 1. Every doubling
    doubles the error, also that of orthogonality; after many of them one step of Newton and Schulz,
    ``E ← E (3 − EᵀE)/2``, takes the latter back to round-off. Where even that cannot be: NaN.
    """
    size = n * n
    x = part(work, 0, size)
    x2 = part(work, size, size)
    x3 = part(work, 2 * size, size)
    s = part(work, 3 * size, size)
    p = part(work, 4 * size, size)
    unpack_skew(n, xi, x)
    norm = 0.0 * xi[0]
    for i in range(n):
        row = 0.0 * xi[0]
        for j in range(n):
            row += abs(x[i * n + j])
        norm = maximum(row, norm)
    scale = 1.0 + 0.0 * norm
    doublings = 0
    while top(norm) > REACH and doublings < MAX_DOUBLINGS:
        scale = select(norm > REACH, 0.5 * scale, scale)
        norm = select(norm > REACH, 0.5 * norm, norm)
        doublings += 1
    first = scale
    for i in range(size):
        x[i] *= scale
    multiply(n, x, x, x2)
    multiply(n, x, x2, x3)
    for i in range(size):  # 1/9!, 1/10!, 1/11!, 1/12! and so on down to 1/2!
        p[i] = x3[i] / 479001600.0
    polynomial_term(n, 1 / 362880.0, 1 / 3628800.0, 1 / 39916800.0, x, x2, p, s)
    multiply(n, x3, s, p)
    polynomial_term(n, 1 / 720.0, 1 / 5040.0, 1 / 40320.0, x, x2, p, s)
    multiply(n, x3, s, p)
    polynomial_term(n, 1 / 6.0, 1 / 24.0, 1 / 120.0, x, x2, p, s)
    multiply(n, x3, s, p)
    polynomial_term(n, 0.0, 1.0, 0.5, x, x2, p, result)
    for _ in range(doublings):
        multiply(n, result, result, s)
        for i in range(size):
            result[i] = select(scale < 1.0, s[i] + 2.0 * result[i], result[i])
        scale = select(scale < 1.0, 2.0 * scale, scale)
    if doublings > CLEAN:
        change = select(norm <= REACH, 0.0 * norm, NAN + 0.0 * norm)
        orthogonalize(n, result, s, p)
        for i in range(size):
            result[i] = select(first < 0.5**CLEAN, p[i] + change, result[i])


@helper
def so_n_move(layout, xi, m, y, out, work):
    """Write ``E·y − y`` for every piece of the state, from m = E − 1; two n×n matrices of scratch."""
    n = int(layout[0])
    size = n * n
    at = 0
    for piece in range(1, len(layout)):
        code = int(layout[piece])
        if code == VECTOR:
            for i in range(n):
                total = m[i * n] * y[at]
                for j in range(1, n):
                    total += m[i * n + j] * y[at + j]
                out[at + i] = total
            at += n
        elif code == ADJOINT:
            rows = n * (n - 1) // 2
            k = part(work, 0, size)
            t = part(work, size, size)
            unpack_skew(n, part(y, at, rows), k)
            multiply(n, m, k, t)
            for i in range(n):
                for j in range(i + 1, n):
                    total = t[i * n + j] - t[j * n + i]
                    for q in range(n):
                        total += t[i * n + q] * m[j * n + q]
                    out[at] = total
                    at += 1
        elif code == SHIFTED:
            for row in range(n * (n - 1) // 2, len(xi)):
                out[at] = xi[row]
                at += 1
        else:
            for i in range(n):
                for j in range(n):
                    total = y[at + i * n] * m[j * n]
                    for q in range(1, n):
                        total += y[at + i * n + q] * m[j * n + q]
                    out[at + i * n + j] = total
            at += size


@helper
def so_n_act(layout, xi, y, out, work):
    """Write ``exp(ξ)·y − y``."""
    n = int(layout[0])
    m = part(work, 0, n * n)
    scratch = part(work, n * n, 5 * n * n)
    exponential_increment(n, xi, m, scratch)
    so_n_move(layout, xi, m, y, out, scratch)


@helper
def so_n_bracket(layout, x, y, out, work):
    """Write the commutator ``XY − YX`` of two flat triangles; translations commute."""
    n = int(layout[0])
    a = part(work, 0, n * n)
    b = part(work, n * n, n * n)
    unpack_skew(n, x, a)
    unpack_skew(n, y, b)
    at = 0
    for i in range(n):
        for j in range(i + 1, n):
            total = 0.0 * x[0]
            for k in range(n):
                total += a[i * n + k] * b[k * n + j] - b[i * n + k] * a[k * n + j]
            out[at] = total
            at += 1
    for row in range(at, len(x)):
        out[row] = 0.0 * x[row]
