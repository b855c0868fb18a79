"""Symmetric compositions of symmetric methods."""

from dataclasses import dataclass, replace
from typing import Any, Self

from ..errors import MethodError, nearest, quoted
from ..tableaux import COMPOSITIONS, DEFAULT_COMPOSITION, Composition, default_composition, substeps
from .flow import Flow
from .method import Method, checked_method
from .posed import Posed

_SHORT = {"rattle-2": "rattle", "verlet-2": "verlet"}  # families named by their order


@dataclass(frozen=True, repr=False)
class Compose(Method):
    """Raise the order of a symmetric method by a palindromic composition of its steps.

    Parameters
    ----------
    base : Method
        A symmetric method of even order, such as ``Rattle()``, ``Gauss(2)`` or a composition.
    scheme : str, int or Composition
        A name from `geomint.tableaux.COMPOSITIONS`, or an order: the scheme that is best for it.

    Raises
    ------
    MethodError
        If the base is not symmetric, or the scheme does not raise its order.

    Notes
    -----
    A scheme that is made for a base of order q raises bases of higher order too, as it is a solution
    of all their order conditions (E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical
    Integration*, Section V.3). The options are those of the base.
    """

    base: Method
    scheme: str | int | Composition

    symmetric = True

    def __post_init__(self) -> None:
        base = checked_method("base", self.base)
        if not base.symmetric:
            raise MethodError(
                f"method {base.name!r} is not symmetric, and cannot be composed; symmetric are: "
                "gauss-1 … gauss-16, rattle-2, verlet-2, and their compositions"
            )
        table = _scheme(self.scheme, base)
        if not table.base_order <= base.order < table.order:
            raise MethodError(
                f"composition {table.name!r} raises bases of order {table.base_order} or more to "
                f"{table.order}, but {base.name!r} has order {base.order}"
            )
        short = _SHORT.get(base.name)
        best = short is not None and DEFAULT_COMPOSITION.get(table.order) == table.name
        self._set(
            scheme=table,
            name=f"{short}-{table.order}" if best else f"{base.name}-{table.name}",
            order=table.order,
            needs=base.needs,
            step_fraction=min(0.25, base.step_fraction * table.stages / 2),
            symplectic=base.symplectic,
            keeps=base.keeps,
            family=base.family,
            summary=f"{base.summary}; {table.stages} substeps",
            references=(*base.references, *table.references),
        )

    @property
    def table(self) -> Composition:
        """The scheme."""
        assert isinstance(self.scheme, Composition)
        return self.scheme

    @property
    def options(self) -> dict[str, Any]:
        return self.base.options

    def _with(self, options: dict[str, Any]) -> Self:
        return replace(self, base=self.base.with_options(**options))

    def flow(self, p: Posed) -> Flow:
        base, schemes = self.base, [self.table]
        while isinstance(base, Compose):
            schemes.append(base.table)
            base = base.base
        lengths, starts = substeps(*schemes)
        found = base.flow(p._replace(lengths=lengths, starts=starts))
        if len(found.fractions) != 2 * len(lengths):
            raise MethodError(f"method {base.name!r} is symmetric, but takes no substeps")
        return found


def _scheme(scheme: Any, base: Method) -> Composition:
    if isinstance(scheme, Composition):
        return scheme
    if isinstance(scheme, str):
        found = COMPOSITIONS.get(scheme)
    else:
        whole = isinstance(scheme, int) and not isinstance(scheme, bool)
        found = default_composition(base.order, scheme) if whole else None
    if found is None:
        hint = nearest(scheme if isinstance(scheme, str) else "", COMPOSITIONS)
        raise MethodError(f"no composition {quoted(scheme)}.{hint}")
    return found
