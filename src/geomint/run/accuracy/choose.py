"""From a tolerance to a method with its options, and a step."""

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import DomainError
from ...methods import Method
from ...methods.adaptive import LARGEST_RTOL, Adaptive
from ...methods.stepper import Stepper
from ..promise import AIM, Setting
from .accuracy import Accuracy
from .adaptive_stretch import adaptive_stretch, at_tolerance
from .search import Search, Trial
from .stretch import Motion, Stretch, extrapolated, stretch

MOST_TURNS = 1e100  # what is made of them is finite then; runs have fewer
FARTHEST = 1e30  # first steps of a run: trials make none so much longer
TRIED = 5.0  # characteristic times up to a break, at least, for trials
TURNS, PART = 10.0, 1.0 / 50.0  # of a stretch: characteristic times, and part of a long run
MORE_TURNS = 3.2  # for each order of a symmetric method: high ones err where a motion is fastest
LONG_TURNS, LONG_PART = 40.0, 1.0 / 12.0  # where errors grow faster than time
FIRST = 2.0, 0.25  # a first trial: (2 + p/4) (error of a characteristic time)^(1/p) of that time
IMPLICIT = 1.2  # of that time: a first implicit step, at most
ROUNDING = 0.2  # see `rounding_floor`
BIAS = 0.1  # see `with_iteration_tolerance`
FASTER = 2.0  # times: motions that need so much shorter steps than the beginning says turn faster
LARGE = 32  # numbers of a state whose trials cost more than all else
SHORT_PART = 0.25  # of a short run: what a stretch is at most, beyond `TURNS`
NEAR_ADAPTIVE = 4.0  # see `Search.near`: errors are a rough power of rtol only
BITS, LEAST_BITS, MOST_BITS = 4, 24, 56  # tolerances of iterations: 2^-24, 2^-28, … 2^-56


@dataclass(eq=False)
class Wanted:
    """A motion, the error that is wanted at its end, and its characteristic time at y0.

    Attributes
    ----------
    room : float
        How far the first break is, up to which trials go.
    clock : bool
        Whether physical time goes on beside the run.
    watched : bool
        Whether anything is observed: the iteration of an implicit method goes on to rounding then, for
        what it leaves is a drift.
    reason : str
        Why the method, where nobody has named one.
    """

    motion: Motion
    tolerance: float
    time: float
    room: float
    clock: bool
    watched: bool
    reason: str

    @property
    def turns(self) -> float:
        """Characteristic times of the run; 1 at least."""
        return min(max(abs(self.motion.span) / self.time, 1.0), MOST_TURNS)

    @property
    def goal(self) -> float:
        """What steps shall make of the error: not less than roundings do."""
        return AIM * max(self.tolerance, rounding_floor(self.turns, 1.0))

    def stepper(self, method: Method, step: float) -> Stepper:
        """Return what takes the steps of trials: each begins it anew."""
        m = self.motion
        flow = method.on(m.problem, m.y0, m.begin, self.clock, m.compiled)
        stepper = flow.begin(m.y0, m.begin, math.copysign(step, m.span))
        stepper.prepare()
        return stepper

    def length(self, turns: float, part: float) -> float:
        """Return the length of a stretch."""
        whole = abs(self.motion.span)
        return min(whole, 0.5 * self.room, max(turns * self.time, part * whole))

    @property
    def untried(self) -> bool:
        """Whether a break comes too early for trials: then a second run alone tells errors."""
        return self.room < min(TRIED * self.time, abs(self.motion.span))

    def setting(
        self,
        method: Method,
        step: float | None,
        expected: float,
        floor: float,
        search: Search,
        **more: Any,
    ) -> Setting:
        """Return what was chosen; where the method was, another one may be."""
        accuracy = Accuracy(self.tolerance, expected, floor, search.record, self.reason)
        return Setting(
            method,
            step,
            self.tolerance,
            each=False,
            free=bool(self.reason),
            state=self.motion.y0,
            accuracy=accuracy,
            **more,
        )

    def error(self, found: Stretch | None, method: Method) -> float | None:
        """Return the error at the end of the run that follows from a stretch."""
        if found is None:
            return None
        return extrapolated(found.times, found.errors, self.span(found), method.symmetric)

    def span(self, found: Stretch) -> float:
        """Return the length of the run in own time, as a stretch shows it."""
        motion = self.motion
        return abs(motion.span if motion.physical is None else motion.physical / found.rate)


def choose(wanted: Wanted, method: Method) -> Setting:
    """Return how a method meets a tolerance at the end of a run."""
    if isinstance(method, Adaptive):
        return _local_tolerance(wanted, method)
    return _step(wanted, method)


