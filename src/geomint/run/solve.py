"""`solve`: integrate a problem from an initial state."""

import contextlib
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from ..arguments import finite, positive
from ..errors import DomainError, StepError, StepLimitError, WatcherError, keeping
from ..kernels.compiling.beside import in_turn
from ..methods import Exact, Method, find_solver
from ..methods.adaptive import Adaptive
from ..methods.partial import PartialSteps
from ..problems.declaration import check_problem, check_watched
from ..problems.declared import tell_false_claims
from ..problems.problem import Problem
from ..watch.functions import Function
from ..watch.observe import Observers, choose_watchers
from ..watch.watcher import Run, Watcher
from .accuracy.asked import choose_for
from .accuracy.auto import is_auto
from .asked import Asked, check_counts, check_switches, restart_of, wanted_times, wants_clock
from .begun_anew import begun_anew
from .breaks import breaks_of, divided
from .callback import Callback, asked_to_end, check_callback
from .calls import explained, still
from .crossings import Crossings
from .driver import FIRST_CHUNK, drive
from .error_estimate import check_estimate, error_estimate, label
from .events import Event, choose_events, looked_at
from .exact.follow import ExactRun, check_no_steps
from .growth import estimated, met, tell_end_error
from .integrator import Integrator
from .local_error import Ranked, promised, tell_errors
from .progress import Progress
from .promise import AIM, Setting, advice, rough_error
from .recorder import Account, Recorder
from .result import Status
from .solution import Solution
from .step_notes import may_lose, tell_long_steps, tell_lost_integrals, tell_short_run
from .timeline import Timeline, plan_timeline
from .wanted import Wanted

AS_NEW = "begin a new run from the last state, whose step is chosen anew"
MANY = 3e7  # iterations in another time, where those in its own are not known
BRIEF = 4096  # numbers of the first steps, where only compiled code runs: milliseconds


