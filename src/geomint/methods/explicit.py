"""Explicit Runge–Kutta methods on the ODE form: the baselines."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from ..errors import MethodError, nearest
from ..kernels.blocks import scalar_block
from ..kernels.runge_kutta import runge_kutta_stepper, runge_kutta_work_size
from ..tableaux import RUNGE_KUTTA, Tableau
from .forms import field_of, substeps
from .method import Method, Start
from .stepper import Stepper, filled_block

__all__ = ["RungeKutta", "explicit_tableau", "step_fraction", "tableau_of"]

T = TypeVar("T")

# The order of the tableau decides how far a step may reach (a stated rule, not an error bound).
_STEP_FRACTION = {1: 0.005, 2: 0.01, 3: 0.02, 4: 0.03, 5: 0.05, 8: 0.1}


def step_fraction(order: int) -> float:
    """Return the default step of an explicit method, in characteristic times."""
    return _STEP_FRACTION.get(order, 0.05)


def tableau_of(registry: Mapping[str, T], tableau: str | T) -> T:
    """Return a tableau given by itself or by name, or raise `MethodError`."""
    if not isinstance(tableau, str):
        return tableau
    if tableau not in registry:
        raise MethodError(f"tableau = {tableau!r}: no such tableau.{nearest(tableau, registry)}")
    return registry[tableau]


def explicit_tableau(tableau: str | Tableau) -> Tableau:
    """Return an explicit Runge–Kutta tableau, or raise `MethodError`."""
    table = tableau_of(RUNGE_KUTTA, tableau)
    if not table.explicit:
        raise MethodError(f"tableau {table.name!r} is implicit; Gauss methods are geomint.Gauss")
    return table


def RungeKutta(tableau: str | Tableau = "rk-4") -> Method:  # noqa: N802 - reads as the method it is
    """Explicit Runge–Kutta method of a tableau, at fixed step.

    Parameters
    ----------
    tableau : str or Tableau
        A name from `geomint.tableaux.RUNGE_KUTTA` or an explicit tableau.

    Notes
    -----
    The state is a compensated sum. Nothing else is preserved: energy and constraints drift.
    """
    table = explicit_tableau(tableau)

    def start(s: Start) -> Stepper:
        field, rows, y0, work = field_of(s)
        memory = scalar_block(2 * rows)
        memory.data[:rows] = y0
        return Stepper(
            kernel=runge_kutta_stepper(),
            signatures=("field",),
            functions=(field,),
            params=filled_block(s.problem.params),
            coefficients=filled_block(
                rows, table.stages, table.A_float, table.b_float, table.c_float
            ),
            fractions=substeps(),
            memory=memory,
            work=scalar_block(runge_kutta_work_size(rows, table.stages, work)),
            rows=rows,
            t0=s.t0,
            h=s.h,
            evaluations=table.stages,
            compiled=s.compiled,
        )

    return Method(
        name=table.name,
        order=table.order,
        needs="field",
        start=start,
        step_fraction=step_fraction(table.order),
        summary=f"explicit Runge–Kutta, {table.stages} stages",
        reference=table.reference,
    )
