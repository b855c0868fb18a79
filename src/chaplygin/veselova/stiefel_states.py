"""States (X, P) of the Veselova problem on T*V(n, r), given by any of P, k, w."""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi
from geomint import as_vector

from ..inertia import GeneralInertia, SpecialInertia
from ..initial_states import one_of
from ..manifold import (
    PARALLEL,
    REPAIRED,
    SILENT,
    Array,
    flat_triangle,
    length,
    skew_components,
    skew_matrix,
    solved,
    tangent,
    warn,
    wedge,
)

__all__ = [
    "admit_stiefel",
    "allowed_basis",
    "allowed_part",
    "bound_solution",
    "initial_bound",
    "initial_stiefel",
    "momenta",
    "only_allowed",
    "orthonormal",
]

Inertia = SpecialInertia | GeneralInertia


def initial_stiefel(
    inertia: Inertia, r: int, names: tuple[str, str], components: dict[str, Any]
) -> Array:
    """Return the flat state (X, P) from X and one of P, k, w, by the names of the problem.

    Raises
    ------
    geomint.DomainError
        For vectors that span no r-dimensional space, and for a k or w outside of span{e_s∧R^n}.
    """
    given, n = dict(components), inertia.n
    X = orthonormal(given.pop(names[0], None), r, n, names[0])
    name = one_of(given, (names[1], "k", "w"))
    if name == names[1]:
        P = as_vector(name, given[name], r * n).reshape(r, n)
        return np.concatenate([X.reshape(-1), _tangent(X, P, names).reshape(-1)])
    inside = only_allowed(X, skew_components(name, given[name], n), name, names[0])
    k = inside if name == "k" else allowed_part(X, inertia.apply(inside))
    return np.concatenate([X.reshape(-1), momenta(X, k).reshape(-1)])


def initial_bound(
    inertia: Inertia, gamma: Array, velocity: str, **components: Any
) -> tuple[Array, Array | None]:
    """Return (k, w or None) of a body with r = 1 from one of p, k and the angular velocity.

    `velocity` is what the angular velocity is called; it is returned as it was given.
    """
    name = one_of(components, ("p", "k", velocity))
    if name == "p":
        return wedge(gamma, tangent(gamma, components[name])), None
    given = skew_components(name, components[name], inertia.n)
    inside = only_allowed(gamma[None], given, name, "gamma")
    if name == "k":
        return inside, None
    return allowed_part(gamma[None], inertia.apply(inside)), inside


def orthonormal(X: Any, r: int, n: int, name: str = "X") -> Array:
    """Return r orthonormal vectors, shape (r, n): the nearest to those given; warn if others."""
    given = as_vector(name, X, r * n, f": {r} vectors of R^{n}").reshape(r, n)
    largest = float(np.max(np.abs(given)))
    left, values, right = np.linalg.svd(given / largest if largest > 0.0 else given)
    if not values[-1] > PARALLEL * values[0]:
        raise gi.DomainError(name, X, f"{r} linearly independent vectors")
    defect = float(np.max(np.abs(given @ given.T - np.eye(r))))
    if defect <= SILENT:
        return given
    warn(f"the vectors {name} are not orthonormal by {defect:.3g}: the state uses the nearest")
    return np.asarray(left @ right[:r])


def allowed_part(X: Array, triangle: Array) -> Array:
    """Return the flat triangle of the part of a skew matrix in 𝔡 = span{e_s∧R^n}."""
    n = X.shape[1]
    rest = np.eye(n) - X.T @ X
    return np.asarray(triangle - flat_triangle(rest @ skew_matrix(triangle, n) @ rest))


