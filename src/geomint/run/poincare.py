"""Poincaré sections: motions are followed until each has crossed a surface so many times."""

import math
from typing import Any

import numpy as np

from ..arguments import Array, finite, positive, switch, whole
from ..errors import DomainError, StepError, keeping
from ..methods import Exact, Method, find_solver
from ..problems.evaluate import rates_of
from ..problems.problem import Problem
from .asked import check_switches
from .calls import still
from .events import Event, choose_events
from .exact.trail import ExactTrail
from .local_error import Ranked, tell_errors
from .met import Met
from .progress import Progress
from .promise import Setting
from .section import Section, SectionStatus
from .solution import Solution
from .solve import solve
from .watched_steps import MORE

FIRST_PIECE, PIECE = 1 << 12, 1 << 17  # steps between which points are counted
PATIENCE = 10**6  # steps without a point after which no more are expected


@keeping
@still
def poincare_section(
    problem: Problem,
    states: Any,
    event: Any,
    points: int = 1000,
    *,
    method: str | Method | None = None,
    step: float | None = None,
    end: float = math.inf,
    clock: bool = False,
    progress: bool | None = None,
) -> Section:
    """Follow motions until each has crossed a surface so many times, and return the points.

    Parameters
    ----------
    states : array_like, or several of them
        Where the motions begin.
    event : str or Event
        The surface: a component of the state, a quantity, or a function; see `geomint.Event`.
    points : int
        How many of each motion.
    method, step
        As those of `geomint.solve`; of ``"exact"`` the points are those of the motion itself. Without
        a step that which `geomint.solve` keeps on the first steps of a motion; a warning comes where
        it errs by more later.
    end : float
        In the problem's own time: where a motion ends at the latest.
    clock : bool
        Whether physical time is integrated beside a problem in τ.
    progress : bool, optional
        Show progress, in points. Default: if standard error is a terminal.

    Returns
    -------
    Section
        After Ctrl-C, and of a motion that crosses no more (not within 10⁶ steps, or 10⁵ quarters of
        a period of the exact flow), what was found.

    Raises
    ------
    ArgumentError, DomainError, FormError, MethodError, DeclarationError, StepError
        As `geomint.solve`; the last with the section as far as it goes as its `partial`.
    """
    if not isinstance(problem, Problem):
        raise DomainError("problem", problem, "a geomint.Problem")
    chosen = find_solver(method, problem)
    kind = ExactTrail if isinstance(chosen, Exact) else _Motion
    ((name, surface),) = _only(event).items()
    if surface.what in problem.invariants or surface.what in problem.constraints:
        raise DomainError("event", surface.what, "what changes along motions: this is conserved")
    count, starts = whole("points", points, 1), _states(problem, states)
    end = end if isinstance(end, float) and math.isinf(end) else finite("end", end)
    options = {"method": chosen, "step": None if step is None else positive("step", step)}
    if switch("clock", clock) and problem.time == "t":
        raise DomainError("clock", clock, f"False: the time of {problem.name!r} is physical")
    if problem.time == "tau":
        options["clock"] = bool(clock)
    check_switches(progress=progress)
    parts: list[Met] = []
    motions: list[int] = []
    steps, span = 0, 0.0
    status: SectionStatus = "success"
    failed: StepError | None = None
    with Progress(progress, float(count * len(starts)), "points") as bar:
        bar.begin()
        for i, y0 in enumerate(starts):
            motion = kind(problem, name, surface, count, options, end)
            try:
                while motion.goes_on(y0):
                    bar.update(float(sum(map(len, parts)) + motion.points))
            except KeyboardInterrupt:
                status = "interrupted"
            except StepError as error:
                status, failed = "failed", error
                failed.add_note(
                    f"in motion {i} of 0 to {len(starts) - 1}: `partial` has all points so far"
                )
            parts += motion.parts
            motions += [i] * motion.points
            steps, span = steps + motion.steps, span + motion.span
            if status in ("interrupted", "failed"):
                break
            status = status if motion.points == count else "incomplete"
    rows = np.zeros((0, problem.rows))
    has_clock = any(met.t is not None for met in parts)
    found = Section(
        problem=problem,
        method=chosen,
        event=surface,
        name=name,
        tau=np.concatenate([np.zeros(0), *(met.tau for met in parts)]),
        t=np.concatenate([met.t for met in parts if met.t is not None]) if has_clock else None,
        y=np.concatenate([rows, *(met.y for met in parts)]),
        directions=np.concatenate([np.zeros(0), *(met.directions for met in parts)]),
        motions=np.array(motions, dtype=np.int64),
        status=status,
        step=span / steps if steps else 0.0,
        steps=steps,
    )
    if failed is not None:
        failed.partial = found
        raise failed
    return found


