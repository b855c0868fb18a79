"""Explicit Runge–Kutta methods on the ODE form: the baselines, at fixed and adaptive step."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any, TypeVar

from ..errors import MethodError, nearest, quoted
from ..kernels.numbers.blocks import packed, scalar_block
from ..kernels.solve.compensated import compensated_state
from ..kernels.solve.runge_kutta import (
    adaptive_runge_kutta_stepper,
    runge_kutta_coefficients,
    runge_kutta_stepper,
    runge_kutta_work,
)
from ..tableaux import RUNGE_KUTTA, Tableau
from .adaptive import controlled_stepper, made_adaptive
from .bound_forms import field_of, substeps, unrolled
from .method import Method, Start
from .stepper import Stepper, filled_block
from .tolerances import tolerances

__all__ = [
    "RungeKutta",
    "explicit_tableau",
    "fixed_step_numbers",
    "step_fraction",
    "tableau_of",
]

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


def RungeKutta(  # noqa: N802 - reads as the method it is
    tableau: str | Tableau = "rk-4",
    *,
    adaptive: bool = False,
    rtol: float | None = None,
    atol: float | None = None,
    max_step: float | None = None,
    max_steps: int | None = None,
) -> Method:
    """Explicit Runge–Kutta method of a tableau, at fixed or adaptive step.

    Parameters
    ----------
    tableau : str or Tableau
        A name from `geomint.tableaux.RUNGE_KUTTA` or an explicit tableau.
    adaptive : bool
        Choose every step by the error that the tableau's embedded weights estimate.
    rtol, atol : float
        With ``adaptive``: a step is accepted if its estimated error is at most
        ``atol + rtol max |y_i|`` in every piece of the state. Defaults 1e-8 and 1e-12.
    max_step : float
        With ``adaptive``: no step is longer. Default: no bound.
    max_steps : int
        With ``adaptive``: a run that needs more is a `StepLimitError`. Default: 10⁸.

    Raises
    ------
    DomainError
        For tolerances that make no sense.
    MethodError
        If the tableau is implicit or, with ``adaptive``, has no embedded method.

    Notes
    -----
    The state is a compensated sum. Nothing else is preserved: energy and constraints drift.
    Adaptive steps use local extrapolation and a PI controller (`geomint.kernels.solve.step_control`); a
    last stage that is the new value serves the next step. A clock beside a problem in τ is one more
    piece of the state.
    """
    table = explicit_tableau(tableau)
    allowed = tolerances(table, adaptive, rtol, atol, max_step, max_steps)
    stages, numbers = fixed_step_numbers(table)

    def start(s: Start) -> Stepper:
        field, rows, y0, work = field_of(s)
        memory = scalar_block(sum(compensated_state(rows)))
        memory.data[:rows] = y0
        return Stepper(
            kernel=runge_kutta_stepper(*unrolled(rows)),
            functions=(field,),
            params=filled_block(s.problem.params),
            coefficients=packed(
                runge_kutta_coefficients(stages, 0), rows=rows, stages=stages, **numbers
            ),
            fractions=substeps(),
            memory=memory,
            work=scalar_block(sum(runge_kutta_work(rows, stages, work))),
            rows=rows,
            t0=s.t0,
            h=s.h,
            evaluations=stages,
            compiled=s.compiled,
        )

    def start_adaptive(s: Start) -> Stepper:
        assert allowed is not None
        _, rows, y0, work = field_of(s)
        return controlled_stepper(
            s,
            table,
            allowed,
            start(s),
            kernel=adaptive_runge_kutta_stepper(*unrolled(rows)),
            y0=y0,
            derivative_rows=rows,
            layout=runge_kutta_coefficients,
            sizes={"rows": rows, "stages": table.stages},
            work_rows=sum(runge_kutta_work(rows, table.stages, work)),
        )

    method = Method(
        name=table.name,
        order=table.order,
        needs="field",
        family="explicit Runge–Kutta",
        start=start,
        step_fraction=step_fraction(table.order),
        summary=f"explicit Runge–Kutta, {stages} stages",
        reference=table.reference,
    )
    if allowed is None:
        return method
    return made_adaptive(
        method, table, allowed, start_adaptive, functools.partial(RungeKutta, table, adaptive=True)
    )
