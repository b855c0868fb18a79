"""What every method has."""

from itertools import pairwise
from typing import Any

import numpy as np

from ..arguments import Array, whole
from ..errors import DomainError
from ..methods.method import Method
from ..problems.problem import Problem
from ..problems.testproblems import neumann, pulsating_body, sphere_metric
from ..run.solve import solve
from .judge import checks, hold, small, sure

__all__ = ["check_method"]

T_END = 4.0
NEAR = 0.5  # the nearest whole number is the order
HIGHEST = 8  # there are hardly two errors above rounding beyond: an order is at least that
FLOOR = 2e-13  # errors below have too much rounding in them to show an order
STEP, BACK = 0.2, 1e-14  # of the step that a symmetric method goes back
COUNTS = (8, 16, 32, 64, 128, 256, 512)


@checks(Method)
def check_method(method: Method, compiled: bool = True) -> None:
    """Raise `AssertionError` for the first property of a method that does not hold.

    Errors fall with the order that it states, on a problem of its form that depends on time; runs have
    the same bits; what is symmetric goes back over its own steps.

    Parameters
    ----------
    method : Method
    compiled : bool
        Whether to compile; plain Python takes some seconds, a compilation up to ten, once.

    Raises
    ------
    DomainError
        For an adaptive method, which has no steps to halve.
    """
    if method.adaptive:
        raise DomainError("method", method.name, "a method of fixed steps")
    whole("order", method.order, 1)
    problem, y0 = _problem(method.needs)
    options: dict[str, Any] = {"method": method, "compiled": compiled}
    exact = solve(problem, y0, t_end=T_END, step=T_END / 400, method="dop853", compiled=compiled)
    errors = []
    for count in COUNTS:
        one, two = (solve(problem, y0, t_end=T_END, step=T_END / count, **options) for _ in "12")
        hold(one.y[-1], two.y[-1], f"two runs of {method.name} are not the same")
        errors.append(float(np.max(np.abs(one.y[-1] - exact.y[-1]))))
    text = (
        f"{method.name} is not of order {method.order}: errors {errors} at steps halved each time"
    )
    small(errors[-1], max(errors[0], FLOOR), text)
    orders = [float(np.log2(a / b)) for a, b in pairwise(errors) if b > FLOOR]
    if method.order <= HIGHEST:
        sure(orders and abs(orders[-1] - method.order) < NEAR, text)
    else:
        sure(not orders or orders[-1] > HIGHEST, text)
    if method.symmetric:
        stepper = method.on(problem, y0, compiled=compiled).begin(y0, 0.0, STEP)
        back = stepper.single_step(stepper.single_step(y0, 0.0, STEP), STEP, -STEP)
        small(back - y0, BACK, f"{method.name} is symmetric, and does not go back")


def _problem(form: str) -> tuple[Problem, Array]:
    """Return a problem of that form that has a field as well, and depends on time, with a state."""
    if form == "action":
        return pulsating_body.problem(), pulsating_body.INITIAL
    if form == "hamiltonian":
        metric = sphere_metric.problem()
        return metric, sphere_metric.initial(metric)
    return neumann.problem(season=0.4), neumann.initial()
