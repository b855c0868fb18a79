"""What a run says of its step: that it was not taken, or is longer than makes sense."""

from __future__ import annotations

import contextlib
import math
import warnings

import numpy as np

from ..arguments import Array
from ..errors import DomainError, GeomintWarning
from ..methods import Method
from ..methods.adaptive import Adaptive
from ..problems.evaluate import derivative, rounding_scale, value
from ..problems.problem import Problem
from ..problems.time_scale import characteristic_time
from ..watch.functions import ENERGY
from .solution import Solution
from .timeline import Timeline

__all__ = ["tell_coarse_steps", "tell_long_steps", "tell_short_run"]

LONG = 2.0  # times the default step
LOST = 1e-2  # of the scale of an integral: what is off by more at the end is not the motion
KEPT = 1e-6  # likewise, where a step is longer than a turn
TURN = 2.0 * math.pi  # characteristic times: that of a rotation by once around
FEW = 60  # numbers of a state whose integrals plain Python evaluates in a moment


def tell_short_run(problem: Problem, end: float, step: float) -> None:
    """Warn if the run was shorter than the step that was asked for, which it did not take."""
    if end < step * (1.0 - 1e-9):
        _warn(
            f"step = {step:.9g} is longer than the run to {problem.time} = "
            f"{end:.9g}: a step of that length was taken instead"
        )


def tell_long_steps(problem: Problem, method: Method, state: Array, timeline: Timeline) -> None:
    """Warn of steps, longer than usual ones, that fixed-point iteration would have refused."""
    try:
        usual = method.default_step(problem, state, math.inf, timeline.start)
    except DomainError:  # there is none
        return
    if abs(timeline.h) > LONG * usual:
        _warn(
            f"steps of {abs(timeline.h):.3g} are so long that Newton's method had to find some of "
            "them: what is faster is not resolved. If that is wanted, say "
            "geomint.Gauss(…, iteration='newton'); if not, give a shorter step"
        )


def tell_coarse_steps(solution: Solution, state: Array, timeline: Timeline) -> None:
    """Warn of given steps that cannot follow the motion, as far as its end shows it.

    An integral of the motion is off there by more than `LOST`; or a step is longer than a turn at the
    characteristic rate of the beginning, and no integral is kept. Methods that keep their integrals at
    such steps, as group methods do in a steady rotation, are right.
    """
    problem, h = solution.problem, abs(timeline.h)
    if isinstance(solution.method, Adaptive) or not len(solution.y) or problem.rows > FEW:
        return
    turning = _turns(problem, state, timeline.h, timeline.start) > TURN
    lost = _integral_off(solution, state, timeline.start, KEPT if turning else LOST)
    told = [f"{lost} at the end"] if lost else []
    if turning and (lost or not problem.invariants):
        told.append("the motion turns around within one")
    if told:
        _warn(
            f"steps of {h:.3g} are so long that {' and '.join(told)}: give a shorter step, or a "
            "tolerance in its place"
        )


def _integral_off(solution: Solution, state: Array, start: float, allowed: float) -> str:
    """Return in words which integral is off at the end by more than a part of its scale; or nothing.

    The energy is looked at, where there is one, and else all. The scale is `rounding_scale` where the
    run began.
    """
    problem, known = solution.problem, solution.problem.invariants
    end, time = solution.y[-1], float(solution.tau[-1])
    for name in [ENERGY] if ENERGY in known else known:
        with contextlib.suppress(ArithmeticError):  # of a function in plain Python
            before = value(problem, known[name], state, start)
            change = abs(value(problem, known[name], end, time) - before)
            if change > allowed * abs(before):
                off = change / rounding_scale(problem, known[name], state)
                if off > allowed:
                    return f"{name} is off by {off:.2g} of its size"
    return ""


def _turns(problem: Problem, state: Array, h: float, start: float) -> float:
    """Return how many characteristic times a step is."""
    rates = derivative(problem, state, start)
    sizes = [(np.abs(state[p]).max(), np.abs(rates[p]).max()) for p in problem.slices.values()]
    if not any(rate * abs(h) > TURN * size for size, rate in sizes):
        return 0.0  # at no cost
    return abs(h) / characteristic_time(problem, state, h, start)


def _warn(text: str) -> None:
    warnings.warn(text, GeomintWarning, stacklevel=6)
