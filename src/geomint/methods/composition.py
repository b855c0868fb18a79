"""Symmetric compositions of symmetric methods."""

from __future__ import annotations

from dataclasses import replace

from ..errors import MethodError, nearest, quoted
from ..tableaux import COMPOSITIONS, DEFAULT_COMPOSITION
from .method import Method

__all__ = ["Compose"]


def Compose(base: Method, scheme: str | int) -> Method:  # noqa: N802 - reads as the method it is
    """Raise the order of a symmetric method by a palindromic composition of its steps.

    Parameters
    ----------
    base : Method
        A symmetric method of even order, such as ``Rattle()`` or ``Gauss(1)``.
    scheme : str or int
        A name from `geomint.tableaux.COMPOSITIONS`, or an order: the best known scheme of it.
    """
    if not isinstance(base, Method):
        raise MethodError(f"base = {quoted(base)}: expected a geomint method")
    if base.compose is None:
        raise MethodError(
            f"method {base.name!r} is composed already, or not symmetric, and cannot be composed; "
            "symmetric are: gauss-1 … gauss-16, rattle-2, verlet-2"
        )
    name = DEFAULT_COMPOSITION.get(scheme) if isinstance(scheme, int) else scheme
    if not (isinstance(name, str) and name in COMPOSITIONS):
        hint = nearest(scheme if isinstance(scheme, str) else "", COMPOSITIONS)
        raise MethodError(f"no composition {quoted(scheme)}.{hint}")
    table = COMPOSITIONS[name]
    if base.order != table.base_order:
        raise MethodError(
            f"composition {name!r} is made for a base of order {table.base_order}, "
            f"but {base.name!r} has order {base.order}"
        )
    return replace(
        base,
        name=f"{base.name}-{name}",
        order=table.order,
        start=base.compose(tuple(table.gamma), tuple(table.starts)),
        compose=None,
        remake=lambda **options: Compose(base.with_options(**options), scheme),
        step_fraction=min(0.25, base.step_fraction * table.stages / 2),
        summary=f"{base.summary}; {table.stages} substeps",
        reference="; ".join(filter(None, (base.reference, table.reference))),
    )
