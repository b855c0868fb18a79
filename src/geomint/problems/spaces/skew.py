"""so(n) and its dual: skew matrices as flat upper triangles."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arguments import Array, as_array, as_vector
from ...errors import DomainError
from ...kernels.groups.so_n import unpack_skew
from .pieces import Pieces
from .repair import SILENT
from .space import Space

__all__ = ["Skew", "flat_triangle", "skew_matrix", "unpack_skew"]


@dataclass(frozen=True)
class Skew(Space):
    """so(n)*: skew n×n matrices as flat upper triangles, turned by X ↦ E X Eᵀ.

    Parameters
    ----------
    n : int
        At least 2.
    name : str
        Of the piece of the state.
    """

    n: int
    name: str = "k"

    codes = ("adjoint",)

    @property
    def pieces(self) -> Pieces:
        """One piece of n(n − 1)/2 rows."""
        return ((self.name, self.n * (self.n - 1) // 2),)

    def point(self, value: Any) -> Array:
        """Return the flat triangle of a skew matrix, shape (n, n), or of a flat triangle."""
        n = self.n
        if as_array(self.name, value).shape != (n, n):
            return as_vector(self.name, value, self.rows)
        matrix = as_vector(self.name, value, n * n).reshape(n, n)
        largest = float(np.max(np.abs(matrix)))
        if float(np.max(np.abs(matrix + matrix.T))) > SILENT * largest:
            raise DomainError(self.name, value, "a skew-symmetric matrix")
        return flat_triangle(0.5 * (matrix - matrix.T))


def skew_matrix(flat: Array, n: int) -> Array:
    """Return the skew matrix of a flat triangle, shape (n, n)."""
    matrix = np.zeros((n, n))
    matrix[np.triu_indices(n, 1)] = flat
    return matrix - matrix.T


def flat_triangle(matrix: Array) -> Array:
    """Return the flat upper triangle of a skew matrix."""
    return matrix[np.triu_indices(len(matrix), 1)]
