"""When a run ends and how long its steps are."""

import math
from typing import Any, NamedTuple

import numpy as np

from ..arguments import MOST_NUMBERS, Array, Integers, as_array, finite, positive
from ..errors import DomainError
from ..methods.method import Method
from ..methods.partial import rounding
from ..methods.stepper import GAP
from ..problems.evaluate import Rate, rates_of, value_of
from ..problems.problem import Problem
from .restart import Restart

MOST_STEPS = 2**53  # beyond, i h is not distinct for every i


class Timeline(NamedTuple):
    """Steps of one length, and what is left for a last partial step.

    Attributes
    ----------
    start : float
        The problem's own time where steps are counted from.
    h : float
        Signed step in the problem's own time; the first one of an adaptive method.
    steps : int or None
        Whole steps; None where physical time or an adaptive method decides, on the way.
    remainder : float
        Length of the last partial step in the problem's own time; 0 for none.
    own_end : float or None
        End in the problem's own time.
    physical_end : float or None
        End in physical time, where that was asked for and is not the problem's own.
    """

    start: float
    h: float
    steps: int | None
    remainder: float
    own_end: float | None
    physical_end: float | None

    @property
    def expected(self) -> float:
        """About how many steps there will be: as many as the first one makes."""
        end = self.own_end if self.own_end is not None else self.physical_end
        return abs(((end or 0.0) - self.start) / self.h)

    def met(self, times: Array, steps: Integers) -> Array:
        """Return times after so many steps, that of the last whole step being the end, if it is."""
        whole = self.own_end is not None and self.remainder == 0.0
        if whole and len(steps) and steps[-1] == self.steps:
            times[-1] = self.own_end
        return times


def plan_timeline(
    problem: Problem,
    method: Method,
    y0: Array,
    t_end: Any = None,
    tau_end: Any = None,
    step: Any = None,
    t0: float = 0.0,
    restart: Restart | None = None,
    compiled: bool = False,
    breaks: tuple[float, ...] = (),
) -> Timeline:
    """Return the timeline of a run from physical time `t0`, or raise `DomainError`.

    Exactly one of `t_end` (physical time) and `tau_end` (only for a problem in τ, from 0 on) must be
    given; an end before the beginning integrates backwards, one at it takes no steps. With a `restart`
    the run goes on there.
    `compiled`: whether the default step is found by compiled code. `breaks` are in the order of the
    run, and may lie beyond it.
    """
    begin, end, own = ending(problem, t_end, tau_end, t0, restart is None)
    if restart is not None:
        return _resumed(restart, problem, method, end, own)
    start, span = begin if own else 0.0, end - begin
    size = None if step is None else positive("step", step)
    if size is None:
        known = rates_of(problem, y0, compiled)
        rate_at = within_run(known, breaks, span, end if own else None)
        size = method.default_step(problem, y0, span or math.inf, start, rate_at)
        size = min(size, abs(span)) if own and span else size
    h = math.copysign(size, span)
    if not method.adaptive:
        rate = 1.0
        if not own and problem.clock is not None:
            rate = abs(value_of(problem, problem.clock, y0, compiled)(y0, 0.0))
        _check_count(rate, span, size, step is not None)
        if own and span:
            check_advance(size, max(abs(start), abs(end)))
    if not span:
        return Timeline(start, h, 0, 0.0, start, None)
    return _timeline(start, h, end, own, method, True)


def _timeline(
    start: float, h: float, end: float, own: bool, method: Method, adjusted: bool
) -> Timeline:
    """Return the steps to an end, `adjusted` to meet it where that takes no more than rounding."""
    if not own or method.adaptive:
        return Timeline(start, h, None, 0.0, end if own else None, None if own else end)
    span = end - start
    steps, met = counted(span, abs(h))
    if met and adjusted:
        h = span / steps if steps > 1 else within(start, span, end)
    if met and (adjusted or span / steps == h):
        return Timeline(start, h, steps, 0.0, end, None)
    steps -= met and abs(steps * h) > abs(span)
    return Timeline(start, h, steps, within(start + steps * h, span - steps * h, end), end, None)


def within(begin: float, length: float, end: float) -> float:
    """Return a length, less by roundings if `begin` and it add up to more than the end."""
    if (begin + length - end) * length > 0.0:
        length = end - begin
    while (begin + length - end) * length > 0.0:
        length = math.nextafter(length, 0.0)
    return length


def ending(
    problem: Problem, t_end: Any, tau_end: Any, t0: float = 0.0, new: bool = True
) -> tuple[float, float, bool]:
    """Return where a run begins and ends, and whether that is the problem's own time.

    Raises
    ------
    DomainError
        Unless exactly one end is given, and a `new` run has a length that is a number.
    """
    if (t_end is None) == (tau_end is None):
        raise DomainError("t_end, tau_end", (t_end, tau_end), "exactly one of them")
    if tau_end is not None and problem.time != "tau":
        raise DomainError("tau_end", tau_end, f"t_end: {problem.name!r} is in physical time")
    name, begin = ("t_end", t0) if tau_end is None else ("tau_end", 0.0)
    end = finite(name, t_end if tau_end is None else tau_end)
    if new and not math.isfinite(end - begin):
        raise DomainError(name, end, f"a time at a finite distance of {begin:g}")
    return begin, end, problem.time == "t" or tau_end is not None


