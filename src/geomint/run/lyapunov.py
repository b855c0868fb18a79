"""Lyapunov exponents of a run: how fast neighbouring motions part."""

import contextlib
from typing import Any

import numpy as np

from ..arguments import Array, whole
from ..errors import DomainError, StepError, keeping
from ..methods import Method, find_solver
from ..methods.carried import Carried, sizes_of_pieces
from ..problems.evaluate import rates_of
from ..problems.problem import Problem
from ..problems.time_scale import characteristic_time
from .asked import check_switches
from .calls import still
from .carried_directions import columns
from .exponents import BLOCKS, Lyapunov
from .growing import Growing
from .integrator import Integrator
from .progress import Progress
from .solve import solve
from .step_notes import integral_off, tell_lost
from .tangent_flow import started
from .timeline import Timeline
from .watched_steps import WatchedSteps, tell_fastest

APART = 0.1  # of a characteristic time: directions are made orthonormal as often
EARLY = 200  # samples at even intervals of log t
LOOKS, PART = 32, 20  # at how fast the motion is, beside the first of its steps, or that part
PIECE = 1 << 14  # steps between which Ctrl-C is seen, however short they are


@keeping
@still
def lyapunov(
    problem: Problem,
    y0: Any,
    *,
    t_end: Any = None,
    tau_end: Any = None,
    method: str | Method | None = None,
    step: Any = None,
    t0: float = 0.0,
    count: Any = None,
    directions: Any = None,
    progress: bool | None = None,
) -> Lyapunov:
    """Return Lyapunov exponents of a motion: of its numerical map, by exact derivatives.

    Directions tangent to the manifold of states (that of the problem's measure; without one all are)
    are carried along by steps in tangent numbers and made orthonormal on the way. The exponents are
    (1/t) log R_kk of the factor R, in falling order: the largest, and with all directions the whole
    spectrum, whose sum is the mean growth of volumes.

    Parameters
    ----------
    problem, y0, t_end, tau_end, method, step, t0
        As those of `geomint.tangent_flow`: an end in the problem's own time, a method with steps of a
        given length. The default step is what `geomint.solve` keeps on the first eight characteristic
        times, or a twentieth of the run; a warning comes where steps err by more later.
    count : int, optional
        How many exponents, the largest. Default: all.
    directions : array_like, shape (rows, k), optional
        Where the directions begin, one a column; made orthonormal on the manifold in their order, on
        which they must be independent.
        Default: random ones, the same in every run.
    progress : bool, optional
        Show progress. Default: if standard error is a terminal.

    Returns
    -------
    Lyapunov
        After Ctrl-C, of the time until then.

    Raises
    ------
    ArgumentError, DomainError, FormError, DeclarationError, MethodError
        As `geomint.tangent_flow`.
    ConvergenceError, NonFiniteError, StepSizeError
        With t, step, residual and iterations; ``partial`` has what was found by then.

    Notes
    -----
    Benettin, Galgani, Giorgilli, Strelcyn, Meccanica 15 (1980) 9; the alignment index: Ch. Skokos,
    J. Phys. A 34 (2001) 10029.

    Examples
    --------
    >>> import geomint as gi
    >>> scene = gi.load_scene("sphere-n3")
    >>> found = gi.lyapunov(scene.problem, scene.state, t_end=200.0, step=0.1)
    >>> found.exponents.shape  # T*S² has four dimensions
    (4,)
    """
    check_switches(progress=progress)
    known = started(problem, y0, t_end, tau_end, method, step, t0)
    method = find_solver(method, problem)
    tried = 0 if step is not None else WatchedSteps.enough(method, known[1].steps, PART)
    kept = _kept_step(problem, known, method, tried) if tried else None
    if kept is not None:
        known = started(problem, y0, t_end, tau_end, method, kept, t0)
    state, timeline, stepper = known
    chosen = _directions(problem, count, directions)
    try:
        carried = Carried(problem, stepper, state, timeline.start, chosen)
    except DomainError:
        if directions is not None:
            raise
        chosen *= sizes_of_pieces(problem, state)[:, None]  # random ones, in units of the pieces
        carried = Carried(problem, stepper, state, timeline.start, chosen)
    assert timeline.steps is not None
    if timeline.steps == 0 and timeline.remainder == 0.0:
        raise DomainError("t_end", t_end, "an end that is not the beginning: exponents are rates")
    span = abs(timeline.h)
    with contextlib.suppress(DomainError):  # without a finite derivative the first step fails
        rate_at = rates_of(problem, state)
        span = characteristic_time(problem, state, timeline.h, timeline.start, rate_at)
    every = int(np.clip(APART * span / abs(timeline.h), 1, max(min(timeline.steps, PIECE), 1)))
    steps, rest = timeline.steps, timeline.remainder
    growing = Growing(stepper, carried, timeline.start, timeline.h, every)
    places: list[tuple[Array, float]] = []
    unknown = 0 < tried < steps
    with Progress(progress, steps, f"exponents, {stepper.flow.kernel.function.__name__}") as bar:
        growing.prepare()
        bar.begin()
        try:
            for mark in _marks(steps, every):
                while growing.steps < mark:
                    growing.take(min(mark - growing.steps, PIECE // every * every))
                    bar.update(growing.steps)
                growing.sample(abs(timeline.h) * mark)
                if unknown and LOOKS * mark // steps > len(places):
                    y = carried.kept("state")[: problem.rows].copy()
                    places.append((y, timeline.start + timeline.h * mark))
            if rest != 0.0:
                growing.cut(rest)
                growing.sample(abs(timeline.h) * steps + abs(rest))
        except KeyboardInterrupt:
            return growing.found(problem.rows, span, "interrupted")
        except StepError as error:
            error.partial = growing.found(problem.rows, span, "failed")
            raise
    found = growing.found(problem.rows, span, "success")
    end = timeline.start + timeline.h * steps + rest
    off = integral_off(problem, (state, timeline.start), (found.y, end))
    tell_lost(off, end, timeline.h, method)
    if places:
        tell_fastest(_integrator(problem, known, method, -1.0), places)
    return found


def _integrator(
    problem: Problem, known: tuple[Array, Timeline, Any], method: Method, sign: float
) -> Integrator:
    """Return what takes the steps of a run alone, forwards or backwards."""
    state, line, _ = known
    flow = method.on(problem, state, line.start)
    made = Integrator.of(flow.begin(state, line.start, sign * line.h))
    made.prepare()
    return made


def _kept_step(
    problem: Problem, known: tuple[Array, Timeline, Any], method: Method, tried: int
) -> float | None:
    """Return the step that `solve` keeps on the first steps of a run; None for the default one."""
    made = _integrator(problem, known, method, 1.0)
    made.stepper.turning = False
    if not WatchedSteps(made).through(tried):
        return None
    state, line, _ = known
    end = line.own_end if tried == line.steps else line.start + tried * line.h
    given: dict[str, Any] = {"t_end": end, "t0": line.start}
    if problem.time == "tau":
        given = {"tau_end": end, "clock": False}
    try:
        found = solve(problem, state, method=method, progress=False, **given)
    except StepError:  # the run itself will tell
        return None
    return abs(found.step)


def _directions(problem: Problem, count: Any, directions: Any) -> Array:
    """Return where directions begin: given, or random ones."""
    measure = problem.measure
    most = problem.rows - (0 if measure is None else measure.conditions)
    if directions is not None:
        if count is not None:
            raise DomainError("count", count, "nothing beside directions")
        found = columns("directions", directions, problem.rows)
        if found.shape[1] > most:
            raise DomainError("directions", directions, f"at most {most}, which are independent")
        return found
    number = most if count is None else whole("count", count, 1, most)
    return np.random.default_rng(20101).normal(size=(problem.rows, number))


def _marks(steps: int, every: int) -> list[int]:
    """Return after how many steps there are samples: even in log t, and the ends of equal parts."""
    early = np.geomspace(every, max(steps, every), EARLY)
    even = np.linspace(0.0, steps, BLOCKS + 1)[1:]
    marks = np.unique(np.round(np.concatenate([early, even]) / every).astype(np.int64)) * every
    return [*(int(m) for m in marks if 0 < m < steps), *([steps] if steps else [])]
