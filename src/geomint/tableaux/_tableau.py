"""Butcher tableaux, exact and validated; what can be computed from A, b, c is never declared.

References
----------
[HNW] E. Hairer, S. P. Nørsett, G. Wanner, *Solving Ordinary Differential Equations I*,
2nd ed., Springer, 1993.
[HLW] E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, 2nd ed., Springer, 2006.
"""

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import chain

from ..arguments import whole
from ..references.reference import Reference, checked_references
from ._exact import Array, Exact, Row, nearest


@dataclass(frozen=True)
class Tableau(Exact):
    r"""A Runge-Kutta method with s stages, as its exact coefficients.

    .. math::

        Y_i = y_0 + h \sum_j a_{ij} f(t_0 + c_j h, Y_j), \qquad
        y_1 = y_0 + h \sum_j b_j f(t_0 + c_j h, Y_j), \qquad
        \hat y_1 = y_0 + h \sum_j \hat b_j f(t_0 + c_j h, Y_j).

    Parameters
    ----------
    name : str
        Name in a registry.
    order : int
        Classical order p: the local error is O(h^(p+1)). A statement to be tested, see
        `geomint.tableaux.order_conditions`.
    A : tuple of tuple of Fraction, shape (s, s)
        Stage coefficients; `rows` reads them from text.
    b, c : tuple of Fraction, shape (s,)
        Weights and nodes; `row` reads them from text.
    references : tuple of Reference, optional
        Where the coefficients are published; empty for one's own.
    b_hat : tuple of Fraction, shape (s,), optional
        Weights of the embedded method.
    order_hat : int, optional
        Order of the embedded method.
    b_low, order_low : optional
        Weights and order of a second embedded method of still lower order, see `estimate_order`.
    tolerance : Fraction
        Largest defect of ``c_i = sum_j a_ij`` and ``sum_j b_j = 1`` that the rounding of published
        decimals explains; zero, the default, for rational methods.

    Raises
    ------
    ArgumentError
        If a coefficient is not a `Fraction` (a float has already lost digits).
    MethodError
        If shapes disagree or a sum is wrong by more than `tolerance`.
    """

    name: str
    order: int
    A: tuple[Row, ...]
    b: Row
    c: Row
    references: tuple[Reference, ...] = ()
    b_hat: Row | None = None
    order_hat: int | None = None
    b_low: Row | None = None
    order_low: int | None = None
    tolerance: Fraction = Fraction(0)

    def _check(self) -> None:
        """Check types, shapes and sums."""
        object.__setattr__(self, "references", checked_references(self.references))
        s, _ = self.stages, whole("order", self.order, 1)
        embedded = [weights for weights in (self.b_hat, self.b_low) if weights is not None]
        vectors = (self.b, self.c, *self.A, *embedded)
        if not all(isinstance(x, Fraction) for x in chain.from_iterable(vectors)):
            raise TypeError(f"{self.name}: coefficients must be Fractions; read text with row()")
        if s == 0 or len(self.A) != s or any(len(vector) != s for vector in vectors):
            raise ValueError(f"{self.name}: A must be {s} x {s}, and b, c, b_hat of length {s}")
        for which in ("hat", "low"):
            if (getattr(self, f"b_{which}") is None) != (getattr(self, f"order_{which}") is None):
                raise ValueError(f"{self.name}: b_{which} and order_{which} go together")
        if self.b_low is not None and self.b_hat is None:
            raise ValueError(f"{self.name}: b_low comes beside b_hat")
        for i, (a, c) in enumerate(zip(self.A, self.c, strict=True), start=1):
            if abs(sum(a, -c)) > self.tolerance:
                raise ValueError(f"{self.name}: row {i} of A does not sum to c_{i}")
        for label, weights in (("b", self.b), ("b_hat", self.b_hat), ("b_low", self.b_low)):
            if weights is not None and abs(sum(weights, Fraction(-1))) > self.tolerance:
                raise ValueError(f"{self.name}: {label} does not sum to 1")

    @property
    def stages(self) -> int:
        """Number of stages s."""
        return len(self.b)

    @property
    def explicit(self) -> bool:
        """Whether A is strictly lower triangular."""
        return not any(any(a[i:]) for i, a in enumerate(self.A))

    @property
    def first_same_as_last(self) -> bool:
        """Whether the last stage is the new value, so that its derivative serves the next step."""
        return self.c[-1] == 1 and self.A[-1] == self.b

    @property
    def used_stages(self) -> int:
        """Stages up to the last one that the new value needs; others serve the error estimate."""
        return max(i for i, weight in enumerate(self.b, start=1) if weight)

    @property
    def symmetric(self) -> bool:
        """Whether ``a_{s+1-i,s+1-j} + a_ij = b_j = b_{s+1-j}`` exactly [HLW, Theorem V.2.3]."""
        return self.b == self.b[::-1] and all(
            x + y == z
            for a, mirrored in zip(self.A, reversed(self.A), strict=True)
            for x, y, z in zip(a, reversed(mirrored), self.b, strict=True)
        )

    @property
    def symplectic(self) -> bool:
        """Whether ``b_i a_ij + b_j a_ji = b_i b_j`` exactly [HLW, Theorem VI.4.3]."""
        A, b, stages = self.A, self.b, range(self.stages)
        return all(
            b[i] * A[i][j] + b[j] * A[j][i] == b[i] * b[j] for i in stages for j in stages if j <= i
        )

    @cached_property
    def A_float(self) -> Array:  # noqa: N802 (the symbol is A)
        """Float64 numbers nearest to A, shape (s, s)."""
        return nearest(chain.from_iterable(self.A)).reshape(self.stages, self.stages)

    @cached_property
    def b_float(self) -> Array:
        """Float64 numbers nearest to b, shape (s,)."""
        return nearest(self.b)

    @cached_property
    def c_float(self) -> Array:
        """Float64 numbers nearest to c, shape (s,)."""
        return nearest(self.c)

    @property
    def estimate_order(self) -> int | None:
        """The power of h with which the error estimate falls; None if there is none.

        With one embedded method it is ``‖y_1 − ŷ_1‖``. With two, e of order h^(p̂+1) and e_low of order
        h^(p_low+1), it is ``‖e‖² / (‖e‖² + 0.01 ‖e_low‖²)^½``, as in DOP853 [HNW, Section II.10].
        """
        if self.order_hat is None:
            return None
        order = min(self.order, self.order_hat) + 1
        return order if self.order_low is None else 2 * order - (self.order_low + 1)

    @cached_property
    def error_float(self) -> Array | None:
        """Weights ``b − b_hat`` and then ``b − b_low`` of the error estimate, rounded once; or None.

        The shape is (s,) or (2 s,).
        """
        embedded = [weights for weights in (self.b_hat, self.b_low) if weights is not None]
        if not embedded:
            return None
        return nearest(x - y for weights in embedded for x, y in zip(self.b, weights, strict=True))
