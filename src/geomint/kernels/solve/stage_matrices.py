"""The linear systems of Newton's method for the stages of a step: factors, and solutions by them.

Matrices are of plain numbers, right-hand sides of any: what factors leave of a residual has
derivatives where the residual has them.
"""

from ..compiling.recorded import helper, inlined
from ..numbers.arithmetic import fma, top
from ..numbers.blocks import as_lanes
from ..numbers.lanes import LANES


@inlined
def padded(size: int) -> int:
    """Return the numbers that a row of a matrix takes, in whole lane values."""
    return (size + 7) // 8 * 8


@helper
def factor_lanes(n: int, real, imaginary, order):
    """Factor eight complex n×n matrices in place, one in each lane, by elimination.

    Rows are exchanged in all lanes alike: the pivot is the row whose smallest lane is the largest. The
    inverse of each pivot is left in its place. What is singular, or so large that squares of its
    numbers are none, leaves numbers that are not finite.
    """
    for k in range(n):
        at, best = k, -1.0
        for i in range(k, n):
            p, q = real[i * n + k], imaginary[i * n + k]
            smallest = -top(-(p * p + q * q))
            if smallest > best:
                at, best = i, smallest
        order[k] = at
        for j in range(n if at != k else 0):
            p, q = real[k * n + j], imaginary[k * n + j]
            real[k * n + j], imaginary[k * n + j] = real[at * n + j], imaginary[at * n + j]
            real[at * n + j], imaginary[at * n + j] = p, q
        p, q = real[k * n + k], imaginary[k * n + k]
        size = p * p + q * q
        p, q = p / size + 0.0 * size, -q / size
        real[k * n + k], imaginary[k * n + k] = p, q
        for i in range(k + 1, n):
            u, v = real[i * n + k], imaginary[i * n + k]
            u, v = u * p - v * q, u * q + v * p
            real[i * n + k], imaginary[i * n + k] = u, v
            for j in range(k + 1, n):
                x, y = real[k * n + j], imaginary[k * n + j]
                real[i * n + j] = fma(-u, x, fma(v, y, real[i * n + j]))
                imaginary[i * n + j] = fma(-u, y, fma(-v, x, imaginary[i * n + j]))


@helper
def solve_lanes(n: int, real, imaginary, order, x, y):
    """Solve in place for x + iy, eight right-hand sides, by the factors of `factor_lanes`."""
    for k in range(n):
        at = int(order[k])
        if at != k:
            u, v = x[k], y[k]
            x[k], y[k] = x[at], y[at]
            x[at], y[at] = u, v
    for i in range(n):
        u, v = x[i], y[i]
        for k in range(i):
            p, q = real[i * n + k], imaginary[i * n + k]
            u = fma(-p, x[k], fma(q, y[k], u))
            v = fma(-p, y[k], fma(-q, x[k], v))
        x[i], y[i] = u, v
    for back in range(n):
        k = n - 1 - back
        u, v = x[k], y[k]
        for j in range(k + 1, n):
            p, q = real[k * n + j], imaginary[k * n + j]
            u = fma(-p, x[j], fma(q, y[j], u))
            v = fma(-p, y[j], fma(-q, x[j], v))
        p, q = real[k * n + k], imaginary[k * n + k]
        x[k], y[k] = p * u - q * v, p * v + q * u


@helper
def factor_whole(n: int, matrix, order):
    """Factor an n×n matrix in place by elimination with exchanges of rows.

    Rows begin every ``padded(n)`` numbers, and the inverse of each pivot is left in its place. What is
    singular leaves numbers that are not finite.
    """
    width = padded(n)
    for k in range(n):
        at, best = k, -1.0
        for i in range(k, n):
            size = abs(matrix[i * width + k])
            if size > best:
                at, best = i, size
        order[k] = at
        for j in range(n if at != k else 0):
            kept = matrix[k * width + j]
            matrix[k * width + j] = matrix[at * width + j]
            matrix[at * width + j] = kept
        inverse = 1.0 / matrix[k * width + k] + 0.0 * matrix[k * width + k]
        matrix[k * width + k] = inverse
        first = k // LANES + 1  # of the lane values that lie behind the pivot as a whole
        ends = min(LANES * first, n)
        own = as_lanes(matrix, k * width, width // LANES)
        for i in range(k + 1, n):
            factor = matrix[i * width + k] * inverse
            matrix[i * width + k] = factor
            for j in range(k + 1, ends):
                matrix[i * width + j] -= factor * matrix[k * width + j]
            other = as_lanes(matrix, i * width, width // LANES)
            for j in range(first, width // LANES):
                other[j] -= factor * own[j]


@helper
def solve_whole(n: int, matrix, order, x):
    """Solve in place for x by the factors of `factor_whole`."""
    width = padded(n)
    for k in range(n):
        at = int(order[k])
        if at != k:
            kept = x[k]
            x[k] = x[at]
            x[at] = kept
    for i in range(1, n):
        total = x[i]
        for k in range(i):
            total = fma(-matrix[i * width + k], x[k], total)
        x[i] = total
    for back in range(n):
        k = n - 1 - back
        total = x[k]
        for j in range(k + 1, n):
            total = fma(-matrix[k * width + j], x[j], total)
        x[k] = total * matrix[k * width + k]