class _Motion:
    """One motion, followed piece by piece until it has its points."""

    def __init__(
        self, problem: Problem, name: str, event: Event, count: int, options: Any, end: float
    ) -> None:
        self._problem, self._name, self._event = problem, name, event
        self._count, self._options, self._end = count, options, end
        self._run: Solution | None = None
        self._idle, self._known = 0, 0.0  # the largest rank of a step for which errors are known
        self.parts: list[Met] = []
        self.points = self.steps = 0
        self.span = 0.0  # in the problem's own time

    @property
    def _piece(self) -> int:
        """How many steps come next: about as many as are still needed, as far as that is known."""
        if not self.points:
            return FIRST_PIECE
        needed = 1.1 * (self._count - self.points) * self.steps / self.points
        return min(math.ceil(needed) + 1, PIECE)

    def goes_on(self, y0: Array) -> bool:
        """Follow it for another piece; tell whether there is more to come."""
        left = self._count - self.points
        event = Event(self._event.what, self._event.direction, left, self._event.level)
        key = "tau_end" if self._problem.time == "tau" else "t_end"
        given: dict[str, Any] = {"events": {self._name: event}, "progress": False}
        if self._run is None:
            rate_at = rates_of(self._problem, y0)
            h = self._options["step"] or self._options["method"].default_step(
                self._problem, y0, self._end, rate_at=rate_at
            )
            self._step = math.copysign(h, self._end)
            until = self._until(0.0)
            run = solve(self._problem, y0, **{**given, **self._options, key: until})
            self._step = math.copysign(run.step if run.steps else self._step, self._end)
        else:
            until = self._until(float(self._run.tau[-1]))
            run = solve(self._run, **{**given, key: until})
        if self._options["step"] is None and isinstance(run.ranked, Ranked):
            self._look(run, run.ranked)
        self._run = run
        met = run.events[self._name]
        self.parts.append(met)
        self.points += len(met)
        self.steps += run.steps
        self.span += run.steps * run.step
        self._idle = 0 if len(met) else self._idle + run.steps
        if run.status == "interrupted":
            raise KeyboardInterrupt
        over = abs(until) >= abs(self._end) or self._idle >= PATIENCE
        return self.points < self._count and not over

    def _look(self, run: Solution, ranked: Ranked) -> None:
        """Warn, once, where steps of a later piece are the worst so far and err by too much."""
        number = ranked.number("largest")
        if number > self._known:
            self._known = MORE * number
            if not Setting.default(run.method, run.problem).kept(run):
                if self._run is not None:  # else `solve` has told
                    tell_errors(ranked.error, self._problem.time)
                self._known = math.inf

    def _until(self, here: float) -> float:
        until = here + self._piece * self._step
        return until if abs(until) < abs(self._end) else self._end


def _only(event: Any) -> dict[str, Event]:
    """Return the one event that is meant, by its name."""
    chosen = choose_events(event)
    if len(chosen) != 1:
        raise DomainError("event", event, "one event")
    if any(e.terminal for e in chosen.values()):
        raise DomainError("event", event, "an event that is not terminal: say how many points")
    return chosen


def _states(problem: Problem, states: Any) -> list[Array]:
    """Return the states that motions begin at: one that is flat, or several."""
    try:
        several = len(states) > 0 and np.ndim(states[0]) > 0
    except Exception:  # whatever a foreign object raises there
        several = False
    return [problem.canonical(y) for y in (states if several else [states])]
