"""Runge–Kutta–Munthe-Kaas methods on the group-action form."""

from __future__ import annotations

from fractions import Fraction
from math import comb, factorial

from ..kernels.blocks import scalar_block
from ..kernels.rkmk import rkmk_stepper, rkmk_work_size
from ..tableaux import Tableau
from .explicit import explicit_tableau, step_fraction
from .forms import action_of, substeps
from .method import Method, Start
from .stepper import Stepper, filled_block

__all__ = ["RKMK", "dexpinv_weights"]


def dexpinv_weights(terms: int) -> list[Fraction]:
    """Return B_k / k! for k < terms: ``dexp_u⁻¹ = Σ (B_k / k!) ad_u^k`` with B_1 = −1/2."""
    bernoulli: list[Fraction] = []
    for k in range(terms):
        total = sum((comb(k + 1, j) * bernoulli[j] for j in range(k)), Fraction(0))
        bernoulli.append(Fraction(1) if k == 0 else -total / (k + 1))
    return [b / factorial(k) for k, b in enumerate(bernoulli)]


def RKMK(tableau: str | Tableau = "rk-4") -> Method:  # noqa: N802 - reads as the method it is
    """Runge–Kutta–Munthe-Kaas method of an explicit tableau, at fixed step.

    Parameters
    ----------
    tableau : str or Tableau
        A name from `geomint.tableaux.RUNGE_KUTTA` or an explicit tableau.

    Notes
    -----
    The equation ``u̇ = dexp_u⁻¹ ξ`` is solved in the algebra by the tableau. The series of dexp⁻¹
    keeps the terms up to ad^(p−2) that order p needs, H. Munthe-Kaas, Appl. Numer. Math. 29 (1999)
    115. What the group's orbits keep is kept to rounding.
    """
    table = explicit_tableau(tableau)
    weights = [float(w) for w in dexpinv_weights(max(table.order - 1, 1))]

    def start(s: Start) -> Stepper:
        generator, group = action_of(s)
        rows, stages = s.problem.rows, table.stages
        memory = scalar_block(2 * rows)
        memory.data[:rows] = s.y0
        header = (rows, group.algebra_rows, stages, len(group.layout), s.problem.work, len(weights))
        numbers = (group.layout, weights, table.A_float, table.b_float, table.c_float)
        return Stepper(
            kernel=rkmk_stepper(),
            signatures=("field", "action", "action"),
            functions=(generator, group.act, group.bracket),
            params=filled_block(s.problem.params),
            coefficients=filled_block(*header, *numbers),
            fractions=substeps(),
            memory=memory,
            work=scalar_block(
                rkmk_work_size(rows, group.algebra_rows, stages, s.problem.work, group.work)
            ),
            rows=rows,
            t0=s.t0,
            h=s.h,
            evaluations=stages,
            compiled=s.compiled,
        )

    return Method(
        name=f"rkmk-{table.order}" if table.name in ("rk-4",) else f"rkmk-{table.name}",
        order=table.order,
        needs="action",
        start=start,
        step_fraction=step_fraction(table.order),
        summary=f"Runge–Kutta–Munthe-Kaas, {table.stages} exponentials a step",
        reference="H. Munthe-Kaas, Appl. Numer. Math. 29 (1999) 115",
    )
