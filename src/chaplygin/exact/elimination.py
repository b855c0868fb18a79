"""Small linear systems and determinants in compiled code."""

import geomint as gi
from geomint import part


@gi.helper
def to_triangle(size, matrix, x):
    """Eliminate below the diagonal, with partial pivoting; x, if it has rows, goes along.

    Returns the determinant.
    """
    result = 1.0 + 0.0 * matrix[0]
    for k in range(size):
        best = k
        for i in range(k + 1, size):
            if abs(matrix[i * size + k]) > abs(matrix[best * size + k]):
                best = i
        if matrix[best * size + k] == 0.0:
            return 0.0 * result
        if best != k:
            result = -result
            for j in range(size):
                held = matrix[k * size + j]
                matrix[k * size + j] = matrix[best * size + j]
                matrix[best * size + j] = held
            if len(x) > 0:
                held = x[k]
                x[k] = x[best]
                x[best] = held
        result *= matrix[k * size + k]
        for i in range(k + 1, size):
            factor = matrix[i * size + k] / matrix[k * size + k]
            for j in range(k + 1, size):
                matrix[i * size + j] -= factor * matrix[k * size + j]
            if len(x) > 0:
                x[i] -= factor * x[k]
    return result


@gi.helper
def solve_in_place(size, matrix, x):
    """Solve matrix · solution = x; both are overwritten, x by the solution."""
    if size == 0:
        return
    to_triangle(size, matrix, x)
    for k in range(size - 1, -1, -1):
        for j in range(k + 1, size):
            x[k] -= matrix[k * size + j] * x[j]
        x[k] /= matrix[k * size + k]


@gi.helper
def determinant(size, matrix):
    """Return the determinant; the matrix is overwritten."""
    return to_triangle(size, matrix, part(matrix, 0, 0))
