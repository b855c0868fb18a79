"""The recorder: gathers saved states and observations while a run goes on."""

from __future__ import annotations

import warnings

import numpy as np
import numpy.typing as npt

from ..arguments import Array
from ..errors import GeomintWarning, StepError
from ..kernels.compiling.bound import bind
from ..kernels.compiling.call import Call
from ..kernels.compiling.signatures import VALUE
from ..kernels.numbers.blocks import Block, scalar_block
from ..methods.method import Method
from ..watch.drift import NOT_FINITE, not_finite
from ..watch.observe import Observers
from .driver import Account
from .integrator import Integrator
from .pace import Pace
from .result import Status, StepSizes
from .saved import State, merged, rounding
from .solution import Solution
from .timeline import Timeline

__all__ = ["Recorder"]

MAX_CLOCK_ITERATIONS = 50
NEVER = 2**40  # steps


class Recorder:
    """Gathers saved states and observations from the driver's chunks."""

    def __init__(
        self,
        integrator: Integrator,
        timeline: Timeline,
        observers: Observers,
        save_every: int | None,
        observe_every: int,
        wanted: Array,
    ) -> None:
        problem, stepper = integrator.problem, integrator.stepper
        self._integrator, self._problem, self._stepper = integrator, problem, stepper
        self._timeline = timeline
        self._observers, self._observe_every = observers, observe_every
        self._save_every = None if save_every is None else int(save_every)
        self._clock = len(stepper.state) > problem.rows
        self._wanted = wanted
        self._next_wanted = 0
        self._saved: list[State] = []  # every so many steps
        self._asked: list[State] = []  # at the times wanted
        self._before = (integrator.time, stepper.state.copy())
        self._number = integrator.done  # of the step that led there
        self._rate: Call | None = None
        self._first_step, self._begin = self._number, self.reached
        self._pace = (
            None if timeline.physical_end is None else Pace(timeline.physical_end, timeline.h)
        )
        if save_every is not None:
            self._saved.append(self._before)
        self.stride = self._stride()

    def _stride(self) -> int:
        """How often the driver must hand out a state."""
        physical = self._timeline.physical_end is not None
        if len(self._wanted) or physical or self._observers.needs_all_states:
            return 1
        intervals = [self._save_every] if self._save_every else []
        if self._observers.samples:
            intervals.append(self._observe_every)
        return int(np.gcd.reduce(intervals)) if intervals else max(self._timeline.steps or NEVER, 1)

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
            return self._integrator.done - self._first_step
        return abs(self.reached - self._begin)

    @property
    def reached(self) -> float:
        """How far the run is, in the time that its end is given in."""
        return self._before[0] if self._timeline.physical_end is None else self.physical_time

    def consume(self, indices: npt.NDArray[np.int64], states: Array) -> int | None:
        """Take a chunk; return the number of the last step if the physical end has been reached."""
        times, states = self._stepper.timed(indices, states)
        times = self._timeline.met(times, indices)
        end = self._timeline.physical_end
        last = None
        if end is not None and len(states):
            sign = np.sign(self._timeline.h)
            past = np.flatnonzero(sign * states[:, -1] >= sign * end)
            if len(past):
                last = int(indices[past[0]]) - 1
                cut = slice(0, past[0])
                indices, times, states = indices[cut], times[cut], states[cut]
        self._evaluate(indices, times, states)
        # The last step that is cut to meet the end counts as a partial one.
        watched = (indices % self._observe_every == 0) | (times == self._timeline.own_end)
        labels = states[:, -1] if self._clock and end is not None else times
        self._observers.add(times, labels, states, watched, self._stepper.length)
        if self._save_every:
            for i in np.flatnonzero(indices % self._save_every == 0):
                self._saved.append((float(times[i]), states[i].copy()))
        if len(states):
            self._before = (float(times[-1]), states[-1].copy())
            self._number = int(indices[-1])
        if last is not None and end is not None:
            self._finish_physical(end)
        elif self._pace is not None:
            self._pace.reaches(self._number, self._before[0], self.physical_time)
        return last

    def catch_up(self) -> None:
        """Take the state that the integrator has reached if it lies beyond the last handed out."""
        if self._timeline.physical_end is not None:  # every state has been handed out
            return
        done = self._integrator.done
        time = float(self._timeline.met(np.array([self._integrator.time]), np.array([done]))[0])
        if time != self._before[0]:
            self._before, self._number = (time, self._stepper.state.copy()), done

    def finish(self, time: float, state: Array) -> None:
        """Take the state of a last partial step."""
        self._evaluate(np.array([self._number]), np.array([time]), state[None, :])
        self._observers.add(np.array([time]), np.array([time]), state[None, :], np.array([True]))
        self._before = (time, state.copy())

    def observe_end(self) -> None:
        """Sample the last state that was reached, if that has not been done on the way."""
        self._observers.add_end(self._before[0], self.reached, self._before[1])

    def _finish_physical(self, end: float) -> None:
        time, state = self._at_physical(self._number, *self._before, end)
        self._evaluate(np.array([self._number]), np.array([time]), state[None, :])
        self._observers.add(np.array([time]), np.array([end]), state[None, :], np.array([True]))
        self._before = (time, state)

    def _evaluate(self, indices: npt.NDArray[np.int64], times: Array, states: Array) -> None:
        """Save states at the wanted physical times up to the end of this chunk."""
        if self._next_wanted >= len(self._wanted) or not len(times):
            return
        sign = np.sign(self._timeline.h)
        numbers = np.concatenate(([self._number], indices))
        all_times = np.concatenate(([self._before[0]], times))
        all_states = np.concatenate((self._before[1][None, :], states))
        clocks = all_states[:, -1] if self._clock else all_times
        while self._next_wanted < len(self._wanted):
            wanted = self._wanted[self._next_wanted]
            if sign * wanted > sign * clocks[-1]:
                return
            i = int(np.searchsorted(sign * clocks, sign * wanted, side="right")) - 1
            known = (int(numbers[i]), all_times[i], all_states[i])
            self._asked.append(self._at_physical(*known, wanted))
            self._next_wanted += 1

    def _at_physical(
        self, before: int, time: float, state: Array, wanted: float
    ) -> tuple[float, Array]:
        """Return (own time, state) at a physical time less than a step from a known state.

        `before` is the number of the step that led to that state.
        """
        # Implicit steps of a length in the last bits of the time would only add noise.
        nothing = rounding(wanted)

        def step(length: float) -> Array:
            return self._stepper.single_step(state, time, length, before=before)

        if not self._clock:
            gap = wanted - time
            return wanted, state.copy() if abs(gap) <= nothing else step(gap)
        advance, here = 0.0, state
        best, smallest = (time, state.copy()), abs(wanted - state[-1])
        for _ in range(MAX_CLOCK_ITERATIONS):
            missing = wanted - here[-1]
            if abs(missing) <= smallest:
                best, smallest = (time + advance, here.copy()), abs(missing)
            elif abs(missing) <= nothing:
                break
            rate = self._clock_rate(time + advance, here)
            tiny = nothing if advance == 0.0 else 0.125 * nothing
            if abs(missing) <= tiny or advance + missing / rate == advance:
                break
            advance += missing / rate
            here = step(advance)
        best[1][-1] = wanted
        return best

    def _clock_rate(self, time: float, state: Array) -> float:
        """Return dt/dτ."""
        problem = self._problem
        if self._rate is None:
            assert problem.clock is not None
            clock = bind(problem.clock, VALUE, params=len(problem.params), y=problem.rows)
            params, work = self._stepper.params, scalar_block(problem.work)
            self._rate = clock.call(self._stepper.compiled, params=params, work=work)
        return float(self._rate(t=time, y=Block(state[: problem.rows])))

    def solution(
        self, method: Method, account: Account, compile_seconds: float, status: Status | StepError
    ) -> Solution:
        """Return what has been gathered."""
        rows = self._problem.rows
        missed = len(self._wanted) - self._next_wanted
        if missed and status == "success":
            warnings.warn(
                f"the run ended at t = {self.physical_time:.9g}, before {missed} of the times in "
                f"t_eval, up to {self._wanted[-1]:.9g}",
                GeomintWarning,
                stacklevel=4,
            )
        steps, iterations = self._integrator.steps, self._integrator.iterations
        span = self._integrator.time - self._timeline.start
        sizes = StepSizes(*self._stepper.lengths(steps, span))
        saved = self._kept()
        tau = np.array([time for time, _ in saved])
        full = np.array([state for _, state in saved]).reshape(-1, len(self._stepper.state))
        physical = full[:, -1] if self._clock else tau if self._problem.time == "t" else None
        drift = self._observers.drifts(steps)
        message = "" if isinstance(status, str) else str(status)
        if status == "success" and (bad := not_finite(drift)):
            status, message = NOT_FINITE, bad
        return Solution(
            problem=self._problem,
            method=method,
            step=float(np.copysign(sizes.mean, self._timeline.h)),
            step_sizes=sizes,
            tau=tau,
            y=full[:, :rows],
            drift=drift,
            steps=steps,
            iterations=iterations,
            evaluations=self._stepper.evaluations_in(steps, iterations),
            rejected=self._stepper.rejected_in(steps, iterations),
            run_seconds=account.seconds,
            watching_seconds=account.watching_seconds,
            compile_seconds=compile_seconds,
            status=status if isinstance(status, str) else "failed",
            message=message,
            drift_time="t" if self._timeline.physical_end is not None else self._problem.time,
            physical=physical,
            restart=self._integrator.restart,
        )

    def _kept(self) -> list[State]:
        """Return the saved states: those at wanted times, as they were asked for; or with the last."""
        if len(self._wanted) and not self._save_every:
            return self._asked
        steps, last = self._saved, self._before
        if not steps or steps[-1][0] != last[0]:
            steps = [*steps, last]
        return merged(steps, self._asked, float(np.sign(self._timeline.h)), self._clock)
