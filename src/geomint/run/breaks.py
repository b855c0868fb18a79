"""Times at which something switches: a run with them is one of stretches, which meet there.

No step straddles such a time, and none is evaluated at it: with ``t < b`` or with ``t <= b`` a switch
is the same. A stretch ends `GAP` roundings before it, so that no sum of a time and a step rounds to
more, and the next begins one rounding behind it.
"""

import math
from itertools import pairwise
from typing import Any

import numpy as np

from ..arguments import as_array
from ..errors import DomainError, MethodError
from ..methods.stepper import GAP
from ..problems.problem import Problem
from .integrator import Integrator
from .solution import Solution
from .timeline import Timeline, counted, ending, reached_by, within

APART = 4 * GAP  # roundings: times that are nearer to each other are the same


def breaks_of(
    given: Any, problem: Problem | Solution, t0: float, t_end: Any, tau_end: Any
) -> tuple[float, ...]:
    """Return breaks in the order of the run, each once, or raise `DomainError`."""
    restart = None
    if isinstance(problem, Solution):
        former, problem = problem, problem.problem
        restart = former.restart
    begin, end, own = ending(problem, t_end, tau_end, t0, restart is None)
    if not own:
        expected = "none with t_end: the functions of a problem in τ switch at τ; give tau_end"
        raise DomainError("breaks", given, expected)
    if restart is not None:
        begin = reached_by(restart, problem, former.method, own)
    times = np.atleast_1d(as_array("breaks", given, "times"))
    apart = APART * math.ulp(max(begin, end, key=abs))
    low, high = min(begin, end) + apart, max(begin, end) - apart
    if times.ndim != 1 or not ((low < times) & (times < high)).all():  # and no NaN
        expected = f"times between {begin:.9g} and {end:.9g}, where the run begins and ends"
        raise DomainError("breaks", given, expected)
    times = np.sort(times)
    times = times[np.diff(times, prepend=-math.inf) > apart]
    return tuple(times.tolist() if end > begin else times[::-1].tolist())


def divided(
    integrator: Integrator,
    timeline: Timeline,
    breaks: tuple[float, ...],
    halved: float,
    least: int,
) -> tuple[Timeline, ...]:
    """Return the stretches of a run from where the integrator is: the run itself without breaks inside.

    They may have been given for a longer run. Each stretch is divided into as many equal steps as make
    them no longer than that of the timeline, `least` at least; or into halves of such steps of a
    `halved` length.

    Raises
    ------
    MethodError
        For a composition that leaves its steps on the way.
    """
    begin, end, sign = integrator.time, timeline.own_end or 0.0, math.copysign(1.0, timeline.h)
    inside = [b for b in breaks if sign * begin < sign * b < sign * end]
    if not inside:
        return (timeline,)
    lengths, starts = integrator.stepper.flow.fractions.data.reshape(2, -1)
    if starts.min() < -1e-12 or (starts + lengths).max() > 1.0 + 1e-12:
        raise MethodError(
            f"method {integrator.method.name!r} goes beyond its steps on the way, and so beyond "
            "breaks: take a composition that does not, such as 'suzuki-4'"
        )
    stretches, adaptive = [], integrator.method.adaptive
    for k, (start, until) in enumerate(pairwise([begin, *inside, end])):
        gap = sign * GAP * math.ulp(max(start, until, key=abs))
        start = math.nextafter(start, sign * math.inf) if k else start
        until = until if k == len(inside) else until - gap
        steps, met = counted(until - start, abs(halved or timeline.h))
        steps = max(steps + (not met), least) * (2 if halved else 1)
        h = timeline.h if adaptive else (until - start) / steps
        h = within(start, h, until) if steps == 1 else h
        stretches.append(Timeline(start, h, None if adaptive else steps, 0.0, until, None))
    return tuple(stretches)
