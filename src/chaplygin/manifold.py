"""States made admissible: unit vectors, tangent vectors, skew matrices, frames.

A component that a user names (``gamma=[1, 2, 3]``) is a direction: it is projected, with a warning
that says by how much. A flat state that was made elsewhere is only repaired: a defect up to
`SILENT` is left as it is, bit for bit, one up to `REPAIRED` is projected with a warning, and a
larger one is an error. Defects of p are relative to |p|, so that states of any scale are served.
"""

from __future__ import annotations

import sys
import warnings
from typing import Any

import numpy as np

import geomint as gi
from geomint import as_vector
from geomint.arguments import Array, as_array

__all__ = [
    "REPAIRED",
    "SILENT",
    "Array",
    "admit_frame",
    "admit_tangent",
    "admit_unit",
    "flat_triangle",
    "frame",
    "length",
    "skew_components",
    "skew_matrix",
    "solved",
    "tangent",
    "triangle_of_vector",
    "unit",
    "upright",
    "vector_of_triangle",
    "wedge",
]


SILENT = 1e-13
REPAIRED = 1e-6
_PACKAGES = ("chaplygin.", "geomint.")
PARALLEL = 1e-8  # a p whose tangent part is a smaller fraction of it is mostly round-off


def warn(text: str) -> None:
    """Warn that a state was changed, at the line of the first caller outside of the packages."""
    frame, level = sys._getframe(1), 2
    while frame.f_back and frame.f_globals.get("__name__", "").startswith(_PACKAGES):
        frame, level = frame.f_back, level + 1
    warnings.warn(text, gi.GeomintWarning, stacklevel=level)


def length(v: Array) -> float:
    """Return |v| without overflow or underflow of its square."""
    largest = float(np.max(np.abs(v)))
    if largest == 0.0:
        return 0.0
    scaled = v / largest
    return largest * float(np.sqrt(scaled @ scaled))


def unit(gamma: Any, n: int, name: str = "gamma") -> Array:
    """Return the unit vector along `gamma`, shape (n,); warn if that is not `gamma` itself.

    `name` says in messages what it is called.

    Raises
    ------
    geomint.DomainError
        If `gamma` is zero, not finite or not n numbers.
    """
    given = as_vector(name, gamma, n)
    size = length(given)
    if size == 0.0:
        raise gi.DomainError(name, gamma, "a vector that is not zero")
    if abs(size - 1.0) <= 0.5 * SILENT:
        return given
    warn(f"{name} has length {size!r}, not 1: the state uses {name}/|{name}|")
    result = given / np.max(np.abs(given))
    return np.asarray(result / length(result))


def tangent(gamma: Array, p: Any, name: str = "p", normal: str = "gamma") -> Array:
    """Return the part of `p` orthogonal to the unit vector `gamma`; warn if that is not `p`.

    `name` and `normal` say in messages what the two are called.

    Raises
    ------
    geomint.DomainError
        If `p` is not n finite numbers, or is so nearly parallel to γ that no direction is left.
    """
    given = as_vector(name, p, len(gamma))
    size = length(given)
    if size == 0.0:
        return given
    defect = abs(float(gamma @ (given / size)))
    if defect <= SILENT:
        return given
    result = _orthogonal(gamma, given)
    if length(result) < PARALLEL * size:
        raise gi.DomainError(name, p, f"a vector that is not parallel to {normal}")
    warn(f"({normal}, {name})/|{name}| is {defect:.3g}, not 0: the state uses the tangent part")
    return result


def _orthogonal(gamma: Array, p: Array) -> Array:
    """Return p less its part along γ; twice, so that the result is orthogonal to round-off."""
    size = length(p)
    result = p / size
    for _ in range(2):
        result = result - (gamma @ result) / (gamma @ gamma) * gamma
    return np.asarray(result * size)


def admit_unit(gamma: Array, name: str = "gamma") -> Array:
    """Return a γ of a flat state, repaired if need be; see the module's docstring."""
    size = length(gamma)
    defect = abs(size - 1.0) * (size + 1.0)
    if defect <= SILENT:
        return gamma
    if defect > REPAIRED:
        raise gi.DomainError(name, gamma, f"a unit vector; |{name}|² − 1 is {defect:.3g}")
    warn(f"|{name}|² − 1 of the state is {defect:.3g}: projected to 0")
    return np.asarray(gamma / size)


