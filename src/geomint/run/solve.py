"""`solve`: integrate a problem from an initial state."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

from ..arguments import switch, whole
from ..errors import DomainError, GeomintWarning, StepError, WatcherError
from ..methods import Method, Start, find_method
from ..problems.declaration import check_problem
from ..problems.problem import Problem
from ..watch.observe import Observers, choose_watchers
from ..watch.watcher import Run
from .calls import explained
from .driver import Account, drive
from .integrator import Integrator
from .progress import Progress
from .recorder import Recorder
from .restart import Restart
from .result import Status
from .solution import Solution
from .timeline import Timeline, evaluation_times, plan_timeline

__all__ = ["solve"]


@explained
def solve(
    problem: Problem | Solution,
    y0: Any = None,
    *,
    t0: float = 0.0,
    t_end: float | None = None,
    tau_end: float | None = None,
    method: str | Method | None = None,
    step: float | None = None,
    t_eval: Any = None,
    save_every: int | None = None,
    observe: Any = (),
    observe_every: int = 1,
    clock: bool | None = None,
    progress: bool | None = None,
    compiled: bool = True,
) -> Solution:
    """Integrate `problem` from `y0`, or go on where a solution ended.

    Parameters
    ----------
    problem : Problem, or Solution
        A solution goes on from its last whole step, with its method, step and clock: the states are
        bit for bit those of one run with that step. (An adaptive method has made its last step fit
        the end, and goes on from there.) Drifts are those of the new part.
    y0 : array_like
        Flat state in the problem's documented order; `Problem.state` makes one.
    t0 : float
        Physical time at y0. A problem in τ begins at τ = 0.
    t_end, tau_end : float
        Exactly one: the end in physical time, met by a last partial step, or (for a problem in τ)
        in the problem's own time. Before the beginning: backwards.
    method : str or Method
        Such as ``geomint.Gauss(8)`` or ``"gauss-8"``, which is the default.
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
    observe : names, or mapping of names to functions, watchers or options
        What to watch, see `geomint.watch.observe.choose_watchers`.
    observe_every : int
        Watch every that many steps, and at the end. Only with something to observe.
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
    WatcherError
        Likewise, where what watches a quantity fails.
    """
    _check_switches(compiled=compiled, clock=clock, progress=progress)
    before: Restart | None = None
    if isinstance(problem, Solution):
        former, problem = problem, problem.problem
        before = _restart_of(former, y0, method, step, clock)
        y0, method = before.memory[: problem.rows], former.method
        clock = before.clock if problem.time == "tau" else clock
    chosen = find_method("gauss-8" if method is None else method)
    state = problem.canonical(y0) if before is None else y0
    timeline = plan_timeline(problem, chosen, state, t_end, tau_end, step, t0, before)
    wants_clock = _wants_clock(problem, chosen, timeline, t_eval, clock)
    chosen.check_fits(problem, wants_clock)
    watched = choose_watchers(problem, observe)
    _check_counts(watched, save_every, observe_every)
    evaluated = {name: f for name, w in watched.items() if (f := w.evaluates(problem)) is not None}
    check_problem(problem, state, chosen.needs, wants_clock, evaluated)
    start = Start(
        problem,
        state,
        timeline.start,
        timeline.h,
        wants_clock,
        compiled=compiled,
        end=timeline.own_end,
    )
    integrator = Integrator.of(chosen, start, t0, before)
    begin = integrator.t if wants_clock or problem.time == "t" else 0.0
    wanted = evaluation_times(t_eval, problem, timeline, begin)
    run = Run(
        problem,
        integrator.state,
        integrator.time,
        integrator.stepper,
        timeline.expected / observe_every,
    )
    observers = Observers(watched, run)
    recorder = Recorder(integrator, timeline, observers, save_every, observe_every, wanted)
    with Progress(progress, recorder.length, chosen.name) as bar:
        integrator.prepare()
        observers.prepare()
        bar.begin()
        account = Account()
        status = _integrate(
            integrator, timeline, recorder, account, lambda: bar.update(recorder.progress)
        )
        solution = recorder.solution(chosen, account, bar.compile_seconds, status)
    if step is not None:
        _tell_short_run(solution, abs(recorder.own_time - timeline.start), float(step))
    if isinstance(status, StepError):
        status.partial = solution
        raise status
    return solution


def _restart_of(solution: Solution, y0: Any, method: Any, step: Any, clock: Any) -> Restart:
    """Return where a solution goes on, or raise `DomainError` for what it has already."""
    given = {"y0": y0, "method": method, "step": step}
    for name, value in given.items():
        if value is not None:
            raise DomainError(name, value, "nothing: a solution goes on as it was")
    if solution.restart is None:
        raise DomainError("problem", solution, "a solution that can go on: this one has no restart")
    if clock is not None and clock != solution.restart.clock and solution.problem.time == "tau":
        raise DomainError("clock", clock, f"{solution.restart.clock}, as before")
    return solution.restart


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
    return problem.clock is not None if clock is None else clock


def _check_counts(watched: Any, save_every: Any, observe_every: Any) -> None:
    """Raise `DomainError` for numbers of steps that are none, or that nothing would follow."""
    for name, count, optional in (
        ("save_every", save_every, True),
        ("observe_every", observe_every, False),
    ):
        if not (count is None and optional):
            whole(name, count, 1)
    if observe_every != 1 and not watched:
        raise DomainError("observe_every", observe_every, "1, or something to observe")


def _tell_short_run(solution: Solution, end: float, step: float) -> None:
    """Warn if the run was shorter than the step that was asked for, which it did not take."""
    if solution.success and end < step * (1.0 - 1e-9):
        warnings.warn(
            f"step = {step:.9g} is longer than the run to {solution.problem.time} = "
            f"{end:.9g}: a step of that length was taken instead",
            GeomintWarning,
            stacklevel=4,
        )


def _integrate(
    integrator: Integrator,
    timeline: Timeline,
    recorder: Recorder,
    account: Account,
    progress: Callable[[], None],
) -> Status | StepError:
    """Run to the end; return "success", "interrupted", or the error that ended the run before."""
    status: Status | StepError = "success"
    try:
        drive(integrator, timeline.steps, recorder.stride, recorder.consume, account, progress)
        recorder.catch_up()
        if timeline.remainder != 0.0:
            stepper, done = integrator.stepper, integrator.done
            last = timeline.start + timeline.h * done
            y = stepper.single_step(stepper.state, last, timeline.remainder, stepper.carry, done)
            recorder.finish(timeline.own_end or 0.0, y)
    except StepError as error:
        recorder.catch_up()
        status = error
    except KeyboardInterrupt:
        recorder.catch_up()
        status = "interrupted"
    try:
        recorder.observe_end()
    except (WatcherError, KeyboardInterrupt) as end:
        if status == "success":
            status = end if isinstance(end, WatcherError) else "interrupted"
    if isinstance(status, WatcherError):
        status.step = integrator.steps
    return status
