"""The Stiefel variety V(n, r): r orthonormal vectors of R^n, one after another."""

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arguments import Array, as_vector, whole
from ...errors import DomainError
from ...kernels.compiling.recorded import Recorded, field, observable
from ...kernels.numbers.arithmetic import sqrt
from .pieces import Pieces
from .repair import PARALLEL, SILENT, repaired, warn
from .space import Space

__all__ = ["Orthonormal", "Stiefel"]


class Orthonormal(Space):
    """What spheres, Stiefel varieties and rotations share: the rows of X, XXᵀ = 1."""

    name: str
    what = "orthonormal vectors"

    @property
    def vectors(self) -> int:
        """How many."""
        raise NotImplementedError

    @property
    def pieces(self) -> Pieces:
        """One piece, vector after vector."""
        return ((self.name, self.vectors * self.n),)

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """A matrix, of one row a vector."""
        return {self.name: (self.vectors, self.n)}

    @property
    def conditions(self) -> int:
        """Entries of XXᵀ − 1 on and above the diagonal."""
        return self.vectors * (self.vectors + 1) // 2

    @property
    def codes(self) -> tuple[str, ...]:
        """Vectors."""
        return ("vector",) * self.vectors

    def manifold_at(self, first: int) -> Recorded:
        """XXᵀ − 1 on and above the diagonal, row after row."""
        return gram(self.n, self.vectors, first, first)

    def tangency_at(self, first: int, second: int) -> Recorded:
        """XVᵀ + VXᵀ above the diagonal and half of it on the diagonal."""
        return gram(self.n, self.vectors, first, second)

    @property
    def constraint(self) -> Recorded:
        """½(XXᵀ − 1), off the diagonal XXᵀ, and its Jacobian."""
        return gram_constraint(self.n, self.vectors)

    def constraints_at(self, first: int) -> dict[str, Recorded]:
        """Return the length of XXᵀ − 1 on and above the diagonal."""
        return {"orthonormality": gram_size(self.n, self.vectors, first, first)}

    def tangencies_at(self, first: int, second: int) -> dict[str, Recorded]:
        """Return the length of XVᵀ + VXᵀ on and above the diagonal."""
        return {"cotangency": gram_size(self.n, self.vectors, first, second)}

    def matrix(self, y: Array) -> Array:
        """Return X, shape (r, n)."""
        return y.reshape(self.vectors, self.n)

    def tangent(self, y: Array, v: Array) -> Array:
        """Return V − ½(XVᵀ + VXᵀ)X, twice, for round-off."""
        X, V = self.matrix(y), self.matrix(v)
        for _ in range(2):
            product = X @ V.T
            V = V - 0.5 * (product + product.T) @ X
        return V.reshape(-1)

    def admit(self, y: Array) -> Array:
        """Return vectors of a flat state, replaced by the nearest orthonormal ones if need be."""
        X = self.matrix(y)
        defect = float(np.max(np.abs(X @ X.T - np.eye(len(X)))))
        said = f"the largest entry of {self.name}ᵀ{self.name} − 1"
        return repaired(self.name, y, defect, said, self.what, lambda: _nearest(X).reshape(-1))

    def random(self, rng: np.random.Generator) -> dict[str, Array]:
        """Return vectors whose distribution rotations do not change."""
        return {self.name: random_rotation(rng, self.n)[: self.vectors].reshape(-1)}


@dataclass(frozen=True)
class Stiefel(Orthonormal):
    """V(n, r): r orthonormal vectors of R^n, 1 ≤ r ≤ n.

    Parameters
    ----------
    n, r : int
    name : str
        Of the piece of the state, r·n numbers.
    """

    n: int
    r: int
    name: str = "X"

    def __post_init__(self) -> None:
        n = whole("n", self.n, self.least)
        object.__setattr__(self, "r", whole("r", self.r, 1, n))
        super().__post_init__()

    @property
    def vectors(self) -> int:
        """The number r."""
        return self.r

    def point(self, value: Any) -> Array:
        """Return the orthonormal vectors nearest to those given; warn if others.

        Raises
        ------
        DomainError
            If they are not r linearly independent vectors of R^n.
        """
        name, n, r = self.name, self.n, self.r
        given = as_vector(name, value, r * n, f": {r} vectors of R^{n}")
        X = self.matrix(given)
        largest = float(np.max(np.abs(X)))
        scaled = X / largest if largest > 0.0 else X
        values = np.linalg.svd(scaled, compute_uv=False)
        if not values[-1] > PARALLEL * values[0]:
            raise DomainError(name, value, f"{r} linearly independent vectors")
        defect = float(np.max(np.abs(X @ X.T - np.eye(r))))
        if defect <= SILENT:
            return given
        text = f"the vectors {name} are not orthonormal by {defect:.3g}: the state uses the nearest"
        warn(text, name, defect)
        return _nearest(scaled).reshape(-1)


def _nearest(X: Array) -> Array:
    left, _, right = np.linalg.svd(X)
    return left @ right[: len(X)]


def random_rotation(rng: np.random.Generator, n: int) -> Array:
    """Return a rotation of R^n, uniform (Haar's measure), shape (n, n)."""
    q, r = np.linalg.qr(rng.normal(size=(n, n)))
    q *= np.sign(np.diag(r))
    q[0] *= np.linalg.det(q)
    for _ in range(2):  # orthogonal to rounding, as the signs and the determinant leave it
        q = q @ (1.5 * np.eye(n) - 0.5 * q.T @ q)
    return q


@functools.cache
def gram(n: int, r: int, first: int, second: int) -> Recorded:
    """Return the function that writes XXᵀ − 1, or of two blocks of rows half of the derivative along V.

    On and above the diagonal, row after row; that is XVᵀ + VXᵀ off the diagonal, and XVᵀ on it.
    """

    def gram_conditions(params, t, y, out, work):
        at = 0
        for i in range(0, r * n, n):
            for j in range(i, r * n, n):
                total = 0.0 * y[first]
                for c in range(n):
                    entry = y[first + i + c] * y[second + j + c]
                    if i != j and first != second:
                        entry += y[first + j + c] * y[second + i + c]
                    total += entry
                if i == j and first == second:
                    total -= 1.0
                out[at] = total
                at += 1

    return field(gram_conditions)


@functools.cache
def gram_size(n: int, r: int, first: int, second: int) -> Recorded:
    """Return the length of XXᵀ − 1, or of XVᵀ + VXᵀ, on and above the diagonal."""

    def size(params, t, y, work):
        total = 0.0 * y[first]
        for i in range(0, r * n, n):
            for j in range(i, r * n, n):
                entry = 0.0 * y[first]
                for c in range(n):
                    term = y[first + i + c] * y[second + j + c]
                    if first != second:
                        term += y[first + j + c] * y[second + i + c]
                    entry += term
                if i == j and first == second:
                    entry -= 1.0
                total += entry * entry
        return sqrt(total)

    return observable(size)


@functools.cache
def gram_constraint(n: int, r: int) -> Recorded:
    """Return the constraint of `geomint.Hamiltonian`."""

    def constraint(params, q, g, G, work):
        at = 0
        for s in range(r):
            for u in range(s, r):
                row = at * r * n
                for i in range(r * n):
                    G[row + i] = 0.0 * q[i]
                total = 0.0 * q[0]
                for i in range(n):
                    total += q[s * n + i] * q[u * n + i]
                    G[row + s * n + i] = 1.0 * q[u * n + i]
                    G[row + u * n + i] = 1.0 * q[s * n + i]
                g[at] = 0.5 * (total - 1.0) if s == u else total
                at += 1

    return field(constraint)
