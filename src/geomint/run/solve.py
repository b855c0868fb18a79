"""`solve`: integrate a problem from an initial state."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

from ..arguments import switch, whole
from ..errors import DomainError, GeomintWarning, StepError
from ..methods import Method, Start, find_method
from ..methods.agreement import check_agreement
from ..methods.stepper import Stepper
from ..problems.declaration import check_problem
from ..problems.problem import Problem
from ..watch.observe import MEASURE, Observers, choose_observables
from .calls import explained
from .driver import Account, drive
from .progress import Progress
from .recorder import Recorder
from .result import Status
from .solution import Solution
from .timeline import Timeline, plan_timeline

__all__ = ["solve"]


@explained
def solve(
    problem: Problem,
    y0: Any,
    *,
    t_end: float | None = None,
    tau_end: float | None = None,
    method: str | Method = "gauss-8",
    step: float | None = None,
    t_eval: Any = None,
    save_every: int | None = None,
    observe: Any = (),
    observe_every: int = 1,
    measure_steps: int | None = None,
    clock: bool | None = None,
    progress: bool | None = None,
    compiled: bool = True,
) -> Solution:
    """Integrate `problem` from `y0` at time 0.

    Parameters
    ----------
    problem : Problem
    y0 : array_like
        Flat state in the problem's documented order; `Problem.state` makes one.
    t_end, tau_end : float
        Exactly one: the end in physical time, met by a last partial step, or (for a problem in τ)
        in the problem's own time. Negative: backwards.
    method : str or Method
        Such as ``"gauss-8"`` or ``geomint.Gauss(8)``.
    step : float, optional
        Step in the problem's own time, > 0. Default: the method's ``step_fraction`` of the
        characteristic time at y0 (`geomint.problems.time_scale.characteristic_time`). If the end is
        a whole number of steps away, to 1e-9, the step is adjusted to meet it; else a last partial
        step is. For an adaptive method the first step, by default one that its tolerances allow;
        all further ones are the method's choice.
    t_eval : array_like, optional
        Physical times in the order of the run and within it at which states are wanted, met exactly by
        partial steps beside the run, which they do not disturb. Without `save_every` the states at
        these times alone are saved, just as they are asked for.
    save_every : int, optional
        Save the initial state, every that many steps, and the last state. Default: the last only.
        With `t_eval` both kinds of states are saved, in the order of the run and each once: a time of
        `t_eval` that is that of a saved step, to rounding, is that step.
    observe : names, or mapping of names to functions
        What to watch, see `geomint.watch.observe.choose_observables`.
    observe_every : int
        Watch every that many steps, and at the end. Only with something to observe.
    measure_steps : int, optional
        Watch the measure over the first that many steps only; it costs as much as tens of steps.
        Default: all. Only if the measure is observed.
    clock : bool, optional
        Whether physical time is integrated beside a problem in τ. Default: if the method and the
        problem can.
    progress : bool, optional
        Show progress. Default: if standard error is a terminal.
    compiled : bool
        False runs the same kernels in plain Python, to the same bits, thousands of times slower.

    Returns
    -------
    Solution
        After Ctrl-C, what was computed, with ``status`` "interrupted".

    Raises
    ------
    ArgumentError, DomainError, FormError, MethodError, DeclarationError
        Before anything is computed; the last where a function of the problem does not fit what it
        declares (`geomint.problems.declaration`), or does what the rules of `geomint.field` exclude.
    ConvergenceError, NonFiniteError, StepSizeError, StepLimitError, ClockError
        With t, step, residual and iterations; ``partial`` is the solution up to there.
    """
    _check_switches(compiled=compiled, clock=clock, progress=progress)
    chosen = find_method(method)
    state = problem.canonical(y0)
    timeline = plan_timeline(problem, chosen, state, t_end, tau_end, step)
    wants_clock = _wants_clock(problem, chosen, timeline, t_eval, clock)
    chosen.check_fits(problem, wants_clock)
    watched = choose_observables(problem, observe)
    _check_counts(watched, save_every, observe_every, measure_steps)
    check_problem(problem, state, chosen.needs, wants_clock, watched)
    stepper = chosen.start(
        Start(
            problem,
            state,
            0.0,
            timeline.h,
            clock=wants_clock,
            compiled=compiled,
            end=timeline.own_end,
        )
    )
    samples = timeline.expected / observe_every
    observers = Observers(problem, watched, state, stepper, measure_steps, samples)
    recorder = Recorder(problem, stepper, timeline, observers, save_every, observe_every, t_eval)
    total = timeline.own_end or timeline.physical_end if timeline.steps is None else timeline.steps
    with Progress(progress, None if total is None else abs(total), chosen.name) as bar:
        stepper.prepare()
        check_agreement(problem.name, stepper)
        observers.prepare()
        bar.begin()
        account = Account()
        status = _integrate(
            stepper, timeline, recorder, account, _displayed(bar, recorder, timeline)
        )
        recorder.observe_end()
        solution = recorder.solution(chosen, account, bar.compile_seconds, status)
    if step is not None:
        _tell_short_run(solution, abs(recorder.own_time), float(step))
    if isinstance(status, StepError):
        status.partial = solution
        raise status
    return solution


def _check_switches(compiled: Any, **optional: Any) -> None:
    """Raise `DomainError` for what says neither yes nor no."""
    switch("compiled", compiled)
    for name, value in optional.items():
        if value is not None:
            switch(name, value, "True, False or None")


def _wants_clock(
    problem: Problem, method: Method, timeline: Timeline, t_eval: Any, clock: bool | None
) -> bool:
    if problem.time == "t":
        if clock:
            raise DomainError("clock", clock, f"False: the time of {problem.name!r} is physical")
        return False
    if timeline.physical_end is not None or t_eval is not None:
        if clock is False:
            raise DomainError("clock", clock, "True: t_end and t_eval are physical time")
        return True
    possible = problem.clock is not None and method.needs != "action"
    return possible if clock is None else clock


def _check_counts(watched: Any, save_every: Any, observe_every: Any, measure_steps: Any) -> None:
    """Raise `DomainError` for numbers of steps that are none, or that nothing would follow."""
    for name, count, optional in (
        ("save_every", save_every, True),
        ("observe_every", observe_every, False),
        ("measure_steps", measure_steps, True),
    ):
        if not (count is None and optional):
            whole(name, count, 1)
    if observe_every != 1 and not watched:
        raise DomainError("observe_every", observe_every, "1, or something to observe")
    if measure_steps is not None and MEASURE not in watched:
        raise DomainError("measure_steps", measure_steps, "None, or 'measure' to be observed")


def _tell_short_run(solution: Solution, end: float, step: float) -> None:
    """Warn if the run was shorter than the step that was asked for, which it did not take."""
    if solution.success and end < step * (1.0 - 1e-9):
        warnings.warn(
            f"step = {step:.9g} is longer than the run to {solution.problem.time} = "
            f"{end:.9g}: a step of that length was taken instead",
            GeomintWarning,
            stacklevel=4,
        )


def _displayed(bar: Progress, recorder: Recorder, timeline: Timeline) -> Callable[[int], None]:
    counted = timeline.steps is not None
    return lambda steps: bar.update(steps if counted else abs(recorder.reached))


def _integrate(
    stepper: Stepper,
    timeline: Timeline,
    recorder: Recorder,
    account: Account,
    progress: Callable[[int], None],
) -> Status | StepError:
    """Run to the end; return "success", "interrupted", or the error of the step that failed."""
    try:
        drive(stepper, timeline.steps, recorder.stride, recorder.consume, account, progress)
        recorder.catch_up(account.steps)
        if timeline.remainder != 0.0:
            last, done = timeline.h * account.steps, account.steps
            y = stepper.single_step(stepper.state, last, timeline.remainder, stepper.carry, done)
            recorder.finish(timeline.own_end or 0.0, y)
    except StepError as error:
        recorder.catch_up(account.steps)
        return error
    except KeyboardInterrupt:
        recorder.catch_up(account.steps)
        return "interrupted"
    return "success"