def only_allowed(X: Array, triangle: Array, name: str, frame: str = "e") -> Array:
    """Return the part of a skew matrix in 𝔡; warn if that is not all of it, raise if it is less.

    `name` and `frame` say in messages what the matrix and the vectors are called.
    """
    inside, size = allowed_part(X, triangle), length(triangle)
    defect = 0.0 if size == 0.0 else length(triangle / size - inside / size)
    if defect <= SILENT:
        return triangle
    planes = f"{frame}∧R^n" if len(X) == 1 else f"span{{{frame}_s∧R^n, s ≤ {len(X)}}}"
    if defect > REPAIRED:
        expected = f"an element of {planes}; |part outside|/|{name}| is {defect:.3g}"
        raise gi.DomainError(name, triangle, expected)
    warn(f"|part of {name} outside of {planes}|/|{name}| is {defect:.3g}: it is dropped")
    return inside


def allowed_basis(X: Array) -> Array:
    """Return an orthonormal basis of 𝔡, one flat triangle a row."""
    rest = np.linalg.svd(X)[2][len(X) :]
    return np.array([wedge(x, u) for i, x in enumerate(X) for u in (*X[i + 1 :], *rest)])


def bound_solution(inertia: Inertia, X: Array, k: Array) -> Array:
    """Return the flat triangle of the w ∈ 𝔡 whose 𝓘w has there the part of k."""
    basis = allowed_basis(X)
    matrix = basis @ np.array([inertia.apply(b) for b in basis]).T
    return np.asarray(solved(matrix, basis @ k) @ basis)


def momenta(X: Array, k: Array) -> Array:
    """Return P, shape (r, n), with k = Σ e_s∧p_s and XᵀP + PᵀX = 0, for k in span{e_s∧R^n}."""
    image = -(skew_matrix(k, X.shape[1]) @ X.T).T
    return np.asarray(image - 0.5 * (image @ X.T) @ X)


def _symmetric(X: Array, P: Array) -> Array:
    product = X @ P.T
    return np.asarray(product + product.T)


def _tangent(X: Array, P: Array, names: tuple[str, str]) -> Array:
    """Return P less what violates XᵀP + PᵀX = 0; warn if that is not P."""
    size = length(P.reshape(-1))
    if size == 0.0:
        return P
    defect = float(np.max(np.abs(_symmetric(X, P / size))))
    if defect <= SILENT:
        return P
    result = _projected(X, P)
    if length(result.reshape(-1)) < PARALLEL * size:
        raise gi.DomainError(names[1], P, f"momenta with a part tangent to {names[0]}")
    warn(f"XᵀP + PᵀX of the state is {defect:.3g} of |P|, not 0: the state uses the tangent part")
    return result


def _projected(X: Array, P: Array) -> Array:
    """Return P − X·½(XᵀP + PᵀX), twice, for round-off."""
    for _ in range(2):
        P = P - 0.5 * _symmetric(X, P) @ X
    return P


def admit_stiefel(y: Array, n: int, r: int, names: tuple[str, str]) -> Array:
    """Return a flat state (X, P), repaired if need be; see `manifold`."""
    X, P = y[: n * r].reshape(r, n), y[n * r :].reshape(r, n)
    defect = float(np.max(np.abs(X @ X.T - np.eye(r))))
    if defect > REPAIRED:
        expected = f"orthonormal vectors; the largest entry of XᵀX − 1 is {defect:.3g}"
        raise gi.DomainError(names[0], X, expected)
    if defect > SILENT:
        warn(f"the largest entry of XᵀX − 1 of the state is {defect:.3g}: projected to 0")
        left, _, right = np.linalg.svd(X)
        X = left @ right[:r]
    size = length(P.reshape(-1))
    defect = 0.0 if size == 0.0 else float(np.max(np.abs(_symmetric(X, P / size))))
    if defect > REPAIRED:
        expected = f"momenta with XᵀP + PᵀX = 0; its largest entry is {defect:.3g} of |P|"
        raise gi.DomainError(names[1], P, expected)
    if defect > SILENT:
        warn(f"XᵀP + PᵀX of the state is {defect:.3g} of |P|: projected to 0")
        P = _projected(X, P)
    return np.concatenate([X.reshape(-1), P.reshape(-1)])
