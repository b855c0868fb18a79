"""Spot samples along a run: whether the motion is as it was on the stretch of the trials.

At some steps of the run the stretch between two meetings of the trials is run once more from there, by
both runs that they compare. What these differ by is compared with what the last trial found for such
a stretch in the mean.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from ...arguments import Array
from ...kernels.numbers.blocks import scalar_block
from ...kernels.solve.status import OK
from ..integrator import Integrator
from .stretch import COARSE, FINE

__all__ = ["Sample", "Spots"]

MOST, PART = 4, 0.03  # spots, and the part of the run's steps that they may cost
ROUNDING = 1e-14  # relative: less says nothing
_NOTHING = scalar_block(0)


@dataclass(eq=False)
class Sample:
    """What the last trial on a stretch showed: the measure of spots.

    Attributes
    ----------
    each : int
        Pairs of steps between two meetings.
    mean : float
        The error that steps from one to the next have added, in the mean, relative.
    sizes : array
        What each number of the state is relative to.
    """

    each: int
    mean: float
    sizes: Array


@dataclass
class Spots:
    """Where a run is looked at, and what was found there.

    Attributes
    ----------
    found : list of (float, float)
        Times, in the problem's own time, and differences in units of the mean of the sample.
    """

    sample: Sample
    found: list[tuple[float, float]] = field(default_factory=list)

    def begin(self, integrator: Integrator, expected: float) -> None:
        """Place the spots in a run of about so many steps."""
        cost = (COARSE + FINE) * self.sample.each
        count = min(MOST, int(PART * min(expected, 1e15) / cost))
        self._marks = [int(expected * i / (count + 1)) for i in range(1, count + 1)]
        self._integrator = integrator

    def most(self, done: int) -> float:
        """Return how many steps lead from `done` to the next spot."""
        return self._marks[0] - done if self._marks else math.inf

    def look(self) -> None:
        """Look at the run where it is, if that is a spot."""
        if self._marks and self._integrator.done >= self._marks[0]:
            self._marks.pop(0)
            self._sample()

    def _sample(self) -> None:
        """Run the stretch of a sample from here, by both runs, and note how far they part."""
        stepper = self._integrator.stepper
        each, h = self.sample.each, stepper.h
        coarse = self._run(h, COARSE * each)
        fine = self._run(h * COARSE / FINE, FINE * each)
        off = float(np.max(np.abs(coarse - fine) / self.sample.sizes))
        mean = max(self.sample.mean, ROUNDING)
        self.found.append((self._integrator.time, off / mean if math.isfinite(off) else math.inf))

    def _run(self, h: float, steps: int) -> Array:
        """Return the state after so many steps from where the run is; infinite if one fails."""
        stepper, rows = self._integrator.stepper.aside, len(self.sample.sizes)
        stepper.begin(self._integrator.stepper.state, self._integrator.time, h)
        done = stepper.advance(0, steps, steps + 1, _NOTHING)
        return stepper.state[:rows].copy() if done.status == OK else np.full(rows, np.inf)
