"""Watchers: what is watched along a run, one class for each way to do it."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from ..arguments import Array, Booleans, finite, switch, whole
from ..errors import DomainError, GeomintError, WatcherError, nearest, quoted, raised, shortened
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.sending import Sendable
from ..methods.method import Method
from ..methods.stepper import Stepper
from ..problems.forms import Measure
from ..problems.problem import Problem
from ..problems.two_form import SymplecticForm
from .drift import Drift, drift_of_run, walk_level
from .windows import Series


@dataclass(frozen=True)
class Run:
    """A run that is about to begin, as watchers see it.

    Attributes
    ----------
    problem : Problem
    state : array
        Where it begins.
    time : float
        The problem's own time there.
    stepper : Stepper
        What takes the steps. It is that of the run: a watcher must not advance it, see `step`.
    samples : float
        About how many states will be sampled.
    method : Method or None
        What has made the stepper; None for an exact flow.
    """

    problem: Problem
    state: Array
    time: float
    stepper: Stepper
    samples: float = 0.0
    method: Method | None = None

    def step(self, state: Array, time: float, length: float) -> Array:
        """Return the state after one step of the run's method from any other state."""
        rows = self.problem.rows
        y = np.zeros(len(self.stepper.state))
        y[:rows] = state
        return self.stepper.single_step(y, time, length)[:rows]


@dataclass
class Seen:
    """States that a run has come to, one a row.

    Attributes
    ----------
    times, labels : array
        The problem's own times, and those that drifts are measured in.
    states : array
        With the clock's row, where physical time is integrated beside the state.
    sampled : array of bool
        Which of them are to be sampled.
    step : float
        The length of the steps that led to them, 0 if that is not known better than by their times.
    """

    times: Array
    labels: Array
    states: Array
    sampled: Booleans
    step: float = 0.0

    def __len__(self) -> int:
        return len(self.times)

    def of(self, which: Any) -> Seen:
        """Return some of the states."""
        rows = self.times[which], self.labels[which], self.states[which], self.sampled[which]
        return Seen(*rows, self.step)


@dataclass(eq=False, kw_only=True)
class Watcher(Sendable):
    r"""A number that is watched along a run: a dataclass that inherits from this class.

    Watchers are values: they compare, copy and pickle by their fields, which are their options: those
    that scenes and `with_options` may change. Every run works on a copy of its own, on which `begin` is
    called first: what a watcher remembers of a run it writes to itself.

    Parameters
    ----------
    steps : int, optional
        Watch over the first that many steps only. Default: all.

    Attributes
    ----------
    kind : str
        What reports group it by, a key of `geomint.watch.kinds.KINDS`: ``"integrals"`` are shown as
        errors of a method, ``"others"``, the default, as something that may change.
    every_state : bool
        Whether `values` needs the state after every step, however seldom it is sampled; else it gets
        sampled states alone.
    with_clock : bool
        Whether states are to have the row of physical time, where that is integrated beside them.
    invariant : bool
        Whether the number is the same in every representation that has it, so that a plan may
        integrate a cheaper one.
    own_noise : bool
        Whether `scale` is the noise of the instrument itself, which is another one in every run.
    in_all : bool
        Whether the group ``"all"`` means it, of what geomint has for every problem.
    label, note : str
        What axes call its deviation; a sentence for reports.
    """

    kind = "others"
    every_state = False
    with_clock = False
    invariant = False
    own_noise = False
    in_all = True
    label = "deviation"
    note = ""

    steps: int | None = None

    # --- what a watcher says ----------------------------------------------------------------------

    def begin(self, run: Run) -> float:
        """Prepare for a run, and return the value where it begins."""
        raise NotImplementedError

    def values(self, times: Array, states: Array, lengths: Array) -> Any:
        """Return the values after the next states, one for each.

        Parameters
        ----------
        times : array, shape (m,)
            In the problem's own time.
        states : array, shape (m, rows)
            One a row, in their order; read-only.
        lengths : array, shape (m,)
            How much time has gone by since the state before, of those that it sees: the length of a
            step, with its sign, if it sees them all.
        """
        raise NotImplementedError

    def scale(self) -> float:
        """Return what a rounding error of the value is measured against, at the end of the run."""
        return 1.0

    def noise(self, steps: int) -> float:
        """Return how large a random walk of rounding errors may get in so many steps."""
        return walk_level(self.scale(), steps)

    def obstacle(self, problem: Problem) -> str:
        """Return why a problem has no such quantity, or an empty string."""
        return ""

    def evaluates(self, problem: Problem) -> Recorded | Measure | SymplecticForm | None:
        """Return functions that are to be held to what the problem declares before a run."""
        return None

    def cost(self, problem: Problem) -> float:
        """Return what it costs at most where it sees a state, in steps of the method."""
        return 20.0

    # --- what is done with it ---------------------------------------------------------------------

    @classmethod
    def together(cls, group: Mapping[str, Self], run: Run) -> list[Any]:
        """Return what watches for several watchers of this class along a run; see `Watch`."""
        return [Watch(name, watcher, run) for name, watcher in group.items()]

    @property
    def description(self) -> dict[str, Any]:
        """What it says of its quantity, for `geomint.Drift`."""
        return {key: getattr(self, key) for key in ("kind", "label", "note", "own_noise")}

    @property
    def sees_all(self) -> bool:
        """Whether it needs the state after every step."""
        return self.every_state or self.steps is not None

    @property
    def options(self) -> dict[str, Any]:
        """The fields that only keywords give, and their values."""
        return {f.name: getattr(self, f.name) for f in dataclasses.fields(self) if f.kw_only}

    def entries(self, run: Run) -> int:
        """Return how many functions `begin` compiles, for the line that says how long it will take."""
        return 0

    def with_options(self, **options: Any) -> Self:
        """Return the watcher with other options.

        Raises
        ------
        DomainError
            For options that it does not have, and values that are not of the kind of the default.
        """
        known = self.options
        for name, value in options.items():
            if name not in known:
                words = f"no such option.{nearest(name, known)}" if known else "no options"
                raise DomainError(name, value, words)
        kept = {name: _like(name, value, known[name]) for name, value in options.items()}
        try:
            return dataclasses.replace(self, **kept)
        except GeomintError:
            raise
        except Exception as error:  # whatever a user's class raises
            said = raised(error)
            raise DomainError("options", options, f"what {quoted(self)} takes ({said})") from error


