"""Two-forms, divergences and brackets on T*S^(n−1), redundant variables y = (γ, p)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .algebra import Array, null_space
from .calculus import derivative, gradient

__all__ = [
    "canonical",
    "canonical_bracket",
    "conserved",
    "dirac_bracket",
    "dirac_brackets",
    "dirac_field",
    "divergence",
    "exterior_derivative",
    "on_tangents",
    "symplectic_divergence",
    "tangent_basis",
]

Function = Callable[[Array], Any]
TwoForm = Callable[[Array, Array, Array], Any]


def canonical(y: Array, Y: Array, Z: Array) -> Any:
    """Return (Σ dp_i∧dγ_i)(Y, Z), eq. (OMEGA)."""
    n = len(y) // 2
    return Y[n:] @ Z[:n] - Z[n:] @ Y[:n]


def tangent_basis(y: Array) -> Array:
    """Return a basis of the tangent space of T*S^(n−1) at y, as rows."""
    n = len(y) // 2
    gamma, p = y[:n], y[n:]
    return null_space([np.concatenate([gamma, 0.0 * p]), np.concatenate([p, gamma])])


def on_tangents(form: TwoForm, y: Array) -> Array:
    """Return the matrix of a two-form on `tangent_basis`."""
    basis = tangent_basis(y)
    return np.array([[form(y, Y, Z) for Z in basis] for Y in basis])


def exterior_derivative(form: TwoForm, y: Array, Y: Array, Z: Array, W: Array) -> Any:
    """Return dβ(Y, Z, W) and the sum of its terms' sizes, the vectors extended as constants."""

    def along(a: Array, b: Array, c: Array) -> Any:
        return derivative(lambda x: form(x, b, c), y, a)

    terms = [along(Y, Z, W), along(Z, W, Y), along(W, Y, Z)]
    return sum(terms), sum(abs(term) for term in terms)


def conserved(f: Function, rate: Array, y: Array) -> tuple[Any, float, Any]:
    """Return both sides of X(f) = 0 with X = `rate` at y, and the sizes of its terms, Σ |X_i ∂_i f|."""
    slopes = gradient(f, y)
    return slopes @ rate, 0.0, np.abs(slopes) @ np.abs(rate)


def divergence(field: Function, y: Array) -> tuple[float, float]:
    """Return Σ ∂X_i/∂y_i, and the sum of the sizes."""
    diagonal = np.array([derivative(field, y, e)[i] for i, e in enumerate(np.eye(len(y)))])
    return float(np.sum(diagonal)), float(np.sum(np.abs(diagonal)))


def symplectic_divergence(field: Function, y: Array) -> tuple[float, float]:
    """Return div X on T*S^(n−1) for σ = ω^(n−1), and Σ |X_y Y| over a basis; X tangent there.

    L_X ω = ω(X_y·, ·) + ω(·, X_y·), and for the volume ω^(n−1) the divergence is half the trace of
    ω⁻¹ L_X ω.
    """
    basis = tangent_basis(y)
    moved = [derivative(field, y, Y) for Y in basis]
    change = np.array(
        [
            [canonical(y, dY, Z) + canonical(y, Y, dZ) for Z, dZ in zip(basis, moved, strict=True)]
            for Y, dY in zip(basis, moved, strict=True)
        ]
    )
    inverse = np.linalg.inv(on_tangents(canonical, y))
    size = float(np.sum(np.linalg.norm(moved, axis=1)))
    return 0.5 * float(np.trace(inverse @ change)), size


def canonical_bracket(f: Function, g: Function, y: Array) -> Any:
    """Return {f, g} = f_γ g_p − f_p g_γ at a real point."""
    n = len(y) // 2
    df, dg = gradient(f, y), gradient(g, y)
    return df[:n] @ dg[n:] - df[n:] @ dg[:n]


def dirac_brackets(functions: Function, y: Array) -> tuple[Array, Array]:
    """Return all {f_i, f_j}_d, as printed before eq. (hamiltonian-flow), and the sizes |df_i||df_j|.

    `functions` returns f_1 … f_m as one vector.
    """
    n = len(y) // 2

    def all_functions(z: Array) -> Array:
        return np.array([z[:n] @ z[:n], z[:n] @ z[n:], *functions(z)])

    slope = gradient(all_functions, y)
    plain = slope[:, :n] @ slope[:, n:].T - slope[:, n:] @ slope[:, :n].T
    one, two, free = plain[2:, 0], plain[2:, 1], plain[2:, 2:]
    value = free - (np.outer(one, two) - np.outer(two, one)) / plain[0, 1]
    lengths = np.sqrt(np.sum(slope[2:] ** 2, axis=1))
    return value, np.outer(lengths, lengths)


def dirac_bracket(f: Function, g: Function, y: Array) -> tuple[float, float]:
    """Return {f, g}_d and the size of its terms."""
    values, sizes = dirac_brackets(lambda z: np.array([f(z), g(z)]), y)
    return float(values[0, 1]), float(sizes[0, 1])


def dirac_field(f: Function, y: Array) -> Array:
    """Return {y, f}_d, the Hamiltonian field on the leaf."""
    return np.asarray(dirac_brackets(lambda z: np.array([*z, f(z)]), y)[0][:-1, -1])
