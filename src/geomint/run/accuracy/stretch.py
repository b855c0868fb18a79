"""What a stretch of the motion shows of a method's errors: two runs over it, and how they part.

The second run has 3/2 as many steps, so that both meet after every two steps of the first. With order
p it errs (2/3)^p times as much, and the difference is 1 − (2/3)^p of the first one's error (L. F.
Richardson). Where the order is not seen yet the difference is the error itself, or less than a factor
from it.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arguments import Array
from ...kernels.numbers.blocks import Block
from ...kernels.solve.status import OK
from ...kernels.solve.trial import PARTING, TRIAL
from ...methods.partial import beside, ends_of
from ...methods.stepper import Stepper
from ...problems.problem import Problem
from ..local_error import COARSE, FINE

SAMPLES = 16  # meetings of a stretch, at most twice as many
LONGEST = 2.0**17  # of a trial, in coarse steps: it is one call, for whose end Ctrl-C waits
ROUNDINGS = 1e-12  # of a length
LARGEST = 0.1  # relative: what differs by more says nothing
FITTED = 0.25  # of the time of a stretch: errors from there on count


@dataclass(eq=False)
class Motion:
    """What is integrated, from where and how far.

    Attributes
    ----------
    begin, span : float
        In the problem's own time; the span with its sign. A guess, if the end is physical.
    physical : float or None
        The span in physical time, where the end was given in it and is not the problem's own time.
    compiled : bool
        Whether its functions are.
    """

    problem: Problem
    y0: Array
    begin: float
    span: float
    physical: float | None = None
    compiled: bool = True

    @property
    def end(self) -> float | None:
        """The end in the problem's own time, where that is known."""
        return None if self.physical is not None else self.begin + self.span


@dataclass(eq=False)
class Stretch:
    """What two runs over the beginning of a motion differ by.

    Attributes
    ----------
    times : array
        Own times since the beginning, > 0, of the states that are compared.
    errors : array
        Of the coarser run there: the largest number, relative to the largest of its piece.
    work : float
        Iterations a unit of time.
    states : array, shape (m, rows)
        Those of the finer run, with the clock where there is one.
    rate : float
        dt/dτ in the mean, 1 without a clock.
    """

    times: Array
    errors: Array
    work: float
    states: Array
    rate: float = 1.0


def stretch(
    stepper: Stepper, motion: Motion, order: int, step: float, length: float
) -> Stretch | None:
    """Return how runs with a step over a length part; None where one fails, or they part by much."""
    pairs = max(1, round(min(LONGEST, length / (COARSE * step))))
    if pairs * COARSE * step >= abs(motion.span) * (1.0 - ROUNDINGS):  # a trial ends before the run
        pairs, step = (pairs - 1, step) if pairs > 1 else (1, step * (1.0 - 2.0 * ROUNDINGS))
    each = max(1, pairs // SAMPLES)
    count, rows, h = pairs // each, stepper.rows, math.copysign(step, motion.span)
    sizes, errors, out = np.empty(len(motion.y0)), np.empty(count), np.empty(2 * count * rows)
    done = beside(
        stepper,
        TRIAL,
        t=motion.begin,
        h=h,
        shorter=h * COARSE / FINE,
        coarse=COARSE * each,
        fine=FINE * each,
        count=count,
        factor=1.0 - (COARSE / FINE) ** order,
        out=Block(out),
        y0=Block(motion.y0),
        sizes=Block(sizes),
        errors=Block(errors),
    )
    if done.status != OK:
        return None
    times, fine = COARSE * each * step * np.arange(1.0, count + 1.0), out.reshape(2, count, rows)[1]
    return _shown(Stretch(times, errors, done.iterations, fine), motion)


def _shown(found: Stretch, motion: Motion) -> Stretch | None:
    """Return what is found, a unit of time; None if it is not finite, or runs part by `LARGEST`."""
    if not (found.errors[-1] < LARGEST and found.errors.max() < math.inf):
        return None
    end, rows, fine = float(found.times[-1]), len(motion.y0), found.states
    found.work /= end
    if fine.shape[1] > rows:
        found.rate = abs(float(fine[-1, rows])) / end
    return found


def compared(motion: Motion, times: Array, runs: Any, factor: float, work: float) -> Stretch | None:
    """Return what two runs show whose difference is `factor` times the first one's error.

    None where one of them is not finite, or they part by `LARGEST`.
    """
    coarse, fine = runs
    sizes, errors = np.empty(len(motion.y0)), np.empty(len(times))
    arrays = {"coarse": coarse, "fine": fine, "y0": motion.y0}
    call = PARTING.call(motion.compiled, ends=ends_of(motion.problem))
    call.set(**{name: Block(np.ascontiguousarray(a).reshape(-1)) for name, a in arrays.items()})
    call.set(sizes=Block(sizes), errors=Block(errors))
    call(rows=coarse.shape[1], count=len(times), factor=factor)
    return _shown(Stretch(times, errors, work, fine), motion)


def extrapolated(times: Array, errors: Array, end: float, symmetric: bool) -> float:
    """Return the error at `end`, from those at some times before.

    Of a regular motion the phases go wrong in proportion to time, and by a symmetric method nothing
    else does; by others the frequencies do too, and the phases with the square of time: e/t is then
    a + b t, whose coefficients are fitted, none of them negative.
    """
    unit = 2.0 ** min(-math.frexp(times[-1])[1], 1000)  # squares of times are finite
    times, end = unit * times, unit * end
    first = int(times.searchsorted(FITTED * times[-1]))
    t = times[first:]
    slopes = errors[first:] / t
    mean = math.sqrt(float(np.add.reduce(slopes * slopes)) / len(t))
    if symmetric or len(t) < 4 or end <= times[-1]:
        return mean * end
    tilt = float(np.polyfit(t, slopes, 1)[0])
    if tilt <= 0.0:
        return mean * end
    level = float(np.mean(slopes)) - tilt * float(np.mean(t))
    if level < 0.0:
        level, tilt = 0.0, float(np.sum(slopes * t) / np.sum(t * t))
    return level * end + tilt * end * end