@explained
@keeping
@still
def solve(
    problem: Problem | Solution,
    y0: Any = None,
    *,
    t0: float = 0.0,
    t_end: float | None = None,
    tau_end: float | None = None,
    method: str | Method | None = None,
    step: float | None = None,
    tolerance: float | None = None,
    t_eval: Any = None,
    tau_eval: Any = None,
    dense: bool = False,
    events: Any = None,
    save_every: int | None = None,
    observe: Any = (),
    observe_every: int = 1,
    clock: bool | None = None,
    callback: Callback | None = None,
    estimate_error: bool = False,
    breaks: Any = None,
    longest: float | None = None,
    progress: bool | None = None,
    compiled: bool = True,
) -> Solution:
    """Integrate `problem` from `y0`, or go on where a solution ended.

    Parameters
    ----------
    problem : Problem, or Solution
        A solution goes on from its last whole step, with its method, step and clock: the states are
        bit for bit those of one run with that step. (An adaptive method has made its last step fit
        the end, and goes on from there.) Drifts are those of the new part. Of one that `geomint.load`
        has read with ``trust=True`` this may unpickle problem and method.
    y0 : array_like
        Flat state in the problem's documented order; `Problem.state` makes one.
    t0 : float
        Physical time at y0. A problem in τ begins at τ = 0.
    t_end, tau_end : float
        Exactly one: the end in physical time, met by a last partial step, or (for a problem in τ)
        in the problem's own time. Before the beginning: backwards; at it: no steps, the initial state.
        Functions are asked between beginning and end alone.
    method : str or Method
        Such as ``geomint.Gauss(8)`` or ``"gauss-8"``. Default: by the problem's first form, gauss-8
        for a field, rkmk-dop853 for an action, lobatto-8 for a Hamiltonian, verlet-8 for a splitting.
        With a `tolerance` also
        ``"auto"``, which problem and tolerance choose (`geomint.run.accuracy.auto`); a long uneven
        motion runs in another time then (`geomint.time_transformed`), as ``sol.problem`` tells.
        ``"exact"`` is the exact motion of a problem that has one (`geomint.Problem.exact`): no steps,
        so neither `step` nor `save_every`; states where they are asked for, events on the motion
        itself, quantities watched at the times that are asked for, of which `observe_every` counts.
    step : float, optional
        Step in the problem's own time, > 0. Default: the method's ``step_fraction`` of the
        characteristic time at y0 (`geomint.problems.time_scale.characteristic_time`). If the end is
        a whole number of steps away, to 1e-9, the step is adjusted to meet it; else a last partial
        step is. For an adaptive method the first step, by default one that its tolerances allow;
        all further ones are the method's choice.
    tolerance : float, optional
        In place of `step`: the error that is wanted of the state at the end, relative to the largest
        number of each piece, estimated. The step, or the local tolerances of an adaptive method, and
        where an implicit step's iteration stops are chosen from trials on a stretch of the motion
        (`geomint.run.accuracy`); what was chosen is ``sol.accuracy``.
    t_eval, tau_eval : array_like, optional
        Times in the order of the run and within it, to four roundings, at which states are wanted: by
        partial steps beside the run, which they do not disturb; one of both: physical times, or (for a
        problem in τ) the problem's own. Without `save_every` the states at these times alone are saved,
        just as they are asked for.
    dense : bool
        Keep the state after every step, so that ``sol.sol(t)`` gives that at any time of the run, see
        `geomint.run.dense.DenseOutput`.
    events : str, Event, list or mapping of names to these, optional
        What is looked for: where components of the state (``"gamma[2]"``), quantities by name, or
        functions (`geomint.event`) change their sign, see `geomint.Event`. The points lie on the orbit
        of the method; the steps of the run are not disturbed. They are in ``sol.events``.
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
        problem can. For an exact motion that may take seconds to prepare.
    callback : callable, optional
        ``callback(reached)`` is called every some hundredths of a second with where the run has got
        to, see `geomint.run.callback.Reached`; the run ends there if it returns True.
    estimate_error : bool
        Estimate the error of every saved state, by a second run with half the step (of an adaptive
        method with a sixteenth of the tolerances), which takes twice as long as the first: it is
        ``sol.error_estimate``.
    breaks : array_like, optional
        Times within the run at which a force switches, in any order: physical times, or of a problem
        in τ, whose end is then given in it, those. Steps end there, with every method, and begin anew
        behind; none is evaluated at such a time, but some roundings before or behind it. At fixed step
        each stretch between two of them is divided into equal steps, as long as `step` or less, so that
        structure is kept within it; `save_every` counts on. A composition that goes beyond its steps
        is refused. Without breaks the order of a method is lost at a switch.
    longest : float, optional
        The longest step, > 0, in the problem's own time: no step that is chosen is longer, and none of
        an adaptive method. What lasts that long is then not stepped over.
    progress : bool, optional
        Show progress. Default: if standard error is a terminal, or in a notebook; elsewhere a line
        says, once in a process, that functions are compiled. False: nothing.
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
    ConvergenceError, NonFiniteError, StepSizeError, StepLimitError, ClockError, EventError
        With t, step, residual and iterations; ``partial`` is the solution up to there.
    WatcherError
        Likewise, where what watches a quantity fails, or the callback.
    """
    longest = None if longest is None else positive("longest", longest)
    inside = () if breaks is None else breaks_of(breaks, problem, finite("t0", t0), t_end, tau_end)
    asked = Asked(
        t0, t_end, tau_end, method, step, t_eval, tau_eval, dense, events, save_every, observe,
        observe_every, clock, callback, estimate_error, inside, longest, progress, compiled,
    )  # fmt: skip
    chooses = tolerance is not None or is_auto(method)
    if not chooses and (step is not None or isinstance(problem, Solution)):
        found = _solved(problem, y0, asked)
        former = Setting.of_former(problem) if isinstance(problem, Solution) else None
        if former is not None:
            _leave(found, former)
            if not former.kept(found, confirmed=False) and found.local_error is not None:
                tell_errors(found.local_error, found.about.time, AS_NEW)
        return found
    # A run may begin more than once.
    events, observe = (list(x) if isinstance(x, Iterator) else x for x in (events, observe))
    asked = asked._replace(given=False, events=events, observe=observe)
    chosen = tolerance if isinstance(tolerance, Setting) else None  # a plan has chosen
    if chosen is None and chooses:
        chosen = choose_for(problem, y0, asked, tolerance)
    chosen = chosen or Setting.default(method, problem)
    solution, chosen = _begun(problem, y0, chosen, asked)
    kept, accuracy = chosen.kept(solution), chosen.accuracy
    solution.accuracy, measured = accuracy, estimated(solution)
    if chosen.wanted is not None and not met(solution, chosen.wanted):
        tell_end_error(solution, chosen.wanted, t0 if label(solution)[0] == "t" else 0.0)
    elif accuracy is not None and (solution.end_error is None or measured is not None):
        accuracy.tell(rough_error(solution) if kept else solution.local_error, measured)
    elif not kept and solution.local_error is not None:
        part = AIM * promised(solution.method) / solution.local_error.largest
        tell_errors(solution.local_error, solution.about.time, advice(solution, part))
    if may_lose(solution, False):
        own, ranked = t0 if solution.problem.time == "t" else 0.0, solution.ranked
        begun = ranked.places[0][1] if isinstance(ranked, Ranked) else chosen.state
        begun = solution.problem.canonical(y0) if begun is None else begun
        tell_lost_integrals(solution, begun, own, False, compiled)
    _leave(solution, chosen)
    return solution


