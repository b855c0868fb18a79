"""What is asked of a run, and what of it makes no sense: the same for runs with steps and without."""

import math
from typing import Any, NamedTuple

from ..arguments import Array, switch, whole
from ..errors import DomainError
from ..methods import Method
from ..problems.problem import Problem
from .callback import Callback
from .restart import Restart
from .solution import Solution
from .timeline import Timeline, evaluation_times

OPTIONAL = ("clock", "progress", "keep_states")  # switches that are chosen where nobody has said


class Asked(NamedTuple):
    """What is asked of one run: the arguments of `geomint.solve`, and what `solve` adds.

    Attributes
    ----------
    admitted : array, optional
        The initial state made canonical, where that has been done.
    turning : bool
        Whether steps whose iteration does not converge are taken by what the method has for them;
        else they end the run.
    given : bool
        Whether the user has given the step.
    confirmed : bool
        Whether a second run shall tell the error at the end.
    breaks : tuple of float
        As `breaks_of` returns them; they may lie beyond the end.
    halved : float
        The step of a run with breaks of whose steps each is halved.
    most : float
        Iterations, from which on it is a `StepLimitError`.
    """

    t0: float = 0.0
    t_end: float | None = None
    tau_end: float | None = None
    method: str | Method | None = None
    step: float | None = None
    t_eval: Any = None
    tau_eval: Any = None
    dense: bool = False
    events: Any = None
    save_every: int | None = None
    observe: Any = ()
    observe_every: int = 1
    clock: bool | None = None
    callback: Callback | None = None
    estimate_error: bool = False
    breaks: tuple[float, ...] = ()
    longest: float | None = None
    progress: bool | None = None
    compiled: bool = True
    admitted: Array | None = None
    turning: bool = True
    given: bool = True
    confirmed: bool = False
    halved: float = 0.0
    most: float = math.inf


def restart_of(solution: Solution, clock: Any, **given: Any) -> Restart:
    """Return where a solution goes on, or raise `DomainError` for what it has already."""
    for name, value in given.items():
        if value is not None:
            raise DomainError(name, value, "nothing: a solution goes on as it was")
    if solution.restart is None:
        raise DomainError("problem", solution, "a solution that can go on: this one has no restart")
    if clock is not None and clock != solution.restart.clock and solution.problem.time == "tau":
        raise DomainError("clock", clock, f"{solution.restart.clock}, as before")
    return solution.restart


def check_switches(**given: Any) -> None:
    """Raise `DomainError` for what says neither yes nor no; None is for what is `OPTIONAL` alone."""
    for name, value in given.items():
        if value is None and name in OPTIONAL:
            continue
        if value is not True and value is not False:
            switch(name, value, "True, False or None" if name in OPTIONAL else "True or False")


def wants_clock(
    problem: Problem, timeline: Timeline, t_eval: Any, clock: bool | None
) -> bool | None:
    """Return whether physical time is wanted beside a problem in τ, None for where it can be had.

    Raises
    ------
    DomainError
        For what contradicts the times that are asked for.
    """
    if problem.time == "t":
        if clock:
            raise DomainError("clock", clock, f"False: the time of {problem.name!r} is physical")
        return False
    if timeline.physical_end is not None or t_eval is not None:
        if clock is False:
            raise DomainError("clock", clock, "True: t_end and t_eval are physical time")
        return True
    return clock


def wanted_times(
    problem: Problem, timeline: Timeline, begin: float, own: float, t_eval: Any, tau_eval: Any
) -> Array:
    """Return the times at which states are wanted, from physical time or own time on."""
    if tau_eval is None:
        return evaluation_times(t_eval, problem, timeline, begin)
    if t_eval is not None:
        raise DomainError("tau_eval", tau_eval, "t_eval or tau_eval, not both")
    return evaluation_times(tau_eval, problem, timeline, own, "tau_eval")


def check_counts(watched: Any, save_every: Any, observe_every: Any) -> None:
    """Raise `DomainError` for numbers of steps that are none, or that nothing would follow."""
    if save_every is not None:
        whole("save_every", save_every, 1)
    whole("observe_every", observe_every, 1)
    if observe_every != 1 and not watched:
        raise DomainError("observe_every", observe_every, "1, or something to observe")
