"""Recorded functions of the state, watched together: one sweep over the states that are sampled."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Self

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

__all__ = ["ENERGY", "Function", "diagnostic", "grouped"]

ENERGY = "energy"  # the invariant that is shown apart from the others where it has this name
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


def diagnostic(problem: Problem, name: str) -> Function | None:
    """Return one of the problem's own quantities; None if it has none of that name."""
    if name in problem.invariants:
        return Function(problem.invariants[name], "energy" if name == ENERGY else "integrals")
    if name in problem.constraints:
        return Function(problem.constraints[name], "constraints")
    return Function(problem.observables[name]) if name in problem.observables else None


def grouped(names: Iterable[str], samples: float) -> list[tuple[str, ...]]:
    """Return which quantities are evaluated by one function: all, if so many states are watched.

    What they share, such as the angular velocity, is then computed once; but that function is
    compiled for these quantities alone.
    """
    known = tuple(names)
    return [known] if (len(known) - 1) * samples >= MANY else [(name,) for name in known]


class Sweep:
    """Functions along one run: evaluated on chunks of states, and reduced to windows."""

    def __init__(self, functions: Mapping[str, Function], run: Run, steps: int | None) -> None:
        self._functions, self._run, self._left = functions, run, steps
        self._entries: dict[tuple[str, ...], Any] = {}
        self._sample: Call | None = None
        self._windows: dict[str, Windows] = {}
        self._scales: dict[str, float] = {}
        self.sees_all = steps is not None

    def prepare(self) -> None:
        """Compile, or find in the cache, all functions, and evaluate them where the run begins."""
        if self._sample is not None:
            return
        run, problem, compiled = self._run, self._run.problem, self._run.stepper.compiled
        sizes = {"params": len(problem.params), "y": problem.rows}
        for names in grouped(self._functions, run.samples):
            f = written(*(self._functions[name].function for name in names))
            self._entries[names] = bind(f, FIELD, **sizes, out=len(names)).entry(compiled)
        self._sample = SAMPLE.call(
            compiled,
            params=filled_block(problem.params),
            rows=problem.rows,
            work=scalar_block(problem.work),
        )
        states = states_around(run.state)
        times = np.full(len(states), run.time)
        for name, values in self._values(times, states, self._entries):
            self._windows[name] = Windows(float(values[0]), run.time)
            self._scales[name] = scale_of(values, run.state)

    def add(self, seen: Seen) -> None:
        """Evaluate everything on the states that are sampled."""
        if self._left is not None:
            seen = seen.of(slice(0, self._left))
            self._left -= len(seen)
        which = seen.sampled
        self._evaluate(seen.times[which], seen.labels[which], seen.states[which], self._entries)

    def add_end(self, end: Seen) -> None:
        """Sample the last state of a run, where that has not been done."""
        if self._left is None or self._left > 0:
            late = [n for n in self._entries if self._windows[n[0]].last_time != end.labels[0]]
            self._evaluate(end.times, end.labels, end.states, late)

    def _evaluate(
        self, times: Array, labels: Array, states: Array, groups: Iterable[tuple[str, ...]]
    ) -> None:
        if len(times):
            for name, values in self._values(times, states, groups):
                self._windows[name].add(labels, values)

    def _values(
        self, times: Array, states: Array, groups: Iterable[tuple[str, ...]]
    ) -> Iterator[tuple[str, Array]]:
        """Yield the names of functions and their values at states, in memory that all share."""
        assert self._sample is not None
        count, stride = states.shape
        self._sample.set(
            times=Block(np.ascontiguousarray(times)),
            states=Block(np.ascontiguousarray(states).reshape(-1)),
            stride=stride,
            count=count,
        )
        for names in groups:
            out = scalar_block(count * len(names))
            self._sample(values=self._entries[names], out=out, width=len(names))
            yield from zip(names, out.data.reshape(count, len(names)).T, strict=True)

    def drifts(self, steps: int) -> Iterator[Drift]:
        """Yield the drift of every function over so many steps."""
        for name, windows in self._windows.items():
            scale = self._scales[name]
            noise = walk_level(scale, steps)
            described = self._functions[name].description
            yield drift_of_run(name, windows, scale, noise, **described)
