"""Explicit Runge–Kutta methods on the ODE form: the baselines, at fixed and adaptive step."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from ..errors import MethodError, nearest, quoted
from ..kernels.numbers.blocks import packed
from ..kernels.solve.compensated import compensated_state
from ..kernels.solve.runge_kutta import (
    adaptive_runge_kutta_stepper,
    runge_kutta_coefficients,
    runge_kutta_stepper,
    runge_kutta_work,
)
from ..tableaux import RUNGE_KUTTA, Tableau
from .adaptive import Adaptive
from .adaptive_stepper import controlled
from .flow import Flow
from .method import Method
from .posed import Posed, unrolled

T = TypeVar("T")

# The order of the tableau decides how far a step may reach (a stated rule, not an error bound).
_STEP_FRACTION = {1: 0.005, 2: 0.01, 3: 0.02, 4: 0.03, 5: 0.05, 8: 0.1}


def step_fraction(order: int) -> float:
    """Return the default step of an explicit method, in characteristic times."""
    return _STEP_FRACTION.get(order, 0.05)


def tableau_of(registry: Mapping[str, T], tableau: str | T, kind: type[T]) -> T:
    """Return a tableau given by itself or by name, or raise `MethodError`."""
    if isinstance(tableau, kind):
        return tableau
    if not isinstance(tableau, str):
        raise MethodError(f"tableau = {quoted(tableau)}: expected a name or a {kind.__name__}")
    if tableau not in registry:
        hint = nearest(tableau, registry)
        raise MethodError(f"tableau = {quoted(tableau)}: no such tableau.{hint}")
    return registry[tableau]


def explicit_tableau(tableau: str | Tableau) -> Tableau:
    """Return an explicit Runge–Kutta tableau, or raise `MethodError`."""
    table = tableau_of(RUNGE_KUTTA, tableau, Tableau)
    if not table.explicit:
        raise MethodError(f"tableau {table.name!r} is implicit; Gauss methods are geomint.Gauss")
    return table


def fixed_step_numbers(table: Tableau) -> tuple[int, dict[str, Any]]:
    """Return the number of stages that the new value needs, and their coefficients by name."""
    s = table.used_stages
    numbers = {"A": table.A_float[:s, :s], "b": table.b_float[:s], "c": table.c_float[:s]}
    return s, {**numbers, "errors": []}


@dataclass(frozen=True, repr=False)
class RungeKutta(Method):
    """Explicit Runge–Kutta method of a tableau; `geomint.Adaptive` chooses its steps.

    Parameters
    ----------
    tableau : str or Tableau
        A name from `geomint.tableaux.RUNGE_KUTTA` or an explicit tableau.

    Raises
    ------
    MethodError
        If the tableau is implicit.

    Notes
    -----
    The state is a compensated sum. Nothing else is preserved: energy and constraints drift.
    """

    tableau: str | Tableau = "rk-4"

    needs = "field"
    family = "explicit Runge–Kutta"

    def __post_init__(self) -> None:
        table = explicit_tableau(self.tableau)
        self._set(
            tableau=table,
            name=table.name,
            order=table.order,
            estimate_order=table.estimate_order,
            step_fraction=step_fraction(table.order),
            summary=f"explicit Runge–Kutta, {table.used_stages} stages",
            references=table.references,
        )

    @property
    def table(self) -> Tableau:
        """The tableau."""
        assert isinstance(self.tableau, Tableau)
        return self.tableau

    def flow(self, p: Posed) -> Flow:
        stages, numbers = fixed_step_numbers(self.table)
        rows, work = p.rows, p.problem.work
        return p.flow(
            kernel=runge_kutta_stepper(*unrolled(rows)),
            functions=(p.field,),
            coefficients=packed(
                runge_kutta_coefficients(stages, 0), rows=rows, stages=stages, **numbers
            ),
            memory=compensated_state(rows),
            work=runge_kutta_work(rows, stages, work),
            evaluations=stages,
            lane_by_lane=True,
        )

    def adaptive_flow(self, p: Posed, allowed: Adaptive) -> Flow:
        rows, work = p.rows, p.problem.work
        return controlled(
            p,
            self.table,
            allowed,
            self.flow(p),
            kernel=adaptive_runge_kutta_stepper(*unrolled(rows)),
            derivative_rows=rows,
            layout=runge_kutta_coefficients,
            sizes={"rows": rows, "stages": self.table.stages},
            work_rows=sum(runge_kutta_work(rows, self.table.stages, work)),
        )
