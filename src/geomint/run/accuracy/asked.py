"""What `geomint.solve` is asked for with a tolerance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...arguments import finite, switch
from ...errors import ConvergenceError, DomainError, NonFiniteError, StepSizeError
from ...methods import Exact, Method, find_solver
from ...problems.declaration import check_problem
from ...problems.problem import Problem
from ..timeline import ending
from .accuracy import Accuracy
from .choose import checked_tolerance, choose

__all__ = ["TOO_LONG", "check_alone", "choose_for"]

# What a step that is too long may end in; only on the way, where the motion is faster than before.
TOO_LONG = (ConvergenceError, NonFiniteError, StepSizeError)


def check_alone(problem: Any, step: Any, tolerance: Any) -> None:
    """Raise `DomainError` where a tolerance meets a step, or a run that goes on with the one it has."""
    checked_tolerance(tolerance)
    if step is not None:
        raise DomainError("step", step, "nothing beside tolerance, which chooses it")
    if not isinstance(problem, Problem):
        raise DomainError("tolerance", tolerance, "nothing: a solution goes on as it was")


def choose_for(
    problem: Problem,
    y0: Any,
    method: str | Method | None,
    tolerance: float,
    asked: Mapping[str, Any],
) -> Accuracy:
    """Return how a run of `geomint.solve`, with what else is asked of it, meets a tolerance."""
    chosen, t0 = find_solver(method), finite("t0", asked["t0"])
    if isinstance(chosen, Exact):
        raise DomainError("tolerance", tolerance, "nothing: the exact flow takes no steps")
    state = problem.canonical(y0)
    begin, end, own = ending(problem, asked["t_end"], asked["tau_end"], t0)
    clock, compiled = asked["clock"], switch("compiled", asked["compiled"])
    by_clock = problem.time == "tau" and (not own or asked["t_eval"] is not None)
    with_clock = problem.clock is not None if clock is None else clock is True
    with_clock = problem.time == "tau" and (by_clock or with_clock)
    chosen.check_fits(problem, with_clock)
    check_problem(problem, state, chosen.needs, with_clock)
    return choose(
        problem,
        chosen,
        state,
        end - begin,
        checked_tolerance(tolerance),
        begin=begin if own else 0.0,
        physical=not own,
        clock=with_clock,
        compiled=compiled,
    )
