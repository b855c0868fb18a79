"""Symmetric compositions: steps of a symmetric method whose lengths read the same backwards.

References
----------
[HLW] E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, 2nd ed., Springer, 2006,
Sections II.4 and V.3.2.
"""

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import accumulate

from ..references.reference import Reference, checked_references
from ._exact import Array, Exact, Row, nearest


@dataclass(frozen=True)
class Composition(Exact):
    r"""A palindromic composition of steps of a symmetric method.

    .. math::

        \Psi_h = \Phi_{\gamma_s h} \circ \cdots \circ \Phi_{\gamma_1 h}, \qquad
        \gamma_{s+1-i} = \gamma_i, \qquad \sum_i \gamma_i = 1.

    Only the first half is stored. The middle coefficient is one minus twice its sum, exactly, so
    that no digit of consistency is lost.

    Parameters
    ----------
    name : str
        Name in a registry.
    order : int
        Order of the composition, an even number; a statement to be tested, see
        `geomint.tableaux.order_conditions`.
    base_order : int
        Even order of the symmetric base method for which the coefficients are made.
    fractions : tuple of str
        Decimals of the first half :math:`\gamma_1, \gamma_2, \ldots` without the middle one.
    references : tuple of Reference, optional
        Where the coefficients are published; empty for one's own.

    Raises
    ------
    MethodError
        If an order is not even, or the composition does not raise the order of its base.
    """

    name: str
    order: int
    base_order: int
    fractions: tuple[str, ...]
    references: tuple[Reference, ...] = ()

    def _check(self) -> None:
        """Check the orders and that the fractions are numbers."""
        object.__setattr__(self, "references", checked_references(self.references))
        if self.order % 2 or self.base_order % 2 or not 0 < self.base_order < self.order:
            raise ValueError(f"{self.name}: even orders with 0 < base_order < order are needed")
        if not self.fractions or 0 in self.gamma_exact:
            raise ValueError(f"{self.name}: every fraction, and the middle one, must be non-zero")

    @property
    def stages(self) -> int:
        """Number of steps of the base method, an odd number s."""
        return 2 * len(self.fractions) + 1

    @cached_property
    def gamma_exact(self) -> Row:
        """All fractions as rationals, with sum exactly 1, shape (s,)."""
        half = tuple(Fraction(text) for text in self.fractions)
        middle = 1 - 2 * sum(half, Fraction(0))
        return (*half, middle, *reversed(half))

    @cached_property
    def gamma(self) -> Array:
        """Float64 numbers nearest to the fractions; bitwise palindromic, shape (s,)."""
        return nearest(self.gamma_exact)

    @cached_property
    def starts(self) -> Array:
        """Float64 numbers nearest to the exact starts (not sums of rounded ones), shape (s,)."""
        return nearest((Fraction(0), *accumulate(self.gamma_exact[:-1])))


@lru_cache(maxsize=256)
def substeps(*schemes: Composition) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return lengths and starts of the base steps of compositions within each other, outermost first.

    In units of the step, each rounded once.
    """
    lengths: Row = (Fraction(1),)
    for scheme in schemes:
        lengths = tuple(length * gamma for length in lengths for gamma in scheme.gamma_exact)
    starts = (Fraction(0), *accumulate(lengths[:-1]))
    return tuple(map(float, lengths)), tuple(map(float, starts))
