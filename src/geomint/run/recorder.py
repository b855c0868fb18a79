"""The recorder: gathers saved states and observations while a run goes on."""

import math
from dataclasses import dataclass

import numpy as np

from ..arguments import Array, Integers
from ..errors import StepError
from ..kernels.numbers.blocks import scalar_block
from ..methods.method import Method
from ..methods.partial import Nodes, rounding
from ..watch.drift import not_finite
from ..watch.growth import NOT_FINITE
from ..watch.observe import Observers
from .callback import Reached
from .crossings import Crossings, Stop
from .dense import Kept
from .integrator import Integrator
from .local_error import Ranked
from .pace import Pace
from .result import Status, StepSizes
from .saved import Saved, merged
from .second import Second
from .solution import Solution
from .timeline import Timeline
from .wanted import Wanted, tell_missed

NEVER = 2**40  # steps


@dataclass
class Account:
    """What a run has cost, without what was compiled on the way."""

    seconds: float = 0.0
    watching_seconds: float = 0.0


class Recorder:
    """Gathers saved states and observations from the driver's chunks."""

    def __init__(
        self,
        integrator: Integrator,
        timeline: Timeline,
        stretches: tuple[Timeline, ...],
        observers: Observers | None,
        save_every: int | None,
        observe_every: int,
        wanted: Wanted | None,
        dense: bool,
        crossings: Crossings | None,
    ) -> None:
        problem, stepper = integrator.problem, integrator.stepper
        self._integrator, self._problem, self._stepper = integrator, problem, stepper
        self._ranked = None if integrator.method.adaptive else Ranked(integrator)
        self._timeline, self._stretches, self._at = timeline, stretches, 0
        self._passed = 0  # steps before the stretch that it is in
        self._observers, self._observe_every = observers, observe_every
        self._save_every = None if save_every is None else int(save_every)
        self._clock = len(stepper.state) > problem.rows
        self._wanted, self._crossings = wanted, crossings
        self.stopped = ""  # what has ended the run
        self.error: StepError | None = None  # of one that cannot be told
        self._nodes: list[Saved] | None = [] if dense else None
        self._saved: list[Saved] = []  # every so many steps
        self._before = (integrator.time, stepper.state.copy())
        self._number = integrator.done  # of the step that led there
        self._handed = integrator.done  # steps of what has been taken from the driver
        self._first_step, self._begin = self._number, self.reached
        self._pace = (
            None if timeline.physical_end is None else Pace(timeline.physical_end, timeline.h)
        )
        if save_every is not None:
            self._saved.append(self._reached())
        if self._nodes is not None:
            self._nodes.append(self._reached())
        self.stride = self._stride()
        # What the driver must hand out.
        self.whole = crossings is not None and crossings.use_memories

    def _stride(self) -> int:
        """How often the driver must hand out a state."""
        every = self._wanted or self._nodes is not None or self._crossings is not None
        if (
            every
            or self._timeline.physical_end is not None
            or (self._observers is not None and self._observers.needs_all_states)
        ):
            return 1
        if len(self._stretches) > 1:  # in which steps are counted anew
            return 1
        intervals = [self._save_every] if self._save_every else []
        if self._observers is not None:
            intervals.append(self._observe_every)
        return int(np.gcd.reduce(intervals)) if intervals else NEVER

    @property
    def physical_time(self) -> float:
        """Physical time of the last state handed out, where it is integrated."""
        return float(self._before[1][-1]) if self._clock else self._before[0]

    @property
    def own_time(self) -> float:
        """The problem's own time of the last state handed out."""
        return self._before[0]

    @property
    def length(self) -> float | None:
        """How long the run is, in steps where these are counted; see `progress`."""
        if self._timeline.steps is not None:
            return self._timeline.steps - self._first_step
        end = self._timeline.own_end
        end = self._timeline.physical_end if end is None else end
        return None if end is None else abs(end - self._begin)

    @property
    def progress(self) -> float:
        """How much of `length` is done."""
        if self._timeline.steps is not None:
            return self._done - self._first_step
        return abs(self.reached - self._begin)

    @property
    def _done(self) -> int:
        """Steps that the integrator has taken."""
        return self._passed + self._integrator.done

    @property
    def stretch(self) -> Timeline:
        """The one that the run is in."""
        return self._stretches[self._at]

    def go_on(self) -> bool:
        """Let the run begin anew behind a break; False where there is none to come."""
        if self.stretch is self._stretches[-1]:
            return False
        integrator, done, self._at = self._integrator, self._done, self._at + 1
        if self._ranked is not None:
            self._ranked.go_on()
        integrator._go_on(self.stretch)
        self._passed = done - integrator.done
        if self._save_every and self._number % self._save_every == 0:
            self._saved[-1].times[-1] = math.nextafter(integrator.time, -math.inf * integrator.h)
        self._before = (integrator.time, self._stepper.state.copy())
        if self._nodes is not None:
            self._nodes.append(self._reached())
        if self._crossings is not None:
            self._crossings.go_on()
        return True

    def left(self) -> float:
        """About how many steps are still to come, at the pace so far; of no meaning where it is 0."""
        steps, gone = self._number - self._first_step, self.progress
        pace = gone / steps if steps else abs(self._timeline.h)
        return ((self.length or 0.0) - gone) / pace if pace > 0.0 else -1.0

    @property
    def reached(self) -> float:
        """How far the run is, in the time that its end is given in."""
        return self._before[0] if self._timeline.physical_end is None else self.physical_time

    def told(self) -> Reached:
        """Return where the run has got to, as a callback is told."""
        ahead, state, rows = self._integrator, self._stepper.state.copy(), self._problem.rows
        physical = float(state[-1]) if self._clock else None
        t = ahead.time if self._problem.time == "t" else physical
        return Reached(ahead.time, t, state[:rows], self._done - self._first_step)

    def consume(self, indices: Integers, states: Array, memories: Array | None) -> int | None:
        """Take a chunk; return the number of the last step, in its stretch, if the run ends there."""
        times, states = self._stepper.timed(indices, states)
        times, indices = self.stretch.met(times, indices), indices + self._passed
        end = self._timeline.physical_end
        last = None
        if end is not None and len(states):
            sign = np.sign(self._timeline.h)
            past = np.flatnonzero(sign * states[:, -1] >= sign * end)
            if len(past):
                last = int(indices[past[0]]) - 1
                cut = slice(0, past[0])
                indices, times, states = indices[cut], times[cut], states[cut]
        stop = None
        if self._crossings is not None:
            nodes = self._nodes_to(indices, times, states)
            stop = self._crossings.take(nodes, memories)
        if stop is not None:
            last = int(nodes.steps[stop.node]) - self._passed
            cut = slice(0, stop.node)
            indices, times, states = indices[cut], times[cut], states[cut]
        self._evaluate(indices, times, states)
        if self._save_every:
            which = indices % self._save_every == 0
            self._saved.append(Saved(times[which], states[which]))
        if len(states):
            self._before = (float(times[-1]), states[-1].copy())
            self._number = int(indices[-1])
        if self._observers is not None:
            watched = indices % self._observe_every == 0
            labels = states[:, -1] if self._clock and end is not None else times
            self._observers.add(times, labels, states, watched, self._stepper.length)
        if stop is not None:
            self._stop(stop)
            return last
        if last is not None and end is not None:
            self._finish_physical(end)
            return last
        if self._pace is not None:
            self._pace.reaches(self._number, self._before[0], self.physical_time)
        return None

    def pass_by(self) -> None:
        """Know that all has been taken that was handed out up to where the integrator is."""
        self._handed = self._done

    def catch_up(self) -> None:
        """Take the state that the integrator has reached if it lies beyond the last handed out.

        Not if it was interrupted before that was taken: then it goes back to where it was.
        """
        ahead, handed = self._integrator, self._handed
        if self._done > max(self._number, handed):
            ahead.bookmark = self._stepper.before
            ahead.take(max(self._number - handed, 0), NEVER, scalar_block(self._stepper.rows))
        if self.stopped or self._timeline.physical_end is not None:
            return  # every state has been handed out
        done = self._done
        if done != self._number:
            time = float(self.stretch.met(np.array([ahead.time]), np.array([ahead.done]))[0])
            self._before, self._number = (time, self._stepper.state.copy()), done

    def second(self) -> Second | None:
        """Return a second run, kept with the ranks of steps; None of variable steps."""
        if self._ranked is None:
            return None
        second = self._ranked.second = Second(self._integrator, self._stretches)
        return second

    def finish(self, time: float, state: Array) -> None:
        """Take the state of a last partial step."""
        if not self._stopped_before(time, state):
            self._take_last(time, time, state)

    def stay(self) -> None:
        """Take the state of a run without steps."""
        if self._wanted:
            self._wanted.take(self._last_node())

    def observe_end(self) -> None:
        """Sample the last state that was reached, if that has not been done on the way."""
        if self._observers is not None:
            self._observers.add_end(self._before[0], self.reached, self._before[1])

    def _stop(self, stop: Stop) -> None:
        """End the run at an event, or at the step before one that cannot be told."""
        self.stopped, self.error = f"the event {stop.name!r}", stop.error
        if stop.state is not None:
            by_clock = self._timeline.physical_end is not None
            self._take_last(stop.time, float(stop.state[-1]) if by_clock else stop.time, stop.state)

    def _finish_physical(self, end: float) -> None:
        assert self._wanted is not None
        found = self._wanted.at(self._last_node(), np.array([end]), True)
        if found.error is not None:
            raise found.error
        time, state = float(found.times[0]), found.states[0]
        if not self._stopped_before(time, state):
            self._take_last(time, end, state)

    def _stopped_before(self, time: float, state: Array) -> bool:
        """Look for events in a last partial step, and end the run at one that is to.

        Not in one of a length in the last bits of the time, within which functions of it are noise: a
        run that goes on looks there.
        """
        if self._crossings is None or abs(time - self._before[0]) <= rounding(time):
            return False
        number = np.array([self._number])
        stop = self._crossings.take(self._nodes_to(number, np.array([time]), state[None, :]))
        if stop is not None:
            self._stop(stop)
        return stop is not None

    def _take_last(self, time: float, label: float, state: Array) -> None:
        """Take the state of a last partial step, which no more wanted times lie beyond."""
        times, states = np.array([time]), state[None, :]
        self._evaluate(np.array([self._number]), times, states)
        # An event at a step has been sampled.
        if self._observers is not None and time != self._before[0]:
            self._observers.add(times, np.array([label]), states, np.array([True]))
        self._before = (time, state.copy())

    def _reached(self) -> Saved:
        return Saved(np.array([self._before[0]]), self._before[1][None, :])

    def _last_node(self) -> Nodes:
        time, state = self._before
        return Nodes(np.array([time]), state[None, :], np.array([self._number]))

    def _evaluate(self, indices: Integers, times: Array, states: Array) -> None:
        """Save states at the wanted times up to the end of this chunk."""
        if self._nodes is not None:
            self._nodes.append(Saved(times.copy(), states.copy()))
        if self._wanted and self._wanted.missed and len(times):
            self._wanted.take(self._nodes_to(indices, times, states))

    def _nodes_to(self, indices: Integers, times: Array, states: Array) -> Nodes:
        """Return the last node and those of a chunk."""
        return self._last_node().with_more(Nodes(times, states, indices))

    def solution(
        self, method: Method, account: Account, compile_seconds: float, status: Status | StepError
    ) -> Solution:
        """Return what has been gathered."""
        rows = self._problem.rows
        wanted = self._wanted
        if wanted and wanted.missed and status == "success" and not self.stopped:
            tell_missed(wanted.missed, wanted.last, self.physical_time)
        steps, iterations = self._integrator.steps, self._integrator.iterations
        span = self._integrator.time - self._timeline.start
        sizes = StepSizes(*self._stepper.lengths(steps, span))
        if self._at and self._stepper.length:
            lengths = [abs(stretch.h) for stretch in self._stretches[: self._at + 1]]
            sizes = StepSizes(min(lengths), abs(span) / steps, max(lengths))
        saved = self._kept()
        tau, full = saved
        physical = full[:, -1] if self._clock else tau if self._problem.time == "t" else None
        drift = {} if self._observers is None else self._observers.drifts(steps)
        message = f"ended by {self.stopped}" if self.stopped else ""
        message = message if isinstance(status, str) else str(status)
        if status == "success" and (bad := not_finite(drift)):
            status, message = NOT_FINITE, bad
        restart, met = self._integrator.restart, {}
        if self._ranked is not None:
            self._ranked.end, self._ranked.final = self._before
        if self._crossings is not None:
            restart = self._crossings.left_behind(restart, self._before[0], self._integrator.time)
            met = self._crossings.met(self._clock, self._before[0])
        return Solution(
            about=self._problem,
            by=method,
            step=math.copysign(sizes.mean, self._timeline.h),
            step_sizes=sizes,
            tau=tau,
            y=full[:, :rows],
            drift=drift,
            steps=steps,
            iterations=iterations,
            newton=self._stepper.flow.newton,
            evaluations=self._stepper.evaluations_in(steps, iterations),
            rejected=self._stepper.rejected_in(steps, iterations),
            run_seconds=account.seconds,
            watching_seconds=account.watching_seconds,
            compile_seconds=compile_seconds,
            status=status if isinstance(status, str) else "failed",
            message=message,
            drift_time="t" if self._timeline.physical_end is not None else self._problem.time,
            physical=physical,
            restart=restart,
            events=met,
            kept=self._kept_nodes(),
            ranked=self._ranked,
        )

    def _kept_nodes(self) -> Kept | None:
        if self._nodes is None:
            return None
        nodes = Saved.joined(self._nodes, len(self._stepper.state))
        return Kept(nodes.times, nodes.states, self._timeline.h, self._stepper.compiled)

    def _kept(self) -> Saved:
        """Return the saved states: those at wanted times, as they were asked for; or with the last."""
        if not self._wanted and not self._saved:
            return self._reached()
        rows = len(self._stepper.state)
        asked = self._wanted.found(rows) if self._wanted else Saved.joined([], rows)
        if self._wanted and not self._save_every:
            return asked
        steps, last = Saved.joined(self._saved, rows), self._before
        if not len(steps.times) or steps.times[-1] != last[0]:
            steps = Saved.joined([steps, self._reached()], rows)
        steps.states[-1] = last[1]  # of an event at a step
        by_clock = self._wanted is not None and self._wanted.clock
        return merged(steps, asked, float(np.sign(self._timeline.h)), by_clock)
