"""Recorded functions of the state, watched together: one sweep over the states that are sampled."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Self, TypeVar

import numpy as np

from ..arguments import Array
from ..kernels.compiling.bound import bind
from ..kernels.compiling.call import Call
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import FIELD
from ..kernels.numbers.blocks import Block, scalar_block
from ..kernels.solve.sample import SAMPLE
from ..methods.stepper import filled_block
from ..problems.evaluate import scale_of, states_around
from ..problems.problem import Problem
from ..problems.spaces.conditions import written
from .drift import Drift, drift_of_run, walk_level
from .watcher import Run, Seen, Watcher
from .windows import Windows

__all__ = ["ENERGY", "Function", "grouped"]

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


@dataclass
class _Group:
    """Functions that are evaluated by one: it, how many, and windows and scale of each."""

    entry: Any
    width: int
    series: list[tuple[Windows, float]] = field(default_factory=list)


class Sweep:
    """Functions along one run: evaluated on chunks of states, and reduced to windows."""

    def __init__(self, functions: Mapping[str, Function], run: Run, steps: int | None) -> None:
        self._functions, self._run, self._left = functions, run, steps
        self._groups: list[_Group] = []
        self._sample: Call | None = None
        self.sees_all = steps is not None

    @property
    def entries(self) -> int:
        """How many functions `prepare` asks for."""
        return 1 + len(grouped(self._functions.values(), self._run.samples))

    def prepare(self) -> None:
        """Compile, or find in the cache, all functions, and evaluate them where the run begins."""
        if self._sample is not None:
            return
        run, problem, compiled = self._run, self._run.problem, self._run.stepper.compiled
        sizes = {"params": len(problem.params), "y": problem.rows}
        self._groups = []  # begun anew after Ctrl-C
        for functions in grouped(self._functions.values(), run.samples):
            f = written(*(function.function for function in functions))
            entry = bind(f, FIELD, **sizes, out=len(functions)).entry(compiled)
            self._groups.append(_Group(entry, len(functions)))
        self._sample = SAMPLE.call(
            compiled,
            params=filled_block(problem.params),
            rows=problem.rows,
            work=scalar_block(problem.work),
        )
        states = states_around(run.state)
        times = np.full(len(states), run.time)
        for group, values in self._values(times, states, self._groups):
            for own in values:
                windows = Windows(float(own[0]), run.time)
                group.series.append((windows, scale_of(own, run.state)))

    def add(self, seen: Seen) -> None:
        """Evaluate everything on the states that are sampled."""
        if self._left is not None:
            seen = seen.of(slice(0, self._left))
            self._left -= len(seen)
        which = seen.sampled
        self._add(seen.times[which], seen.labels[which], seen.states[which], self._groups)

    def add_end(self, end: Seen) -> None:
        """Sample the last state of a run, where that has not been done."""
        if self._left is None or self._left > 0:
            late = [g for g in self._groups if g.series[0][0].last_time != end.labels[0]]
            self._add(end.times, end.labels, end.states, late)

    def _add(self, times: Array, labels: Array, states: Array, groups: list[_Group]) -> None:
        if len(times):
            for group, values in self._values(times, states, groups):
                for (windows, _), own in zip(group.series, values, strict=True):
                    windows.add(labels, own)

    def _values(
        self, times: Array, states: Array, groups: list[_Group]
    ) -> Iterator[tuple[_Group, Array]]:
        """Yield the values of the functions of each group at states, one a row."""
        assert self._sample is not None
        count, stride = states.shape
        self._sample.set(
            times=Block(np.ascontiguousarray(times)),
            states=Block(np.ascontiguousarray(states).reshape(-1)),
            stride=stride,
            count=count,
        )
        for group in groups:
            out = scalar_block(count * group.width)
            self._sample(values=group.entry, out=out, width=group.width)
            yield group, out.data.reshape(count, group.width).T

    def drifts(self, steps: int) -> Iterator[Drift]:
        """Yield the drift of every function over so many steps."""
        series = itertools.chain.from_iterable(group.series for group in self._groups)
        for (name, function), (windows, scale) in zip(self._functions.items(), series, strict=True):
            noise = walk_level(scale, steps)
            yield drift_of_run(name, windows, scale, noise, **function.description)