def _begun(
    problem: Problem | Solution, y0: Any, chosen: Setting, asked: Asked
) -> tuple[Solution, Setting]:
    """Return a run in the time that was chosen, or in its own where the other does not serve."""
    own, other, wanted = chosen.own, chosen.problem, chosen.wanted
    if own is None or other is None or wanted is None:
        return begun_anew(partial(_solved, problem, y0), chosen, asked)
    found = None
    with contextlib.suppress(StepError):
        known = asked._replace(clock=None, most=min(own.iterations, MANY))
        found, last = begun_anew(partial(_solved, other, y0), chosen, known)
    if found is None or (found.success and not met(found, wanted)):
        return _begun(problem, y0, own, asked)
    return found, last


def _leave(found: Solution, chosen: Setting) -> None:
    """Note what is promised of a run for one that goes on."""
    if found.restart is not None:
        found.restart = replace(found.restart, wanted=chosen.promise)


def _solved(problem: Problem | Solution, y0: Any, asked: Asked) -> Solution:
    """Return what `solve` does with a step, or the default one, once."""
    check_switches(
        compiled=asked.compiled,
        dense=asked.dense,
        estimate_error=asked.estimate_error,
        clock=asked.clock,
        progress=asked.progress,
    )
    method, step, clock, compiled = asked.method, asked.step, asked.clock, asked.compiled
    t_eval, tau_eval, breaks, longest = asked.t_eval, asked.tau_eval, asked.breaks, asked.longest
    observe_every, given = asked.observe_every, asked.given
    t0, before = finite("t0", asked.t0), None
    if isinstance(problem, Solution):
        former, problem = problem, problem.problem
        before = restart_of(former, clock, y0=y0, t0=t0 or None, method=method, step=step)
        y0, method = before.memory[: problem.rows], former.method
        clock = before.clock if problem.time == "tau" else clock
    chosen = find_solver(method, problem)
    exact = isinstance(chosen, Exact)
    if exact:
        chosen.check_fits(problem, False)
        check_no_steps(
            step=step,
            save_every=asked.save_every,
            callback=asked.callback,
            estimate_error=asked.estimate_error or None,
            breaks=breaks or None,
            longest=longest,
        )
    if longest is not None and isinstance(chosen, Adaptive):
        chosen = replace(chosen, max_step=min(chosen.max_step, longest))
    check_estimate(asked.estimate_error, before)
    state = y0 if before is not None else asked.admitted
    state = problem.canonical(y0) if state is None else state
    bar = Progress(asked.progress, None, chosen.name)
    with bar if step is None else contextlib.nullcontext():  # what it follows from is compiled
        for_run = problem, chosen, state, asked.t_end, asked.tau_end
        rest = t0, before, compiled, breaks
        timeline = plan_timeline(*for_run, step, *rest)
        if longest is not None and abs(timeline.h) > longest * (1.0 + 1e-9):
            if given and not (chosen.adaptive and step is None):
                raise DomainError("longest", longest, f"at least the step, {abs(timeline.h):.9g}")
            timeline = plan_timeline(*for_run, longest, *rest)
    wanted_clock = wants_clock(problem, timeline, t_eval, clock)
    with_clock = problem.clock is not None if wanted_clock is None else wanted_clock
    nothing = type(asked.observe) is tuple and not asked.observe
    watched = {} if nothing else choose_watchers(problem, asked.observe)
    if asked.save_every is not None or observe_every != 1:
        check_counts(watched, asked.save_every, observe_every)
    looked_for, callback = choose_events(asked.events), check_callback(asked.callback)
    if exact:
        seen = check_problem(problem, state, problem.forms[0], with_clock)
    else:
        flow = chosen.on(problem, state, timeline.start, with_clock, compiled)
        seen = flow.seen
    if watched or looked_for:
        check_watched(problem, state, _evaluated(problem, watched, looked_for))
    ahead = timeline.own_end
    ahead = math.copysign(math.inf, timeline.h) if ahead is None else ahead - timeline.start
    tell_false_claims(problem, state, timeline.start, ahead, seen)
    if exact:
        motion = ExactRun(problem, state, timeline, t0, before)
        return motion.solved(
            wanted=wanted_times(problem, timeline, motion.physical, motion.own, t_eval, tau_eval),
            by_clock=problem.time == "tau" and t_eval is not None,
            clock=wanted_clock,
            dense=asked.dense,
            events=looked_for,
            watched=watched,
            observe_every=observe_every,
            progress=asked.progress,
            compiled=compiled,
        )
    stepper = flow.begin(state, timeline.start, timeline.h, timeline.own_end)
    stepper.turning = asked.turning
    integrator = Integrator.of(stepper, t0, before)
    least = 1 if given else 2  # in a stretch: a second run has longer steps
    stretches = (
        divided(integrator, timeline, breaks, asked.halved, least) if breaks else (timeline,)
    )
    if len(stretches) > 1:
        integrator._go_on(stretches[0])
        before = before and replace(before, done=0)
        steps = None if chosen.adaptive else sum(stretch.steps or 0 for stretch in stretches)
        timeline = timeline._replace(start=integrator.time, steps=steps, remainder=0.0)
    begin = integrator.t if with_clock or problem.time == "t" else 0.0
    observers, crossings, wanted = None, None, None
    if timeline.physical_end is not None or t_eval is not None or tau_eval is not None:
        wanted = Wanted(
            PartialSteps(stepper),
            wanted_times(problem, timeline, begin, integrator.time, t_eval, tau_eval),
            math.copysign(1.0, timeline.h),
            with_clock and tau_eval is None,
        )
    if watched:
        samples = timeline.expected / observe_every
        start_of = integrator.state, integrator.time, stepper
        observers = Observers(watched, Run(problem, *start_of, samples, chosen))
    if looked_for:
        crossings = Crossings(stepper, looked_for, before)
    recorder = Recorder(
        integrator,
        timeline,
        stretches,
        observers,
        asked.save_every,
        observe_every,
        wanted,
        asked.dense,
        crossings,
    )
    bar.total = recorder.length
    with bar:
        along = [part for part in (observers, crossings) if part is not None]
        bar.expect(flow.entries + sum(part.entries for part in along))
        in_turn(integrator.prepare, *(part.prepare for part in along))
        own = callback is not None or any(type(w) is not Function for w in watched.values())
        slow = own or chosen.adaptive or len(stretches) > 1
        bar.begin(compiled and not slow and FIRST_CHUNK * problem.rows <= BRIEF)
        account = Account()
        second = recorder.second() if asked.confirmed else None
        if second is not None and timeline.own_end is not None:
            second.begin(timeline.own_end)

        def asked_to_end_here() -> bool:
            bar.update(recorder.progress)
            if integrator.iterations > asked.most:
                numbers = integrator.time, integrator.steps, 0.0, integrator.iterations
                raise StepLimitError(*numbers, f"{asked.most:g} iterations")
            return callback is not None and asked_to_end(callback, recorder.told())

        status = _integrate(integrator, timeline, recorder, account, asked_to_end_here)
        if second is not None and status != "success":
            second.give_up()
        if bar.brief and (watched or asked.save_every) and status == "interrupted":
            raise KeyboardInterrupt  # anywhere, perhaps between two windows, or saved states
        solution = recorder.solution(chosen, account, bar.compile_seconds, status)
    if (
        given
        and step is not None
        and timeline.own_end != timeline.start
        and solution.success
        and not recorder.stopped
    ):
        tell_short_run(problem, abs(recorder.own_time - timeline.start), float(step))
    if isinstance(status, StepError):
        status.partial = solution
        raise status
    if solution.success and isinstance(solution.ranked, Ranked):
        reached = solution.ranked.final[: problem.rows]
        tell_false_claims(problem, reached, solution.ranked.end, -ahead, seen, moved=True)
    if given and stepper.flow is not flow:
        tell_long_steps(problem, chosen, state, timeline)
    elif given and step is not None and may_lose(solution, True):
        tell_lost_integrals(solution, state, timeline.start, given, compiled)
    if asked.estimate_error:
        plain = Asked(
            t0, clock=clock, breaks=breaks, longest=longest, progress=asked.progress,
            compiled=compiled, given=given, halved=timeline.h,
        )  # fmt: skip
        begin = t0 if label(solution)[0] == "t" else 0.0
        solution.error_estimate = error_estimate(
            solution, lambda **ends: _solved(problem, y0, plain._replace(**ends)), begin
        )
    return solution


