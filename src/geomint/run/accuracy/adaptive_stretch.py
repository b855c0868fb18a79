"""What a stretch of the motion shows of an adaptive method: two runs at different local tolerances."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from ...arguments import Array
from ...errors import StepError
from ...methods.adaptive import LARGEST_RTOL, LEAST_RTOL, Adaptive
from ...methods.method import Start
from ..integrator import Integrator
from .stretch import SAMPLES, Motion, Stretch, compared

__all__ = ["adaptive_stretch", "at_tolerance"]

FINER = 16.0  # times smaller tolerances


def at_tolerance(method: Adaptive, rtol: float) -> Adaptive:
    """Return the method at another rtol, and an atol that is the same part of it."""
    within = min(max(rtol, LEAST_RTOL), LARGEST_RTOL)
    return dataclasses.replace(method, rtol=within, atol=method.atol * (within / method.rtol))


def adaptive_stretch(
    method: Adaptive, motion: Motion, rtol: float, length: float, clock: bool, compiled: bool
) -> Stretch | None:
    """Return how runs at a local tolerance and at a sixteenth of it part; None if one fails.

    What is called the step of the stretch is the tolerance.
    """
    times = length * np.arange(1, SAMPLES + 1) / SAMPLES
    power = method.order / (method.base.estimate_order or method.order)
    runs, work = [], 0
    for factor in (1.0, 1.0 / FINER):
        finer = at_tolerance(method, factor * rtol)
        first = finer.default_step(motion.problem, motion.y0, motion.span, motion.begin)
        h = math.copysign(first, motion.span)
        start = Start(motion.problem, motion.y0, motion.begin, h, clock, compiled)
        integrator = Integrator.of(finer, start)
        try:
            integrator.prepare()
            runs.append(_states(integrator, motion, times, motion.problem.rows + clock))
        except StepError:
            return None
        work = work or integrator.iterations
    return compared(motion, times, (runs[0], runs[1]), 1.0 - FINER**-power, rtol, 1, work)


def _states(integrator: Integrator, motion: Motion, times: Array, rows: int) -> Array:
    states = np.empty((len(times), rows))
    for i, time in enumerate(times):
        integrator.propagate_until(motion.begin + math.copysign(time, motion.span))
        states[i] = integrator.stepper.state[:rows]  # without that of time
    return states
