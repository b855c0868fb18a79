"""`geomint.solve` without steps: states of the exact motion, and events on it."""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np

from ...arguments import Array
from ...errors import DomainError, StepError, WatcherError
from ...methods.exact import Exact
from ...methods.stepper import Stepper
from ...problems.problem import Problem
from ...watch.drift import not_finite
from ...watch.growth import NOT_FINITE
from ...watch.observe import Observers
from ...watch.watcher import Run, Watcher
from ..dense import Kept
from ..events import Event
from ..progress import Progress
from ..restart import Restart
from ..result import Status, StepSizes
from ..saved import Saved
from ..solution import Solution
from ..timeline import Timeline
from ..wanted import tell_missed
from .crossings import ExactCrossings
from .path import ExactPath, Following

ROUTE = "exact flow"
NONE = "the exact flow takes no steps"


def check_no_steps(**given: Any) -> None:
    """Raise `DomainError` for what is said of steps, where there are none."""
    instead = {"save_every": ", and the times as t_eval"}
    for name, asked in given.items():
        if asked is not None:
            raise DomainError(name, asked, f"None{instead.get(name, '')}: {NONE}")


@dataclass
class ExactRun:
    """One run along the exact motion.

    Parameters
    ----------
    problem : Problem
    state : array
        Where the motion was begun, which is not where a run begins that goes on.
    timeline : Timeline
        Of which the ends count, and the direction.
    t0 : float
        Physical time at the state.
    before : Restart or None
        Where it goes on.
    """

    problem: Problem
    state: Array
    timeline: Timeline
    t0: float
    before: Restart | None
    path: ExactPath = field(init=False)

    def __post_init__(self) -> None:
        rows = self.problem.rows
        self._sign = math.copysign(1.0, self.timeline.h)
        own = self.timeline.start
        physical = self.t0
        self.own = self.physical = own  # where this run begins
        if self.before is not None:
            self.physical, physical, self.own = map(float, self.before.memory[rows:])
        elif self.problem.time == "tau":
            self.physical = physical
        self._origin = own, physical
        self._began = time.perf_counter()
        self.path = ExactPath(self.problem, self.state, own, physical)

    def solved(
        self,
        *,
        wanted: Array,
        by_clock: bool,
        clock: bool | None,
        dense: bool,
        events: Mapping[str, Event],
        watched: Mapping[str, Watcher],
        observe_every: int,
        progress: bool | None,
        compiled: bool,
    ) -> Solution:
        """Return the solution.

        Parameters
        ----------
        wanted : array
            Times at which states are wanted; none for that at the end alone.
        by_clock : bool
            Whether they are times of the clock.
        clock : bool or None
            Whether physical time is told; None: if the motion can tell it.
        """
        clock = self.path.has_clock if clock is None else clock
        end = self._own_end
        last = self._end(end, clock)  # what is refused is so before the search
        seen = None if self.before is None else self.before.seen
        crossings = ExactCrossings(
            self.path, events, self.own, self._sign,
            clock=clock, again=seen is not None, compiled=compiled,
        )  # fmt: skip
        with Progress(progress, abs(end - self.own), Exact().name) as bar:
            crossings.prepare()
            observers = self._observers(watched, clock, len(wanted), observe_every, compiled)
            bar.begin()
            status: Status | StepError = "success"
            try:
                for so_far in crossings.follow(end):
                    bar.update(abs(so_far - self.own))
            except KeyboardInterrupt:
                status = "interrupted"
            status = crossings.error or status
        reached = last
        if crossings.reached != end:
            reached = self._rows(np.array([crossings.reached]), clock)
        states = self._wanted(wanted, reached, by_clock, clock, crossings.stopped, status)
        searched = time.perf_counter()
        try:
            self._observe(observers, states, reached, observe_every)
        except (WatcherError, KeyboardInterrupt) as error:
            if status == "success":
                status = error if isinstance(error, WatcherError) else "interrupted"
        watching = time.perf_counter() - searched
        drift = observers.drifts(1) if watched else {}
        message = f"ended by the event {crossings.stopped!r}" if crossings.stopped else ""
        message = message if isinstance(status, str) else str(status)
        if status == "success" and (bad := not_finite(drift)):
            status, message = NOT_FINITE, bad
        physical = states.states[:, -1].copy() if clock else None
        physical = states.times.copy() if self.problem.time == "t" else physical
        solution = Solution(
            about=self.problem,
            by=Exact(),
            step=0.0,
            step_sizes=StepSizes(0.0, 0.0, 0.0),
            tau=states.times,
            y=states.states[:, : self.problem.rows].copy(),
            drift=drift,
            steps=0,
            iterations=0,
            evaluations=0,
            rejected=0,
            run_seconds=searched - self._began - bar.compile_seconds,
            watching_seconds=watching,
            compile_seconds=bar.compile_seconds,
            status=status if isinstance(status, str) else "failed",
            message=message,
            drift_time="t" if self.timeline.physical_end is not None else self.problem.time,
            physical=physical,
            restart=self._restart(reached, clock, bool(events)),
            kept=self._kept(reached, clock, compiled) if dense else None,
            events=crossings.met,
            route=ROUTE,
        )
        if isinstance(status, StepError):
            status.partial = solution
            raise status
        return solution

    @property
    def _own_end(self) -> float:
        """Return the end in the problem's own time."""
        if self.timeline.own_end is not None:
            return self.timeline.own_end
        assert self.timeline.physical_end is not None
        return float(self.path.own(np.array([self.timeline.physical_end]))[0])

    def _end(self, own: float, clock: bool) -> Saved:
        """Return the state at the end, in the time in which that is given."""
        t = self.timeline.physical_end
        return self._rows(np.array([own]), clock) if t is None else self._timed(np.array([t]))

    def _timed(self, t: Array) -> Saved:
        """Return states at physical times, of a problem in τ."""
        return Saved(self.path.own(t), np.column_stack((self.path.at_physical(t), t)))

    def _rows(self, own: Array, clock: bool) -> Saved:
        """Return states at the problem's own times, with the row of the clock."""
        states = self.path.states(own)
        if clock:
            states = np.column_stack((states, self.path.physical(own)))
        return Saved(own, states)

    def _wanted(
        self, wanted: Array, reached: Saved, by_clock: bool, clock: bool, stopped: str, status: Any
    ) -> Saved:
        """Return the states at wanted times up to what is reached; that there, if none is wanted."""
        if not len(wanted):
            return reached
        last = reached.states[0, -1] if by_clock else reached.times[0]
        known = wanted[self._sign * wanted <= self._sign * last]
        missed = len(wanted) - len(known)
        if missed and status == "success" and not stopped:
            t = reached.states[0, -1] if clock else reached.times[0]
            tell_missed(missed, wanted[-1], t)
        return self._timed(known) if by_clock else self._rows(known, clock)

    def _observers(
        self, watched: Mapping[str, Watcher], clock: bool, count: int, every: int, compiled: bool
    ) -> Observers:
        for name, watcher in watched.items():
            if watcher.sees_all:
                expected = f"quantities of single states: {NONE} that {name!r} could watch"
                raise DomainError("observe", name, expected)
        begin = self._rows(np.array([self.own]), clock).states[0]
        state = begin[: self.problem.rows]
        # It has what watchers of single states use of a stepper.
        following = cast(Stepper, Following(self.problem, begin, compiled))
        observers = Observers(watched, Run(self.problem, state, self.own, following, count / every))
        observers.prepare()
        return observers

    def _observe(self, observers: Observers, states: Saved, reached: Saved, every: int) -> None:
        """Show watchers the states that are wanted, and the last one."""

        def labels(saved: Saved) -> Array:
            own = self.timeline.physical_end is None
            return saved.times if own else saved.states[:, -1]

        which = np.arange(1, len(states.times) + 1) % every == 0
        observers.add(states.times, labels(states), states.states, which)
        observers.add_end(float(reached.times[0]), float(labels(reached)[0]), reached.states[0])

    def _restart(self, reached: Saved, clock: bool, looked: bool) -> Restart:
        """Return what it goes on from: the state where it was begun, and the times here and there."""
        own = float(reached.times[0])
        physical = float(reached.states[0, -1]) if clock else own
        memory = np.concatenate([self.state, [physical, self._origin[1], own]])
        span = own - self._origin[0]
        return Restart(memory, self._origin[0], span, 1, clock, own if looked else None)

    def _kept(self, reached: Saved, clock: bool, compiled: bool) -> Kept:
        """Return what dense output is made of: where the motion was begun, and where the run was."""
        begin = self._rows(np.array([self.own]), clock).states[0]
        origin = np.append(self.state, self._origin[1]) if clock else self.state
        if clock:
            begin[-1] = self.physical
        states = np.vstack([origin, begin, reached.states[0]])
        times = np.array([self._origin[0], self.own, float(reached.times[0])])
        return Kept(times, states, self._sign, compiled)
