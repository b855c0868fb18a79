"""Matrices of so(n), for real and complex entries: plain numpy, no conjugation anywhere.

Skew matrices are matrices here; operators on so(n) are matrices in the basis E_i∧E_j, i < j,
which is orthonormal for ⟨X, Y⟩ = −½ tr XY, eq. (KF).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = [
    "Array",
    "apply",
    "bracket",
    "coordinates",
    "hat",
    "inner",
    "null_space",
    "project",
    "rank",
    "skew",
    "vector",
    "wedge",
]

Array = npt.NDArray[Any]

SMALL = 1e-9  # a singular value below this times the largest one counts as zero


def wedge(x: Array, y: Array) -> Array:
    """Return x∧y = xyᵀ − yxᵀ."""
    return np.asarray(np.outer(x, y) - np.outer(y, x))


def inner(X: Array, Y: Array) -> Any:
    """Return ⟨X, Y⟩ = −½ tr XY, eq. (KF)."""
    return -0.5 * np.sum(X * Y.T)


def bracket(X: Array, Y: Array) -> Array:
    """Return [X, Y] = XY − YX."""
    return np.asarray(X @ Y - Y @ X)


def coordinates(X: Array) -> Array:
    """Return the coordinates of a skew matrix in the basis E_i∧E_j, i < j."""
    return np.asarray(X[np.triu_indices(len(X), 1)])


def skew(x: Array, n: int) -> Array:
    """Return the skew matrix with those coordinates."""
    matrix = np.zeros((n, n), dtype=np.asarray(x).dtype)
    matrix[np.triu_indices(n, 1)] = x
    return matrix - matrix.T


def apply(operator: Array, X: Array) -> Array:
    """Return the image of a skew matrix under an operator on so(n)."""
    return skew(operator @ coordinates(X), len(X))


def project(X: Array, gamma: Array) -> Array:
    """Return (Xγ)∧γ, for |γ| = 1 the projection of X onto R^n∧γ."""
    return wedge(X @ gamma, gamma)


def hat(x: Array) -> Array:
    """Return the matrix of a vector of R³, eq. (iso)."""
    zero = 0.0 * x[0]
    return np.array([[zero, -x[2], x[1]], [x[2], zero, -x[0]], [-x[1], x[0], zero]])


def vector(X: Array) -> Array:
    """Return the vector of a matrix of so(3): the inverse of `hat`."""
    return np.array([X[2, 1], X[0, 2], X[1, 0]])


def rank(rows: Any) -> int:
    """Return the rank of a matrix, up to singular values of `SMALL` times the largest."""
    values = np.linalg.svd(np.atleast_2d(np.asarray(rows)), compute_uv=False)
    return int(np.sum(values > SMALL * max(values[0], 1e-300))) if len(values) else 0


def null_space(rows: Any) -> Array:
    """Return an orthonormal basis, as rows, of the vectors that a matrix of full rank kills."""
    matrix = np.atleast_2d(np.asarray(rows))
    return np.asarray(np.linalg.svd(matrix)[2][len(matrix) :])
