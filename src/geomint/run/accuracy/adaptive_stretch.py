"""What a stretch of the motion shows of an adaptive method: two runs at different local tolerances."""

import dataclasses
import math

import numpy as np

from ...arguments import Array
from ...errors import StepError
from ...methods.adaptive import LARGEST_RTOL, LEAST_RTOL, Adaptive
from ...problems.evaluate import rates_of
from ..integrator import Integrator
from ..timeline import within_run
from .stretch import LONGEST, SAMPLES, Motion, Stretch, compared

FINER = 16.0  # times smaller tolerances


def at_tolerance(method: Adaptive, rtol: float) -> Adaptive:
    """Return the method at another rtol, and an atol that is the same part of it."""
    within = min(max(rtol, LEAST_RTOL), LARGEST_RTOL)
    return dataclasses.replace(method, rtol=within, atol=method.atol * (within / method.rtol))


def adaptive_stretch(
    method: Adaptive, motion: Motion, rtol: float, length: float, clock: bool
) -> Stretch | None:
    """Return how runs at a local tolerance and at a sixteenth of it part; None if one fails."""
    power = method.order / (method.base.estimate_order or method.order)
    rows = motion.problem.rows + clock
    coarse = _begun(at_tolerance(method, rtol), motion, clock)
    fine = _begun(at_tolerance(method, rtol / FINER), motion, clock)
    try:
        times, states = _own_states(coarse, motion, length, rows)
        there = np.empty_like(states)
        for i, time in enumerate(times):
            fine.propagate_until(motion.begin + math.copysign(time, motion.span))
            there[i] = fine.stepper.state[:rows]
    except StepError:
        return None
    return compared(motion, times, (states, there), 1.0 - FINER**-power, coarse.iterations)


def _begun(method: Adaptive, motion: Motion, clock: bool) -> Integrator:
    problem, y0, begin = motion.problem, motion.y0, motion.begin
    rate_at = within_run(rates_of(problem, y0, motion.compiled), (), motion.span, motion.end)
    first = method.default_step(problem, y0, motion.span, begin, rate_at)
    h = math.copysign(first, motion.span)
    flow = method.on(problem, y0, begin, clock, motion.compiled)
    integrator = Integrator.of(flow.begin(y0, begin, h))
    integrator.prepare()
    return integrator


def _own_states(
    integrator: Integrator, motion: Motion, length: float, rows: int
) -> tuple[Array, Array]:
    """Return times and states after steps of the method's own, some of them, up to a length or beyond.

    An end that steps are made to fit, other than that of the run, would make the last ones shorter.
    """
    begin, many, stepper = integrator.time, 1, integrator.stepper
    end = math.copysign(math.inf, motion.span) if motion.end is None else motion.end
    times: list[float] = []
    states = []
    while not times or (times[-1] < length and integrator.steps < LONGEST and not stepper.finished):
        integrator._aim(end)
        left = many
        while left > 0 and not stepper.finished:
            left -= integrator._some(left)
        times.append(abs(integrator.time - begin))
        states.append(integrator.stepper.state[:rows].copy())  # without that of time
        if len(times) == 2 * SAMPLES:
            times, states, many = times[1::2], states[1::2], 2 * many
    return np.array(times), np.array(states)
