"""What a stretch of the motion shows of a method's errors: two runs over it, and how they part.

The second run has 3/2 as many steps, so that both meet after every two steps of the first. With order
p it errs (2/3)^p times as much, and the difference is 1 − (2/3)^p of the first one's error (L. F.
Richardson). Where the order is not seen yet the difference is the error itself, or less than a factor
from it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...arguments import Array
from ...kernels.numbers.blocks import scalar_block
from ...kernels.solve.status import OK
from ...methods.stepper import Stepper
from ...problems.evaluate import rates_of, value_of
from ...problems.problem import Problem

__all__ = ["SAMPLES", "Motion", "Stretch", "compared", "stretch"]

COARSE, FINE = 2, 3  # steps of both runs from one meeting to the next
SAMPLES = 16  # meetings of a stretch, at most twice as many
LARGEST = 0.1  # relative: what differs by more says nothing


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


@dataclass(eq=False)
class Stretch:
    """What two runs over the beginning of a motion differ by.

    Attributes
    ----------
    step : float
        Of the coarser run, > 0.
    times : array
        Own times since the beginning, > 0, of the states that are compared.
    errors : array
        Of the coarser run there: the largest number, relative to the largest of its piece.
    each : int
        Steps of an interval, divided by 2.
    work : float
        Iterations a unit of time.
    rate : float
        dt/dτ in the mean, 1 without a clock.
    sizes : array
        The largest number of its piece, for each number of the state.
    """

    step: float
    times: Array
    errors: Array
    each: int
    work: float
    rate: float
    sizes: Array


def stretch(
    stepper: Stepper,
    motion: Motion,
    order: int,
    step: float,
    length: float,
    most: float = LARGEST,
) -> Stretch | None:
    """Return how runs with a step over a length part; None where one fails, or they part by `most`."""
    pairs = max(1, round(length / (COARSE * step)))
    each = max(1, pairs // SAMPLES)
    count = pairs // each
    h = math.copysign(step, motion.span)
    coarse, work = _states(stepper, motion, h, count, COARSE * each)
    if coarse is None:
        return None
    fine, _ = _states(stepper, motion, h * COARSE / FINE, count, FINE * each)
    if fine is None:
        return None
    times = COARSE * each * step * np.arange(1.0, count + 1.0)
    factor = 1.0 - (COARSE / FINE) ** order
    return compared(motion, times, (coarse, fine), factor, step, each, work, most)


def compared(
    motion: Motion,
    times: Array,
    runs: tuple[Array, Array],
    factor: float,
    step: float,
    each: int,
    work: float,
    most: float = LARGEST,
) -> Stretch | None:
    """Return what two runs show whose difference is `factor` times the first one's error.

    None where one of them is not finite, or they part by `most`.
    """
    (coarse, fine), rows = runs, motion.problem.rows
    off, rate = (coarse - fine) / factor, 1.0
    if coarse.shape[1] > rows:
        rate = abs(float(fine[-1, rows])) / float(times[-1])
        if motion.physical is not None:
            off[:, :rows] -= _moved(motion, fine, off[:, rows], times)
    off = off[:, :rows]
    sizes = sizes_along(motion, fine[:, :rows])
    errors = (np.abs(off) / sizes).max(axis=1)
    if not (errors[-1] < most and errors.max() < math.inf):
        return None
    return Stretch(step, times, errors, each, work / float(times[-1]), rate, sizes)


def _states(
    stepper: Stepper, motion: Motion, h: float, count: int, every: int
) -> tuple[Array | None, int]:
    """Return `count` states after every so many steps, and the iterations; None if a step fails."""
    out = scalar_block((count + 1) * stepper.rows)
    stepper.begin(motion.y0, motion.begin, h)
    done = stepper.advance(0, count * every, every, out)
    states = out.data[: count * stepper.rows].reshape(count, stepper.rows)
    return (states if done.status == OK else None), done.iterations


def _moved(motion: Motion, states: Array, late: Array, times: Array) -> Array:
    """Return how much states move in the physical time by which they are late."""
    problem, clock = motion.problem, motion.problem.clock
    assert clock is not None
    moved = np.zeros((len(states), problem.rows))
    rate_at = rates_of(problem, motion.y0, motion.compiled)
    pace_at = value_of(problem, clock, motion.y0, motion.compiled)
    for i, (y, time) in enumerate(zip(states[:, : problem.rows], times, strict=True)):
        rates = rate_at(problem, y, motion.begin + math.copysign(time, motion.span))
        moved[i] = rates / pace_at(y, 0.0) * late[i]
    return moved


def sizes_along(motion: Motion, states: Array) -> Array:
    """Return for each number the largest of its piece, at the beginning or in any of the states."""
    largest = np.maximum(np.abs(motion.y0), np.abs(states).max(axis=0)).tolist()
    whole = max(largest) or 1.0
    sizes: list[float] = []
    for _, rows in motion.problem.pieces:
        piece = largest[len(sizes) : len(sizes) + rows]
        sizes += [max(piece) or whole] * rows
    return np.array(sizes)
