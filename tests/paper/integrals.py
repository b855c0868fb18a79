"""The integrals of the reduced problem, and how functions depend on each other and commute."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .algebra import Array, wedge
from .calculus import Function, gradient
from .equations import split
from .points import Point
from .two_forms import dirac_brackets, tangent_basis

__all__ = ["integral_polynomial", "relative_brackets", "slopes_on_tangents", "together"]


def integral_polynomial(point: Point, y: Array) -> Array:
    """Return the coefficients r_0 … r_(n−2) of R on T*S^(n−1), quadratic in p̃.

    R(z) = P(z) (z Σ_{i<j} m_ij²/((z − a_i)(z − a_j)) − (p̃, p̃) Σ γ_i²/(z − a_i)) with P = Π(z − a_i)
    and m = γ∧p̃: in spheroconical coordinates R(λ_k) = −4λ_k P(λ_k) μ_k².
    """
    gamma, p = split(y)
    a, n, m2 = point.a, point.n, wedge(gamma, p) ** 2
    total = np.zeros(n + 1, dtype=y.dtype)
    for i in range(n):
        rest = np.poly(np.delete(a, i))
        total[-n:] = total[-n:] - (p @ p) * gamma[i] ** 2 * rest
        for j in range(i + 1, n):
            pair = np.poly(np.delete(a, [i, j]))
            total[-n:] = total[-n:] + m2[i, j] * np.append(pair, 0.0)
    return total[::-1][: n - 1]


def together(point: Point, *functions: Callable[[Point, Array], Any]) -> Function:
    """Return the function of y with all values of some functions of a point and y."""
    return lambda y: np.hstack([f(point, y) for f in functions])


def slopes_on_tangents(functions: Function, y: Array) -> Array:
    """Return the differentials of f_1 … f_m on T*S^(n−1), as rows."""
    return np.asarray(gradient(functions, y) @ tangent_basis(y).T)


def relative_brackets(functions: Function, y: Array) -> Array:
    """Return all {f_i, f_j}_d over |df_i||df_j|."""
    values, sizes = dirac_brackets(functions, y)
    return np.asarray(values / sizes)