def admit_tangent(gamma: Array, p: Array, name: str = "p", normal: str = "gamma") -> Array:
    """Return a p of a flat state, repaired if need be; see the module's docstring.

    `gamma` is a unit vector; `name` and `normal` say in messages what the two are called.
    """
    size = length(p)
    defect = 0.0 if size == 0.0 else abs(float(gamma @ (p / size)))
    if defect <= SILENT:
        return p
    if defect > REPAIRED:
        expected = f"a vector orthogonal to {normal}; ({normal}, {name})/|{name}| is {defect:.3g}"
        raise gi.DomainError(name, p, expected)
    warn(f"({normal}, {name})/|{name}| of the state is {defect:.3g}: projected to 0")
    return _orthogonal(gamma, p)


def admit_frame(g: Array, n: int) -> Array:
    """Return the rotation matrix g, shape (n·n,), of a flat state, repaired if need be."""
    matrix = g.reshape(n, n)
    defect = float(np.max(np.abs(matrix.T @ matrix - np.eye(n))))
    if not defect <= REPAIRED or np.linalg.det(matrix) < 0.0:
        expected = f"a rotation matrix; the largest entry of gᵀg − 1 is {defect:.3g}"
        raise gi.DomainError("g", matrix, expected)
    if defect <= SILENT:
        return g
    warn(f"the largest entry of gᵀg − 1 of the state is {defect:.3g}: projected to 0")
    left, _, right = np.linalg.svd(matrix)
    return np.asarray((left @ right).reshape(-1))


def frame(g: Any, n: int) -> Array:
    """Return a rotation matrix as n·n numbers; the identity for None."""
    if g is None:
        return np.eye(n).reshape(-1)
    return admit_frame(as_vector("g", g, n * n), n)


def upright(gamma: Array) -> Array:
    """Return the smallest rotation g with g γ = E_n, shape (n, n); its last row is γ.

    It turns the plane of γ and E_n, and for γ = −E_n that of E_1 and E_n.
    """
    n = len(gamma)
    u, e = np.append(gamma[:-1], 0.0), np.eye(n)[-1]
    s = length(u)
    u = np.eye(n)[0] if s == 0.0 else u / s
    c = gamma[-1]
    g = np.eye(n) + (c - 1.0) * (np.outer(u, u) + np.outer(e, e))
    g += s * (np.outer(e, u) - np.outer(u, e))
    g[-1] = gamma
    return np.asarray(g)


def solved(matrix: Array, right: Array) -> Array:
    """Return the solution of a linear system in so(n) or R^n.

    Raises
    ------
    geomint.DomainError
        If the matrix is singular: moments that differ by more than all digits make it so.
    """
    try:
        return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
    except np.linalg.LinAlgError:
        expected = "moments and D whose ratios are far from 10¹⁶: their matrix is singular"
        raise gi.DomainError("inertia", matrix, expected) from None


def wedge(x: Array, y: Array) -> Array:
    """Return the flat triangle of x∧y = xyᵀ − yxᵀ, shape (n(n−1)/2,)."""
    i, j = np.triu_indices(len(x), 1)
    return np.asarray(x[i] * y[j] - y[i] * x[j])


def skew_matrix(flat: Array, n: int) -> Array:
    """Return the skew matrix of a flat triangle, shape (n, n)."""
    matrix = np.zeros((n, n))
    matrix[np.triu_indices(n, 1)] = flat
    return matrix - matrix.T


def flat_triangle(matrix: Array) -> Array:
    """Return the flat upper triangle of a skew matrix."""
    return np.asarray(matrix[np.triu_indices(len(matrix), 1)])


def vector_of_triangle(flat: Array) -> Array:
    """Return the 3-vector of a flat triangle under the hat map (iso)."""
    return np.array([-flat[2], flat[1], -flat[0]])


def triangle_of_vector(x: Array) -> Array:
    """Return the flat triangle of the hat map (iso) of a 3-vector."""
    return np.array([-x[2], x[1], -x[0]])


def skew_components(name: str, value: Any, n: int, vector: bool = False) -> Array:
    """Return an element of so(n) as a flat triangle.

    Parameters
    ----------
    name : str
        For messages.
    value : array_like
        A skew (n, n) matrix, or flat: the triangle, or with `vector` (n = 3) a 3-vector.
    """
    if as_array(name, value).shape != (n, n):
        flat = as_vector(name, value, n * (n - 1) // 2)
        return triangle_of_vector(flat) if vector else flat
    matrix = as_vector(name, value, n * n).reshape(n, n)
    largest = float(np.max(np.abs(matrix)))
    if float(np.max(np.abs(matrix + matrix.T))) > SILENT * largest:
        raise gi.DomainError(name, value, "a skew-symmetric matrix")
    return flat_triangle(0.5 * (matrix - matrix.T))
