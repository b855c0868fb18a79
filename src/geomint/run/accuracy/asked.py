"""What `geomint.solve` is asked for with a tolerance."""

import math
from typing import Any

from ...arguments import finite, number, switch
from ...errors import ConvergenceError, DomainError, NonFiniteError, StepSizeError
from ...methods import Exact, find_solver
from ...problems.evaluate import rates_of, value_of
from ...problems.problem import Problem
from ...problems.time_scale import characteristic_time
from ..asked import Asked
from ..promise import Setting
from ..solution import Solution
from ..timeline import ending, within_run
from .another_time import better, in_another_time
from .auto import auto_method, is_auto
from .choose import Wanted, choose
from .stretch import Motion

# What a step that is too long may end in; only on the way, where the motion is faster than before.
TOO_LONG = (ConvergenceError, NonFiniteError, StepSizeError)


def choose_for(
    problem: Problem | Solution,
    y0: Any,
    asked: Asked,
    tolerance: Any,
    rate: float | None = None,
) -> Setting:
    """Return how a run of `geomint.solve`, with what is asked of it, meets a tolerance.

    `rate` is that of the clock in the mean, where more is known than that at y0.

    Raises
    ------
    DomainError
        For a tolerance that is none, beside a step, or for a run that goes on with the step it has.
    MethodError
        If a method is to be chosen and there is no tolerance.
    """
    if tolerance is not None:
        known = "a number from 2⁻⁵² = 2.2e-16 to below 0.1"
        tolerance = number("tolerance", tolerance, 2.0**-52, 0.1, known)
    method = asked.method
    if asked.step is not None:
        raise DomainError("step", asked.step, "nothing beside a tolerance, which chooses it")
    if not isinstance(problem, Problem):
        name, value = ("method", method) if tolerance is None else ("tolerance", tolerance)
        raise DomainError(name, value, "nothing: a solution goes on as it was")
    t0, reason = finite("t0", asked.t0), ""
    if is_auto(method):
        chosen, reason = auto_method(problem, tolerance)
    else:
        chosen = find_solver(method, problem)
    if isinstance(chosen, Exact):
        raise DomainError("tolerance", tolerance, "nothing: the exact flow takes no steps")
    state = problem.canonical(y0)
    begin, end, own = ending(problem, asked.t_end, asked.tau_end, t0)
    if begin == end:
        return Setting.default(chosen, problem)
    clock, compiled = asked.clock, switch("compiled", asked.compiled)
    by_clock = problem.time == "tau" and (not own or asked.t_eval is not None)
    with_clock = problem.clock is not None if clock is None else clock is True
    with_clock = problem.time == "tau" and (by_clock or with_clock)
    chosen.on(problem, state, begin if own else 0.0, with_clock, compiled)
    span, physical, breaks = end - begin, None, asked.breaks
    if not own:
        assert problem.clock is not None
        rate = rate or value_of(problem, problem.clock, state, compiled)(state, 0.0)
        span, physical = (span / rate if rate > 0.0 else span), abs(span)
    at = begin if own else 0.0
    rate_at = rates_of(problem, state, compiled)
    rate_at = within_run(rate_at, breaks, span, end if own else None)
    wanted = Wanted(
        Motion(problem, state, at, span, physical, compiled),
        tolerance,
        characteristic_time(problem, state, span, at, rate_at),
        abs(breaks[0] - at) if breaks else math.inf,
        with_clock,
        watched=bool(asked.observe),
        reason=reason,
    )
    found = choose(wanted, chosen)
    uneven = in_another_time(found, problem, asked, compiled)
    if uneven is None:
        return found
    other = choose_for(uneven[0], state, asked._replace(clock=None), tolerance, uneven[1])
    return better(found, other, uneven[0])
