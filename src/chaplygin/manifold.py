"""Elements of so(n) as flat triangles, upright attitudes, and what spaces are made of.

States are admitted as `geomint.problems.spaces.repair` says: a component that a user names is
projected with a warning, a flat state is repaired or refused.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

import geomint as gi
from geomint.arguments import Array, as_array
from geomint.problems.spaces.repair import PARALLEL, REPAIRED, SILENT, length, repaired, warn
from geomint.problems.spaces.skew import flat_triangle, skew_matrix

__all__ = [
    "PARALLEL",
    "REPAIRED",
    "SILENT",
    "Array",
    "Arrays",
    "Map",
    "Named",
    "flat_triangle",
    "length",
    "repaired",
    "skew_components",
    "skew_matrix",
    "solved",
    "triangle_of_vector",
    "triangle_rows",
    "upright",
    "vector_of_triangle",
    "warn",
    "wedge",
]


Arrays = dict[str, Array]  # by name
Named = dict[str, Any]  # values, or recorded functions
Map = Callable[[Array], Array]  # of states


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
    return g


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


def triangle_rows(n: int) -> int:
    """Return the length of the flat triangle of an element of so(n)."""
    return n * (n - 1) // 2


def wedge(x: Array, y: Array) -> Array:
    """Return the flat triangle of x∧y = xyᵀ − yxᵀ, shape (n(n−1)/2,)."""
    i, j = np.triu_indices(len(x), 1)
    return x[i] * y[j] - y[i] * x[j]


def vector_of_triangle(flat: Array) -> Array:
    """Return the 3-vector of a flat triangle under the hat map (iso), or of each in the last axis."""
    return flat[..., ::-1] * np.array([-1.0, 1.0, -1.0])


triangle_of_vector = vector_of_triangle  # the map is its own inverse


def skew_components(name: str, value: Any, n: int, vector: bool = False) -> Array:
    """Return an element of so(n) as a flat triangle.

    Parameters
    ----------
    name : str
        For messages.
    value : array_like
        A skew (n, n) matrix, or flat: the triangle, or with `vector` (n = 3) a 3-vector.
    """
    flat = gi.Skew(n, name).point(value)
    return triangle_of_vector(flat) if vector and as_array(name, value).shape != (n, n) else flat