def within_run(rate_at: Rate, breaks: tuple[float, ...], sign: float, end: float | None) -> Rate:
    """Return rates that are behind the first break, and the end, what they are before it."""
    lasts = [b - math.copysign(GAP * math.ulp(b), sign) for b in breaks[:1]]
    lasts += [] if end is None else [end]
    if not lasts:
        return rate_at
    first = min if sign >= 0.0 else max

    def known(problem: Problem, y: Any, t: float) -> Any:
        return rate_at(problem, y, first(t, *lasts))

    return known


def counted(span: float, size: float) -> tuple[int, bool]:
    """Return how many whole steps fit, and whether they fill the span: to 1e-9, which is rounding."""
    count = abs(span) / size
    near = abs(count - round(count)) <= 1e-9 * max(count, 1.0)
    steps = round(count) if near else int(count)
    return steps, near and steps >= 1


def _resumed(restart: Restart, problem: Problem, method: Method, end: float, own: bool) -> Timeline:
    """Return the timeline of a run that goes on, with the steps it had: no step is adjusted."""
    start, h = restart.start, restart.h
    reached = reached_by(restart, problem, method, own)
    if own and restart.seen is not None and (restart.seen - reached) * h > 0.0:
        reached = restart.seen  # an event within the step that comes next has ended the run
    if not (end - reached) * h > 0.0:
        name = "t_end" if problem.time == "t" or not own else "tau_end"
        raise DomainError(name, end, f"a time beyond {reached:.9g}, where the run goes on")
    if own and not method.adaptive:
        check_advance(h, end)
    return _timeline(start, h, end, own, method, False)


def reached_by(restart: Restart, problem: Problem, method: Method, own: bool) -> float:
    """Return the time from which steps go on."""
    if not own or method.adaptive:  # the clock's row, and then that of time
        return float(restart.memory[problem.rows + (own and restart.clock)])
    return restart.start + restart.done * restart.h


def check_advance(h: float, time: float) -> None:
    """Raise `DomainError` for steps that are less than a rounding of the times that they lead to."""
    if not abs(h) >= math.ulp(time):
        least = f"at least {math.ulp(time):.3g}, the rounding of times near {time:.9g}"
        raise DomainError("step", h, least if math.isfinite(time) else "one to a finite time")


def _check_count(rate: float, span: float, size: float, given: bool) -> None:
    """Raise `DomainError` for more than 2⁵³ steps; over physical time by the clock's rate at y0.

    A rate that is 0 there, or no number, says nothing: the run will.
    """
    if not (rate > 0.0 and abs(span) / rate > MOST_STEPS * size):
        return
    if not given:
        expected = f"one within 2⁵³ steps of the default {size:.3g}: give a step"
        raise DomainError("end", span, expected)
    raise DomainError("step", size, f"a step that spans {span:g} in fewer than 2⁵³ steps")


def evaluation_times(
    given: Any, problem: Problem, timeline: Timeline, begin: float = 0.0, name: str = "t_eval"
) -> Array:
    """Return the times at which states are wanted, none for None, or raise `DomainError`.

    ``t_eval`` are physical times, ``tau_eval`` those of a problem in τ. They must be in the order of
    the run, and within it as far as that can be known; it begins at `begin`.
    """
    if given is None:
        return np.zeros(0)
    if name == "tau_eval" and problem.time == "t":
        raise DomainError(name, given, f"t_eval: {problem.name!r} is in physical time")
    times = np.atleast_1d(as_array(name, given))
    if len(times) * problem.rows > MOST_NUMBERS:
        raise DomainError(name, given, f"at most {MOST_NUMBERS // problem.rows} times")
    forward = np.sign(timeline.h) * times
    if times.ndim != 1 or not np.isfinite(times).all() or (np.diff(forward) < 0).any():
        raise DomainError(name, given, "finite times in the order of the run")
    if not len(times):
        raise DomainError(name, given, "at least one time, or None for the last state alone")
    # With an end in the other of both times that in this one is only known afterwards.
    own = problem.time == "t" or name == "tau_eval"
    end = timeline.own_end if own else timeline.physical_end
    last = math.copysign(math.inf, timeline.h) if end is None else end
    met = met_by_rounding(times, begin, last)
    if met is None:
        expected = f"times from {begin:g} to {end if end is not None else '…'}"
        raise DomainError(name, given, expected)
    return met


def met_by_rounding(times: Array, begin: float, end: float) -> Array | None:
    """Return times within a run, an end of it for those that are some roundings outside; or None."""
    low, high = sorted((begin, end))
    inside = np.clip(times, low, high)
    near = np.abs(times - inside) <= np.where(times == inside, 0.0, rounding(inside))
    return inside if near.all() else None  # no NaN is near