def _step(wanted: Wanted, method: Method) -> Setting:
    """Return the step of a method with which a run errs by what is wanted."""
    motion, time, p = wanted.motion, wanted.time, method.order
    options, most = method.options, 0.5 * abs(motion.span) or abs(motion.span)
    implicit = "max_iterations" in options
    first = (FIRST[0] + FIRST[1] * p) * (wanted.goal / wanted.turns) ** (1.0 / p)
    first = min(time * (min(first, IMPLICIT) if implicit else first), most)
    if first * FARTHEST < abs(motion.span):
        raise DomainError("end", motion.span, f"one within 2⁵³ steps of about {first:.3g}")
    most = min(most, 0.5 * wanted.room)
    own = method
    if not wanted.watched:
        own = with_iteration_tolerance(
            method, wanted.tolerance, wanted.turns, abs(motion.span) / first
        )

    def trials(method: Method) -> Callable[[float, float], Trial]:
        stepper = wanted.stepper(method, first)

        def tried(length: float, step: float) -> Trial:
            found = stretch(stepper, motion, p, step, length)
            return Trial(step, wanted.error(found, method), found)

        return tried

    # Of large states trials cost more than all else, and much moves at once: less time shows as much.
    less = min(1.0, math.sqrt(LARGE / motion.problem.rows))
    turns = TURNS + (MORE_TURNS * p if method.symmetric else 0.0)
    turns = max(less * TURNS, min(turns, less * SHORT_PART * wanted.turns))
    short, other = wanted.length(turns, PART), options.get("iteration") == "auto"
    for iteration in ("fixed-point", "auto") if other else ("",):
        tried = trials(varied(own, "iteration", iteration) if iteration else own)
        search = Search(functools.partial(tried, short), wanted.goal, p, most, implicit)
        step, expected = (first, wanted.goal) if wanted.untried else search.run(first)
        if not search.stiff(step, expected):
            break
    floor = rounding_floor(wanted.turns, step / time)
    faster = first / step
    if faster > FASTER and not wanted.watched:
        turns, steps = faster * wanted.turns, abs(motion.span) / step
        own = with_iteration_tolerance(method, wanted.tolerance, turns, steps)
    large = motion.problem.rows >= LARGE and not wanted.watched  # watchers take steps of their own
    shorten = large and iteration == "fixed-point"
    setting = wanted.setting(own, step, expected, floor, search, given=method, turning=not shorten)
    found = next((trial.stretch for trial in reversed(search.trials) if trial.stretch), None)
    if found is None:  # a step that serves was not found
        return setting._replace(iterations=math.inf, states=motion.y0[np.newaxis])
    iterations, states = found.work * wanted.span(found), found.states[:, : motion.problem.rows]
    return setting._replace(iterations=iterations, states=states)


def _local_tolerance(wanted: Wanted, method: Adaptive) -> Setting:
    """Return the local tolerance of an adaptive method with which a run errs by what is wanted."""
    power = method.order / (method.base.estimate_order or method.order)

    def tried(rtol: float, length: float) -> Trial:
        found = adaptive_stretch(method, wanted.motion, rtol, length, wanted.clock)
        return Trial(rtol, wanted.error(found, method), found)

    short, long = wanted.length(TURNS, PART), wanted.length(LONG_TURNS, LONG_PART)
    search = Search(
        lambda rtol: tried(rtol, short), wanted.goal, power, LARGEST_RTOL, False, NEAR_ADAPTIVE
    )
    first = wanted.goal / wanted.turns
    rtol, expected = (first, wanted.goal) if wanted.untried else search.run(first)
    if long > short and math.isfinite(expected):
        rtol, expected = search.corrected(rtol, expected, lambda rtol: tried(rtol, long))
    own, floor = at_tolerance(method, rtol), rounding_floor(wanted.turns, 1.0)
    return wanted.setting(own, None, expected, floor, search, given=method, turning=True)


def rounding_floor(turns: float, step: float) -> float:
    """Return about what roundings make of a regular motion: a walk of frequencies, summed to phases.

    Every step of h changes the state by a rounding of its increment, ε h/T of it with T its
    characteristic time, and frequencies alike; after N = turns/step steps phases are off by √N of that
    times `turns`. The factor is measured (`benchmarks/tolerance.py`).
    """
    return ROUNDING * 2.0**-52 * turns * math.sqrt(turns * step)


def with_iteration_tolerance(
    method: Method, tolerance: float, turns: float, steps: float
) -> Method:
    """Return the method with an iteration that stops where what is left does not count.

    What an iteration leaves is often on the same side: N steps of error δ drive frequencies away by
    N δ, and phases by N δ times the turns. Of that a part `BIAS` was measured. What a user has chosen
    stays.
    """
    if method.options.get("iteration_tolerance") != 0.0:
        return method
    allowed = AIM * tolerance / (BIAS * steps * turns)
    if not allowed >= 2.0**-MOST_BITS:
        return method
    bits = max(BITS * math.ceil(-math.log2(allowed) / BITS), LEAST_BITS)
    return varied(method, "iteration_tolerance", 2.0**-bits)


@functools.lru_cache(maxsize=256)
def varied(method: Method, option: str, value: Any) -> Method:
    """Return a method with another value of an option; made once for all runs."""
    return method.with_options(**{option: value})
