"""What `geomint.solve` is asked for with a tolerance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...arguments import finite, switch
from ...errors import ConvergenceError, DomainError, NonFiniteError, StepSizeError
from ...methods import Exact, Method, find_solver
from ...problems.declaration import check_problem
from ...problems.problem import Problem
from ..promise import Setting
from ..solution import Solution
from ..timeline import ending
from .auto import auto_method, is_auto
from .choose import checked_tolerance, choose

__all__ = ["TOO_LONG", "choose_for"]

# What a step that is too long may end in; only on the way, where the motion is faster than before.
TOO_LONG = (ConvergenceError, NonFiniteError, StepSizeError)


def choose_for(
    problem: Problem | Solution,
    y0: Any,
    method: str | Method | None,
    step: Any,
    tolerance: Any,
    asked: Mapping[str, Any],
) -> Setting:
    """Return how a run of `geomint.solve`, with what else is asked of it, meets a tolerance.

    Raises
    ------
    DomainError
        For a tolerance that is none, beside a step, or for a run that goes on with the step it has.
    MethodError
        If a method is to be chosen and there is no tolerance.
    """
    if tolerance is not None:
        tolerance = checked_tolerance(tolerance)
    if step is not None:
        raise DomainError("step", step, "nothing beside a tolerance, which chooses it")
    if not isinstance(problem, Problem):
        name, value = ("method", method) if tolerance is None else ("tolerance", tolerance)
        raise DomainError(name, value, "nothing: a solution goes on as it was")
    t0, reason = finite("t0", asked["t0"]), ""
    if is_auto(method):
        chosen, reason = auto_method(problem, tolerance)
    else:
        chosen = find_solver(method)
    if isinstance(chosen, Exact):
        raise DomainError("tolerance", tolerance, "nothing: the exact flow takes no steps")
    state = problem.canonical(y0)
    begin, end, own = ending(problem, asked["t_end"], asked["tau_end"], t0)
    clock, compiled = asked["clock"], switch("compiled", asked["compiled"])
    by_clock = problem.time == "tau" and (not own or asked["t_eval"] is not None)
    with_clock = problem.clock is not None if clock is None else clock is True
    with_clock = problem.time == "tau" and (by_clock or with_clock)
    chosen.check_fits(problem, with_clock)
    functions = check_problem(problem, state, chosen.needs, with_clock)
    return choose(
        problem,
        chosen,
        state,
        end - begin,
        tolerance,
        begin=begin if own else 0.0,
        breaks=asked.get("breaks", ()),
        physical=not own,
        clock=with_clock,
        compiled=compiled,
        functions=functions,
        watched=bool(asked["observe"]),
        reason=reason,
    )
