"""States (X, P) of the Veselova problem on T*V(n, r), given by any of P, k, w."""

from typing import Any

import numpy as np

import geomint as gi

from ..inertia import Inertia
from ..initial_states import one_of
from ..manifold import (
    Array,
    Named,
    flat_triangle,
    length,
    repaired,
    skew_components,
    skew_matrix,
    solved,
    wedge,
)


def initial_stiefel(inertia: Inertia, space: gi.TangentBundle, components: Named) -> Array:
    """Return the flat state (X, P) from X and one of P, k, w, by the names of the space.

    Raises
    ------
    geomint.DomainError
        For vectors that span no r-dimensional space, and for a k or w outside of span{e_s∧R^n}.
    """
    given, n = dict(components), inertia.n
    first, second = (name for name, _ in space.pieces)
    point = space.base.point(given.pop(first, None))
    name, X = one_of(given, (second, "k", "w")), point.reshape(-1, n)
    if name == second:
        return space.join({first: point, second: space.vector(point, given[name])})
    inside = only_allowed(X, skew_components(name, given[name], n), name, first)
    k = inside if name == "k" else allowed_part(X, inertia.apply(inside))
    return space.join({first: point, second: momenta(X, k)})


def initial_bound(
    inertia: Inertia, gamma: Array, velocity: str, **components: Any
) -> tuple[Array, Array | None]:
    """Return (k, w or None) of a body with r = 1 from one of p, k and the angular velocity.

    `velocity` is what the angular velocity is called; it is returned as it was given.
    """
    name = one_of(components, ("p", "k", velocity))
    if name == "p":
        return wedge(gamma, gi.TangentSphere(inertia.n).vector(gamma, components[name])), None
    given = skew_components(name, components[name], inertia.n)
    inside = only_allowed(gamma[None], given, name, "gamma")
    if name == "k":
        return inside, None
    return allowed_part(gamma[None], inertia.apply(inside)), inside


def allowed_part(X: Array, triangle: Array) -> Array:
    """Return the flat triangle of the part of a skew matrix in 𝔡 = span{e_s∧R^n}."""
    n = X.shape[1]
    rest = np.eye(n) - X.T @ X
    return triangle - flat_triangle(rest @ skew_matrix(triangle, n) @ rest)


def only_allowed(X: Array, triangle: Array, name: str, frame: str = "e") -> Array:
    """Return the part of a skew matrix in 𝔡; warn if that is not all of it, raise if it is less.

    `name` and `frame` say in messages what the matrix and the vectors are called.
    """
    inside, size = allowed_part(X, triangle), length(triangle)
    defect = 0.0 if size == 0.0 else length(triangle / size - inside / size)
    planes = f"{frame}∧R^n" if len(X) == 1 else f"span{{{frame}_s∧R^n, s ≤ {len(X)}}}"
    said = f"|part of {name} outside of {planes}|/|{name}|"
    return repaired(name, triangle, defect, said, f"an element of {planes}", lambda: inside)


def allowed_basis(X: Array) -> Array:
    """Return an orthonormal basis of 𝔡, one flat triangle a row."""
    rest = np.linalg.svd(X)[2][len(X) :]
    return np.array([wedge(x, u) for i, x in enumerate(X) for u in (*X[i + 1 :], *rest)])


def bound_solution(inertia: Inertia, X: Array, k: Array) -> Array:
    """Return the flat triangle of the w ∈ 𝔡 whose 𝓘w has there the part of k."""
    basis = allowed_basis(X)
    matrix = basis @ np.array([inertia.apply(b) for b in basis]).T
    return solved(matrix, basis @ k) @ basis


def momenta(X: Array, k: Array) -> Array:
    """Return P, shape (r, n), with k = Σ e_s∧p_s and XᵀP + PᵀX = 0, for k in span{e_s∧R^n}."""
    image = -(skew_matrix(k, X.shape[1]) @ X.T).T
    return image - 0.5 * (image @ X.T) @ X