def _like(name: str, value: Any, default: Any) -> Any:
    """Return a value of the kind of the default, as far as that is plain."""
    if isinstance(default, bool):
        return switch(name, value)
    if isinstance(default, int):
        return whole(name, value, -(2**53))
    if isinstance(default, float):
        return finite(name, value)
    if isinstance(default, str) and not isinstance(value, str):
        raise DomainError(name, value, "a string")
    return value


class Watch:
    """A watcher along one run: gives it states, and keeps the windows of its values.

    What watches for several, see `Watcher.together`, has the same methods.
    """

    def __init__(self, name: str, watcher: Watcher, run: Run) -> None:
        self._name, self._watcher, self._run = name, copy.copy(watcher), run
        self._time, self._left = run.time, math.inf if watcher.steps is None else watcher.steps
        self._end: tuple[Array, Array] | None = None  # time and value after the last state seen
        self._over = False
        self._series: Series | None = None
        self.sees_all = watcher.sees_all

    @property
    def entries(self) -> int:
        """How many functions `prepare` asks for, nearly."""
        return self._watcher.entries(self._run)

    def prepare(self) -> None:
        """Let the watcher begin: before the first step, with what is to be compiled."""
        if self._series is None:
            value = self._asked(self._watcher.begin, self._run)
            self._series = Series(np.array([value]), self._run.time)
            self._asked(self._watcher.scale)

    def _asked(self, question: Callable[..., Any], *given: Any, count: int = 0) -> Any:
        """Return a number of the watcher, or `count` of them; or raise an error that names it."""
        try:
            found = np.asarray(question(*given))
            if found.shape != ((count,) if count else ()) or found.dtype.kind not in "biuf":
                expected = f"{count} real numbers, one for each state" if count else "a real number"
                said = " ".join(shortened(str(found), 100).split())
                raise TypeError(f"{question.__name__} returned {said}: expected {expected}")
            return found.astype(np.float64) if count else float(found)
        except Exception as error:  # whatever a user's class raises
            self._over = True
            if isinstance(error, GeomintError) and self._series is None:
                raise
            what = raised(error)
            raise WatcherError(self._name, self._time, what) from error

    def add(self, seen: Seen) -> None:
        """Take the next states: all of them, or those that are sampled."""
        assert self._series is not None
        seen = seen if self.sees_all else seen.of(seen.sampled)
        if len(seen) > self._left:
            seen = seen.of(slice(0, int(self._left)))
        if self._over or not len(seen):
            return
        self._left -= len(seen)
        between = np.diff(seen.times, prepend=self._time)
        lengths = np.full(len(seen), seen.step) if seen.step and self.sees_all else between
        states = (
            seen.states if self._watcher.with_clock else seen.states[:, : self._run.problem.rows]
        )
        states = states.view()
        states.flags.writeable = False
        found = self._asked(self._watcher.values, seen.times, states, lengths, count=len(seen))
        self._time = float(seen.times[-1])
        self._end = seen.labels[-1:].copy(), found[-1:]
        self._series.add(seen.labels[seen.sampled], found[None, seen.sampled])

    def add_end(self, end: Seen) -> None:
        """Sample the last state of a run, if that is still to do; or the last seen."""
        assert self._series is not None
        if not self.sees_all and self._series.last_time != end.labels[0]:
            self.add(end)
        elif self._end is not None and self._end[0][0] != self._series.last_time:
            self._series.add(self._end[0], self._end[1][None, :])

    def drifts(self, steps: int) -> Iterable[Drift]:
        """Yield the drift over so many steps."""
        assert self._series is not None
        scale, noise = self._asked(self._watcher.scale), self._asked(self._watcher.noise, steps)
        scale = 1.0 if scale <= 0.0 else scale
        described = self._watcher.description
        (windows,) = self._series.windows()
        yield drift_of_run(self._name, windows, scale, noise, **described)
