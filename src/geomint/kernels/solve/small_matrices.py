"""Small systems of equations over blocks: a few constraints, matrices stored row after row."""

from typing import Any

from ..compiling.recorded import helper
from ..numbers.arithmetic import maximum


@helper
def solve_small(m: int, matrix, right) -> None:
    """Solve an m×m system in place, by elimination without exchanges.

    The matrices are G H_pp Gᵀ: definite wherever the kinetic energy is definite on the normals.
    """
    for k in range(m):
        for i in range(k + 1, m):
            factor = matrix[i * m + k] / matrix[k * m + k]
            for j in range(k + 1, m):
                matrix[i * m + j] = matrix[i * m + j] - factor * matrix[k * m + j]
            right[i] = right[i] - factor * right[k]
    for back in range(m):
        k = m - 1 - back
        total = right[k]
        for j in range(k + 1, m):
            total -= matrix[k * m + j] * right[j]
        right[k] = total / matrix[k * m + k]


@helper
def contract(n: int, rows: int, left, right, out) -> None:
    """Write ``left rightᵀ`` of two matrices of `rows` rows and n columns."""
    for a in range(rows):
        for b in range(rows):
            total = left[a * n] * right[b * n]
            for i in range(1, n):
                total += left[a * n + i] * right[b * n + i]
            out[a * rows + b] = total


@helper
def largest(count: int, numbers) -> Any:
    """Return the largest size of so many numbers; where one is not finite, it is not either."""
    found = 0.0 * numbers[0]
    for i in range(count):
        found = maximum(abs(numbers[i]), found) + 0.0 * numbers[i]
    return found


@helper
def along(n: int, m: int, i: int, rows, weights) -> Any:
    """Return component i of ``rowsᵀ weights``."""
    total = rows[i] * weights[0]
    for a in range(1, m):
        total += rows[a * n + i] * weights[a]
    return total


@helper
def across(n: int, a: int, rows, vector) -> Any:
    """Return component a of ``rows vector``."""
    total = rows[a * n] * vector[0]
    for i in range(1, n):
        total += rows[a * n + i] * vector[i]
    return total
