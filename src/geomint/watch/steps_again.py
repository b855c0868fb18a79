"""Watchers that take every step once more, with directions tangent to the manifold of states."""

from dataclasses import dataclass

import numpy as np

from ..arguments import Array
from ..kernels.compiling.call import Call
from ..kernels.numbers.blocks import Block
from ..methods.carried import Carried
from ..methods.stepper import Stepper
from ..problems.problem import Problem
from .watcher import Run, Watcher

BATCH = 1024  # steps of one call, between which Ctrl-C is seen


@dataclass(eq=False, kw_only=True)
class StepsAgain(Watcher):
    """A number of every step that its derivative tells: 0 at the start, and up to the noise for some.

    Parameters
    ----------
    steps : int, optional
        Over the first so many. Each costs as much as some steps of the method.
    """

    every_state = True
    with_clock = True
    own_noise = True

    def cost(self, problem: Problem) -> float:
        return 1.5 * problem.rows  # tangent vectors, eight at once

    def entries(self, run: Run) -> int:
        return run.stepper.flow.entries + 3  # the sweep, conditions, and a density or a form

    def sweep(self, problem: Problem, stepper: Stepper, carried: Carried, y0: Array) -> Call:
        """Return what gets ``starts``, ``lengths``, ``states`` and writes ``out``, all else given."""
        raise NotImplementedError

    def begin(self, run: Run) -> float:
        """Compile, or find in the cache, the sweep with the method's step in it."""
        self._run = run = self.seen(run)
        self._stepper, self._time = run.stepper.fixed_step, run.time
        self._carried = Carried(run.problem, self._stepper, run.state, run.time)
        self._sweep = self.sweep(run.problem, self._stepper, self._carried, run.state)
        return 0.0

    def seen(self, run: Run) -> Run:
        """Return the run whose steps are taken: in the first rows of the states, perhaps."""
        return run

    def values(self, times: Array, states: Array, lengths: Array) -> Array:
        starts = np.concatenate(([self._time], times[:-1]))
        early = times - lengths - np.copysign(2.0 * np.spacing(np.abs(times)), lengths)
        beyond = (starts + lengths - times) * lengths > 0.0  # by rounding: perhaps of the run
        starts = np.where(beyond, early, starts)
        values = np.zeros(len(times))
        flat = np.array(states[:, : self._stepper.rows])
        for first in range(0, len(times), BATCH):
            here = slice(first, first + BATCH)
            while True:
                known = self._carried.remembered
                self._sweep(
                    starts=Block(starts[here]),
                    lengths=Block(lengths[here]),
                    states=Block(flat[here].reshape(-1)),
                    out=Block(values[here]),
                )
                if np.isfinite(values[here]).all() or not self._carried.turn(self._stepper):
                    break
                run, self._carried.remembered = self._run, known
                self._sweep = self.sweep(run.problem, self._stepper, self._carried, run.state)
        self._time = float(times[-1])
        return values
