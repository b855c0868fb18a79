"""What a run says of its step: that it was not taken, or is longer than makes sense."""

from __future__ import annotations

import math
import warnings

from ..arguments import Array
from ..errors import DomainError, GeomintWarning
from ..methods import Method
from ..problems.problem import Problem
from .timeline import Timeline

__all__ = ["tell_long_steps", "tell_short_run"]

LONG = 2.0  # times the default step


def tell_short_run(problem: Problem, end: float, step: float) -> None:
    """Warn if the run was shorter than the step that was asked for, which it did not take."""
    if end < step * (1.0 - 1e-9):
        warnings.warn(
            f"step = {step:.9g} is longer than the run to {problem.time} = "
            f"{end:.9g}: a step of that length was taken instead",
            GeomintWarning,
            stacklevel=5,
        )


def tell_long_steps(problem: Problem, method: Method, state: Array, timeline: Timeline) -> None:
    """Warn of steps, longer than usual ones, that fixed-point iteration would have refused."""
    try:
        usual = method.default_step(problem, state, math.inf, timeline.start)
    except DomainError:  # there is none
        return
    if abs(timeline.h) > LONG * usual:
        warnings.warn(
            f"steps of {abs(timeline.h):.3g} are so long that Newton's method had to find some of "
            "them: what is faster is not resolved. If that is wanted, say "
            "geomint.Gauss(…, iteration='newton'); if not, give a shorter step",
            GeomintWarning,
            stacklevel=5,
        )