def _evaluated(
    problem: Problem, watched: Mapping[str, Watcher], looked_for: Mapping[str, Event]
) -> dict[str, Any]:
    """Return the functions that are watched, and looked at for events, by argument."""
    said = ((name, w.evaluates(problem)) for name, w in watched.items())
    found: dict[str, Any] = {f"observe[{name!r}]": f for name, f in said if f is not None}
    found.update({f"events[{k!r}]": looked_at(e, problem) for k, e in looked_for.items()})
    return found


def _integrate(
    integrator: Integrator,
    timeline: Timeline,
    recorder: Recorder,
    account: Account,
    between: Callable[[], bool],
) -> Status | StepError:
    """Run to the end; return "success", "interrupted", or the error that ended the run before."""
    status: Status | StepError = "success"
    try:
        if not timeline.steps and timeline.remainder == 0.0:
            recorder.stay()
        while True:
            asked = drive(integrator, recorder, account, between)
            if asked or recorder.stopped or not recorder.go_on():
                break
        recorder.catch_up()
        if asked:
            recorder.stopped = "the callback"
        if timeline.remainder != 0.0 and not recorder.stopped:
            stepper, done = integrator.stepper, integrator.done
            last = timeline.start + timeline.h * done
            y = stepper.step_ahead(last, timeline.remainder, done)
            recorder.finish(timeline.own_end or 0.0, y)
        if recorder.error is not None:
            raise recorder.error
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
