"""Recorded functions of the state, watched together: one sweep over the states that are sampled."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Self, TypeVar

import numpy as np

from ..arguments import Array
from ..kernels.compiling.recorded import Recorded
from ..problems.at_states import Values, writer
from ..problems.evaluate import scales_of, states_around
from ..problems.problem import Problem
from ..problems.spaces.conditions import written
from .drift import Drift, drift_of_run, walk_level
from .watcher import Run, Seen, Watcher
from .windows import Series

ENERGY = "energy"  # the invariant that is shown apart from the others where it has this name
T = TypeVar("T")
MANY = 1_000_000  # calls saved, at some 15 ns each: they pay for compiling another function


@dataclass(eq=False)
class Function(Watcher):
    """A recorded function ``f(params, t, y, work)`` of the sampled states.

    Parameters
    ----------
    function : Recorded
    kind : str
        What it is to its problem, see `Watcher`.
    """

    invariant = True

    function: Recorded
    kind: str = "others"

    def evaluates(self, problem: Problem) -> Recorded:
        return self.function

    def cost(self, problem: Problem) -> float:
        return 1.0 / 300.0

    @classmethod
    def together(cls, group: Mapping[str, Self], run: Run) -> list[Any]:
        """Return one sweep for all, and one for each that sees the first steps alone."""
        groups: dict[int | None, dict[str, Function]] = {}
        for name, function in group.items():
            groups.setdefault(function.steps, {})[name] = function
        return [Sweep(functions, run, steps) for steps, functions in groups.items()]


def grouped(quantities: Iterable[T], samples: float) -> list[tuple[T, ...]]:
    """Return which quantities are evaluated by one function: all, if so many states are watched.

    What they share, such as the angular velocity, is then computed once; but that function is
    compiled for these quantities alone.
    """
    known = tuple(quantities)
    return [known] if (len(known) - 1) * samples >= MANY else [(one,) for one in known]


class Sweep:
    """Functions along one run: evaluated on chunks of states, and reduced to windows."""

    def __init__(self, functions: Mapping[str, Function], run: Run, steps: int | None) -> None:
        self._functions, self._run, self._left = functions, run, steps
        self._write: Values | None = None
        self._series: Series | None = None
        self._scales: list[float] = []
        self.sees_all = steps is not None

    @property
    def entries(self) -> int:
        """How many functions `prepare` asks for."""
        return 1 + len(grouped(self._functions.values(), self._run.samples))

    def prepare(self) -> None:
        """Compile, or find in the cache, all functions, and evaluate them where the run begins."""
        if self._series is not None:
            return
        run, problem, compiled = self._run, self._run.problem, self._run.stepper.compiled
        groups = grouped((f.function for f in self._functions.values()), run.samples)
        functions, width = [written(*group) for group in groups], len(groups[0])
        self._write = writer(problem, functions, width, compiled)
        states = states_around(run.state)
        times = np.empty(len(states))
        times.fill(run.time)
        values = self._values(times, states)
        self._scales = scales_of(values, run.state)
        self._series = Series(values[:, 0], run.time)

    def add(self, seen: Seen) -> None:
        """Evaluate everything on the states that are sampled."""
        if self._left is not None:
            seen = seen.of(slice(0, self._left))
            self._left -= len(seen)
        assert self._series is not None
        if len(seen := seen.of(seen.sampled)):
            self._series.add(seen.labels, self._values(seen.times, seen.states))

    def add_end(self, end: Seen) -> None:
        """Sample the last state of a run, where that has not been done."""
        assert self._series is not None
        if self._series.last_time != end.labels[0]:
            self.add(end)

    def _values(self, times: Array, states: Array) -> Array:
        """Return the values of the functions, one a row, at states, one a row."""
        assert self._write is not None
        found = self._write(times, states)  # one function writes all of a state, or each its own
        return found[0].T if len(found) == 1 else found[:, :, 0]

    def drifts(self, steps: int) -> Iterator[Drift]:
        """Yield the drift of every function over so many steps."""
        assert self._series is not None
        known = zip(self._functions.items(), self._series.windows(), self._scales, strict=True)
        for (name, function), windows, scale in known:
            noise = walk_level(scale, steps)
            yield drift_of_run(name, windows, scale, noise, **function.description)
