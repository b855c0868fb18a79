"""The rotations of R^n, and rigid motions."""

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arguments import Array, as_vector
from ...errors import DomainError
from ...kernels.compiling.recorded import Recorded, observable
from ...kernels.numbers.arithmetic import sqrt
from .euclidean import Euclidean
from .space import Space
from .stiefel import Orthonormal

__all__ = ["RigidMotions", "Rotations"]


@dataclass(frozen=True)
class Rotations(Orthonormal):
    """SO(n): n×n matrices g row after row, turned by g ↦ g Eᵀ; a rotation from body to space.

    Parameters
    ----------
    n : int
        At least 2.
    name : str
        Of the piece of the state.
    """

    n: int
    name: str = "g"
    what = "a rotation matrix"
    codes = ("frame",)

    @property
    def vectors(self) -> int:
        """The rows: n."""
        return self.n

    def constraints_at(self, first: int) -> dict[str, Recorded]:
        """Frobenius norm of g gᵀ − 1."""
        return {"orthogonality": frame_orthogonality(self.n, first)}

    def point(self, value: Any) -> Array:
        """Return a rotation as n·n numbers; the identity for none. It is repaired, not projected."""
        n = self.n
        none = value is None or value is ...
        given = np.eye(n).reshape(-1) if none else as_vector(self.name, value, n * n)
        return self.admit(given)

    def admit(self, y: Array) -> Array:
        """Return the matrix of a flat state, replaced by the nearest rotation if need be."""
        result = super().admit(y)
        if np.linalg.det(self.matrix(result)) < 0.0:
            raise DomainError(self.name, self.matrix(y), f"{self.what}, of determinant 1")
        return result


def RigidMotions(n: int, names: tuple[str, str] = ("g", "r")) -> Space:  # noqa: N802
    """Return SE(n): a rotation and a point, moved by SO(n) × R^n, simply transitively too."""
    return Rotations(n, names[0]) * Euclidean(n, names[1])


@functools.cache
def frame_orthogonality(n: int, first: int) -> Recorded:
    """Return the Frobenius norm of g gᵀ − 1, g from row `first` on."""

    def orthogonality(params, t, y, work):
        total = 0.0 * y[0]
        for i in range(n):
            for j in range(n):
                entry = 0.0 * y[0]
                if i == j:
                    entry -= 1.0
                for c in range(n):
                    entry += y[first + i * n + c] * y[first + j * n + c]
                total += entry * entry
        return sqrt(total)

    return observable(orthogonality)
