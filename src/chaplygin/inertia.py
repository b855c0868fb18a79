"""Inertia operators on so(n), in the basis E_i∧E_j, i < j, ordered (1,2), (1,3), …, (n−1,n)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import geomint as gi
from geomint import as_vector
from geomint.arguments import as_array, whole

from .manifold import Array, Named, flat_triangle, skew_matrix, triangle_rows

LARGEST = 1000  # dimension: states with attitude have 3n²/2 numbers
LARGEST_OF_MATRICES = 100  # of a general operator, which has some n⁴/4
SYMMETRIC = 1e-13  # of the largest entry: more asymmetry than that is an error
TURN = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])  # flat triangles to vectors
FACTORS = 1e-14  # relative: products a_i a_j that differ by more are not those of an a


def positive_number(name: str, value: Any) -> float:
    """Return `value` as a finite float > 0, or raise `geomint.DomainError`."""
    number = float(as_vector(name, value, 1)[0])
    if not number > 0.0:
        raise gi.DomainError(name, value, "a number > 0")
    return number


def positive_vector(name: str, value: Any) -> Array:
    """Return n ≥ 2 positive numbers whose inverses are finite too, or raise `geomint.DomainError`."""
    values = _vector(name, value)
    with np.errstate(over="ignore", divide="ignore"):
        good = (values > 0.0) & np.isfinite(1.0 / values)
    if not good.all():
        raise gi.DomainError(
            name, value, f"positive numbers; {name}[{int(np.argmin(good))}] is not"
        )
    return _frozen(values)


def _vector(name: str, value: Any) -> Array:
    n = _count(name, value)
    if n < 2:
        raise gi.DomainError(name, value, "n ≥ 2 numbers")
    check_dimension(name, n)
    return as_vector(name, value, n)


def _frozen(array: Any) -> Array:
    result = np.array(array, dtype=np.float64)
    result.setflags(write=False)
    return result


def _count(name: str, value: Any) -> int:
    """Return how many numbers, or rows of such, there are: not more than a computer can hold."""
    values = as_array(name, value, "a sequence of numbers")
    if values.ndim == 0:
        raise gi.DomainError(name, value, "a sequence of numbers")
    return len(values)


def check_dimension(name: str, n: int, most: int = LARGEST) -> None:
    """Raise `geomint.DomainError` where there is no memory for what a dimension asks for."""
    if n > most:
        raise gi.DomainError(f"n, from {name},", n, f"a dimension up to {most}")


def _matrix(name: str, value: Any, rows: int) -> Array:
    """Return a matrix, or the diagonal one of that many numbers."""
    values = as_array(name, value, f"numbers of the shape ({rows}, {rows})")
    if values.ndim == 1:
        return np.diag(as_vector(name, value, rows))
    return _square(name, value, rows)


def _square(name: str, value: Any, rows: int) -> Array:
    shape = f"({rows}, {rows})"
    if as_array(name, value, f"numbers of the shape {shape}").shape != (rows, rows):
        raise gi.DomainError(name, value, f"numbers of the shape {shape}")
    return as_vector(name, value, rows * rows).reshape(rows, rows)


def product_factors(values: Array, n: int) -> Array | None:
    """Return a with a_i a_j = values_ij for all i < j, or None if there is none; n ≥ 2.

    At n = 2 the factors are equal; at n = 3 they always exist: a_i² = v_ij v_ik/v_jk.
    """
    if n == 2:
        return np.full(2, np.sqrt(values[0]))
    matrix = np.ones((n, n))
    i, j = np.triu_indices(n, 1)
    matrix[i, j] = matrix[j, i] = values
    one, two = np.roll(np.arange(n), -1), np.roll(np.arange(n), -2)
    axes = np.arange(n)
    factors = np.sqrt(matrix[axes, one] / matrix[one, two] * matrix[axes, two])
    if np.max(np.abs(factors[i] * factors[j] / values - 1.0)) > FACTORS:
        return None
    return factors


@dataclass(frozen=True, init=False, eq=False)
class SpecialInertia:
    """The operator I(E_i∧E_j) = a_i a_j D/(D − a_i a_j) E_i∧E_j, i < j, eq. (operator).

    The paper asks for 0 < a_i a_j < D for all i and j. Only i ≠ j enters the operator, and
    a_i > 0 with a_i a_j < D for i ≠ j is all that is needed: I is then positive definite, hence so
    is the reduced metric I + D pr, and H > 0. With i = j included, rigid bodies would be excluded
    for no reason: moments (0.1, 10, 10) with D = 1 have a_1² = 9.1 D. So a_i² may exceed D here.

    Parameters
    ----------
    a : array_like, shape (n,)
        Dimensionless, n ≥ 2.
    D : float
        mρ² > 0.

    Raises
    ------
    geomint.DomainError
        Naming the first pair with a_i a_j ≥ D, or a number that is not finite and positive.
    """

    a: Array
    D: float

    def __init__(self, a: Any, D: Any) -> None:
        values, scale = _vector("a", a), positive_number("D", D)
        if not (values > 0.0).all():
            raise gi.DomainError("a", a, f"positive numbers; a[{int(np.argmin(values))}] is not")
        order = np.argsort(values)
        i, j = sorted((int(order[-1]), int(order[-2])))
        if not values[i] * values[j] < scale:
            product = values[i] * values[j]
            expected = f"a[i]*a[j] < D = {scale!r} for i ≠ j; a[{i}]*a[{j}] is {product:.17g}"
            expected += ". Other operators are given by inertia, moments or J"
            raise gi.DomainError("a", a, expected)
        if not np.isfinite(1.0 / values).all() or values.min() * values.min() == 0.0:
            raise gi.DomainError("a", a, "numbers whose products neither vanish nor overflow")
        vars(self).update(a=_frozen(values), D=scale)

    @classmethod
    def from_moments(cls, moments: Any, D: Any) -> SpecialInertia:
        """Return the operator of a body with principal moments I_1, I_2, I_3, eq. (IOP1).

        With w_i = I_i/(I_i + D) the equation reads a_i = √(D w_1 w_2 w_3)/w_i.
        """
        values, scale = as_vector("moments", moments, 3), positive_number("D", D)
        if not (values > 0.0).all():
            raise gi.DomainError("moments", moments, "positive numbers")
        w = values / (values + scale)
        try:
            return cls(np.sqrt(scale * w[0] * w[1] * w[2]) / w, scale)
        except gi.DomainError:  # a_i a_j rounds to D, or to 0
            expected = f"numbers up to some 10¹⁵ D, D = {scale!r}, whose products do not vanish"
            raise gi.DomainError("moments", moments, expected) from None

    @classmethod
    def homogeneous(cls, n: int, s: Any, D: Any) -> SpecialInertia:
        """Return the operator I = s·1: all a_i² = s D/(s + D)."""
        moment, scale = positive_number("s", s), positive_number("D", D)
        n = whole("n", n, 2, LARGEST)
        return cls(np.full(n, np.sqrt(moment * (scale / (moment + scale)))), scale)

    @property
    def n(self) -> int:
        """The dimension."""
        return len(self.a)

    @property
    def diagonal(self) -> Array:
        """The moments a_i a_j D/(D − a_i a_j), shape (n(n−1)/2,)."""
        i, j = np.triu_indices(self.n, 1)
        product = self.a[i] * self.a[j]
        return product * (self.D / (self.D - product))

    @property
    def moments(self) -> Array:
        """At n = 3 the principal moments I_1, I_2, I_3; I_3 = a_1 a_2 D/(D − a_1 a_2)."""
        return _three(self.diagonal)[::-1].copy()

    def apply(self, omega: Array) -> Array:
        """Return the flat triangle of Iω."""
        return self.diagonal * omega

    def mass_tensor(self) -> Array:
        """Return the principal values of the J of a rigid body with Iω = Jω + ωJ, shape (n,).

        For n ≥ 4 there is one only in the Lagrange case, where all a_i are equal but one, a_n say,
        eq. (sing): J_1 = a_1²D/(2(D − a_1²)) and J_n = a_1a_nD/(D − a_1a_n) − J_1. That is positive
        where 2a_nD > a_1²a_n + a_1D, and a_1² < D (the first condition is misprinted).

        Raises
        ------
        geomint.DomainError
            If there is no such J, or a J_i is not positive: such a body has no positive masses.
        """
        n, (i, j) = self.n, np.triu_indices(self.n, 1)
        design = np.zeros((len(i), n))
        design[np.arange(len(i)), i] = design[np.arange(len(i)), j] = 1.0
        J, *_ = np.linalg.lstsq(design, self.diagonal, rcond=None)
        misfit = float(np.max(np.abs(design @ J / self.diagonal - 1.0)))
        if misfit > SYMMETRIC * n:
            expected = f"at n ≥ 4 all equal but one (Lagrange); the best J misses I by {misfit:.3g}"
            raise gi.DomainError("a", self.a, expected)
        if not (J > 0.0).all():
            least = int(np.argmin(J))
            expected = f"an operator with positive J; J[{least}] is {float(J[least]):.6g}"
            raise gi.DomainError("a", self.a, expected)
        return np.asarray(J)


@dataclass(frozen=True, init=False, eq=False)
class GeneralInertia:
    """Any symmetric positive definite operator on so(n).

    Parameters
    ----------
    values : array_like, shape (N,) or (N, N) with N = n(n−1)/2
        Diagonal entries, or the matrix, in the basis E_i∧E_j.

    Raises
    ------
    geomint.DomainError
        If the matrix is not symmetric or not positive definite, naming the worst value.
    """

    matrix: Array
    n: int
    diagonal: Array | None
    """The diagonal entries if the operator is diagonal, else None."""

    def __init__(self, values: Any) -> None:
        rows = _count("inertia", values)
        n = round((1.0 + np.sqrt(1.0 + 8.0 * rows)) / 2.0)
        if n < 2 or triangle_rows(n) != rows:
            raise gi.DomainError("inertia", values, "n(n−1)/2 numbers, or that many rows, n ≥ 2")
        check_dimension("inertia", n, LARGEST_OF_MATRICES)
        matrix = _matrix("inertia", values, rows)
        largest = float(np.max(np.abs(matrix)))
        with np.errstate(over="ignore"):
            skewness = float(np.max(np.abs(matrix - matrix.T)))
        if skewness > SYMMETRIC * largest:
            expected = f"a symmetric matrix; the largest |I − Iᵀ| is {skewness:.3g}"
            raise gi.DomainError("inertia", values, expected)
        matrix = 0.5 * matrix + 0.5 * matrix.T
        diagonal = np.diag(matrix).copy()
        is_diagonal = np.count_nonzero(matrix - np.diag(diagonal)) == 0
        if is_diagonal:
            least = float(np.min(diagonal))
        else:  # of a matrix that neither over- nor underflows on the way
            least = largest * float(np.min(np.linalg.eigvalsh(matrix / largest)))
        if not least > (0.0 if is_diagonal else rows * np.finfo(float).eps * largest):
            expected = f"a positive definite operator; its least eigenvalue is {least:.17g}"
            raise gi.DomainError("inertia", values, expected)
        kept = _frozen(diagonal) if is_diagonal else None
        vars(self).update(matrix=_frozen(matrix), n=n, diagonal=kept)

    @classmethod
    def from_mass_tensor(cls, J: Any) -> GeneralInertia:
        """Return the operator Iω = Jω + ωJ of a rigid body with mass tensor J.

        Parameters
        ----------
        J : array_like, shape (n,) or (n, n)
            Its principal values J_i, or symmetric; I_ij = J_i + J_j in principal axes.
        """
        n = _count("J", J)
        if n < 2:
            raise gi.DomainError("J", J, "n ≥ 2 numbers, or that many rows")
        check_dimension("J", n, LARGEST_OF_MATRICES)
        tensor = _matrix("J", J, n)
        if np.max(np.abs(tensor - tensor.T)) > SYMMETRIC * np.max(np.abs(tensor)):
            raise gi.DomainError("J", J, "a symmetric matrix")
        tensor = 0.5 * (tensor + tensor.T)
        basis = (skew_matrix(row, n) for row in np.eye(triangle_rows(n)))
        return cls(np.array([flat_triangle(tensor @ e + e @ tensor) for e in basis]))

    @classmethod
    def from_tensor(cls, tensor: Any) -> GeneralInertia:
        """Return the operator of a body in R³ with the inertia tensor of that shape (3, 3)."""
        return cls(TURN @ _square("tensor", tensor, 3) @ TURN.T)

    @property
    def tensor(self) -> Array:
        """At n = 3 the inertia tensor acting on vectors, shape (3, 3)."""
        return TURN @ _three(self.matrix) @ TURN.T

    def special(self, D: float) -> SpecialInertia | None:
        """Return this operator as a special one if it is one, else None.

        Every diagonal operator is for n ≤ 3, and every multiple of the identity; for n ≥ 4 so are
        those with I_ij = a_i a_j D/(D − a_i a_j) to round-off, as that of Lagrange's body.
        """
        values = self.diagonal
        if values is None:
            return None
        if np.ptp(values) == 0.0:
            return SpecialInertia.homogeneous(self.n, values[0], D)
        if self.n == 3:
            return SpecialInertia.from_moments(values[::-1], D)
        a = product_factors(values * (D / (values + D)), self.n)
        return None if a is None else SpecialInertia(_merged(a), D)

    def apply(self, omega: Array) -> Array:
        """Return the flat triangle of Iω."""
        return self.matrix @ omega


Inertia = SpecialInertia | GeneralInertia


def inertia_tensor(inertia: Inertia) -> Array:
    """Return the inertia tensor of an operator on so(3), shape (3, 3)."""
    if isinstance(inertia, SpecialInertia):
        return np.diag(inertia.moments)
    return inertia.tensor


def operator_of(given: Any) -> Inertia:
    """Return an operator, made of its entries or its matrix if it is none."""
    return given if isinstance(given, Inertia) else GeneralInertia(given)


def scale_of(inertia: Inertia, D: Any) -> float:
    """Return D, which a special operator has, or raise `geomint.DomainError`."""
    if not isinstance(inertia, SpecialInertia):
        return positive_number("D", D)
    if D is not None and positive_number("D", D) != inertia.D:
        raise gi.DomainError("D", D, f"the D = {inertia.D!r} of the inertia operator")
    return inertia.D


def _merged(a: Array) -> Array:
    """Return a with values equal to round-off made equal: equal axes have integrals of their own."""
    result = a.copy()
    for i in range(1, len(a)):
        same = np.flatnonzero(np.abs(result[:i] / a[i] - 1.0) <= FACTORS)
        if len(same):
            result[i] = result[same[0]]
    return result


def _three(values: Array) -> Array:
    if len(values) != 3:
        raise gi.DomainError("n", len(values), "dimension 3, where so(n) is R³")
    return values


def angular_momentum(inertia: Inertia, D: float, gamma: Array, omega: Array) -> Array:
    """Return the flat triangle of k = Iω + D(ωγγᵀ + γγᵀω), eq. (K)."""
    full = skew_matrix(omega, inertia.n)
    v = full @ gamma
    return inertia.apply(omega) + D * flat_triangle(np.outer(v, gamma) - np.outer(gamma, v))


def parameters_of(inertia: Inertia, D: float) -> Named:
    """Return the parameters of a ball by name, for reports."""
    return {**operator_parameters(inertia), "D": D}


def operator_parameters(inertia: Inertia) -> Named:
    """Return the parameters of an operator by name, for reports."""
    if isinstance(inertia, SpecialInertia):
        return {"a": inertia.a.tolist(), "D": inertia.D}
    values = inertia.matrix if inertia.diagonal is None else inertia.diagonal
    return {"inertia": values.tolist()}
