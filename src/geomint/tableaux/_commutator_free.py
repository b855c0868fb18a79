"""Commutator-free tableaux: stages are products of exponentials of combinations of generators."""

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import chain
from typing import NamedTuple

from ..references.reference import Reference, checked_references
from ._exact import Array, Exact, Row, read_only, row
from ._tableau import Tableau


class Flow(NamedTuple):
    """Exponentials that carry one stage value, or the value of the step, to another one."""

    start: int
    """Stage the flow starts from, counted from 1; 0 is the value at the start of the step."""
    exponentials: tuple[Row, ...]
    """One row of coefficients of K_1, K_2, ... per exponential; the first acts first."""


def flow(start: int, *exponentials: str) -> Flow:
    """Read a `Flow`; zeros at the end of a row may be left out.

    Examples
    --------
    >>> from geomint.tableaux import flow
    >>> flow(2, "-1/2 0 1")
    Flow(start=2, exponentials=((Fraction(-1, 2), Fraction(0, 1), Fraction(1, 1)),))
    """
    return Flow(start, tuple(row(text) for text in exponentials))


@dataclass(frozen=True)
class CommutatorFreeTableau(Exact):
    r"""A Lie group method whose stages are products of exponentials.

    For :math:`\dot y = f(t, y) \cdot y`, where f takes values in the Lie algebra of a group that
    acts on y from the left,

    .. math::

        Y_i = \exp\Big(\sum_j a^{(m)}_{ij} K_j\Big) \cdots \exp\Big(\sum_j a^{(1)}_{ij} K_j\Big)
              \cdot Y_{\mathrm{start}(i)}, \qquad K_i = h f(t_0 + c_i h, Y_i),

    with :math:`Y_0 = y_0`, and the new value is such a product as well (E. Celledoni,
    A. Marthinsen, B. Owren, Future Gener. Comput. Syst. 19 (2003) 341). For an action from the
    right read every product in the opposite direction. A Crouch-Grossman method has a single
    non-zero coefficient in each row.

    Parameters
    ----------
    name : str
        Name in a registry.
    order : int
        Order on any group; a statement to be tested, see `geomint.tableaux.order_conditions`.
    stages : tuple of Flow
        Stage i starts from an earlier stage and uses the generators of earlier stages only.
    update : Flow
        The product that yields the new value.
    references : tuple of Reference, optional
        Where the method is published; empty for one's own.
    tolerance : Fraction
        Largest defect of the total weight 1 that the rounding of published decimals explains.

    Raises
    ------
    ArgumentError
        If a coefficient is not a `Fraction`.
    MethodError
        If a stage depends on itself or a later one, or the update has not total weight 1.
    """

    name: str
    order: int
    stages: tuple[Flow, ...]
    update: Flow
    references: tuple[Reference, ...] = ()
    tolerance: Fraction = Fraction(0)

    def _check(self) -> None:
        """Check types, the order of evaluation and the total weight."""
        object.__setattr__(self, "references", checked_references(self.references))
        for i, (start, exponentials) in enumerate(self.flows, start=1):
            if not all(isinstance(a, Fraction) for a in chain.from_iterable(exponentials)):
                raise TypeError(f"{self.name}: coefficients must be Fractions, as flow() reads")
            if not 0 <= start < i or any(len(a) >= i for a in exponentials):
                raise ValueError(f"{self.name}: flow {i} uses a stage that is not known yet")
        if abs(self._ends[-1] - 1) > self.tolerance:
            raise ValueError(f"{self.name}: the update has not total weight 1")

    @property
    def flows(self) -> tuple[Flow, ...]:
        """Stages and update, in order of evaluation."""
        return (*self.stages, self.update)

    @property
    def exponentials(self) -> int:
        """Number of exponentials a step computes."""
        return sum(len(each.exponentials) for each in self.flows)

    @property
    def row_sums(self) -> tuple[Row, ...]:
        """Time each exponential covers, in units of the step, one row for each flow."""
        return tuple(tuple(sum(a, Fraction(0)) for a in each.exponentials) for each in self.flows)

    @property
    def c(self) -> Row:
        """Nodes: ``c_i = c_start(i) +`` the row sums of stage i, shape (s,)."""
        return self._ends[:-1]

    @cached_property
    def classical(self) -> Tableau:
        """The Runge-Kutta method obtained when the group commutes: exponents simply add."""
        s = len(self.stages)
        totals: list[Row] = []
        for start, exponentials in self.flows:
            total = totals[start - 1] if start else (Fraction(0),) * s
            for a in exponentials:
                padded = a + (Fraction(0),) * (s - len(a))
                total = tuple(x + y for x, y in zip(total, padded, strict=True))
            totals.append(total)
        *A, b = totals
        name = f"{self.name} on a commutative group"
        tolerance = self.tolerance
        return Tableau(name, self.order, tuple(A), b, self.c, self.references, tolerance=tolerance)

    @property
    def _ends(self) -> Row:
        """Time each flow ends at, in units of the step, shape (s + 1,)."""
        ends: list[Fraction] = []
        for each, sums in zip(self.flows, self.row_sums, strict=True):
            ends.append(sum(sums, ends[each.start - 1] if each.start else Fraction(0)))
        return tuple(ends)

    @cached_property
    def numbers(self) -> Array:
        """All flows one after another, as kernels read them.

        Of each the stage it starts from, counted from 0 (−1: the old value), the number of its
        exponentials, and for each of these s coefficients in float64.
        """
        s = len(self.stages)
        found: list[float] = []
        for start, exponentials in self.flows:
            found += [start - 1, len(exponentials)]
            for a in exponentials:
                found += [*map(float, a)] + [0.0] * (s - len(a))
        return read_only(found)
