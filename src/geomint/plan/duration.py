"""How long a plan takes: a bound that costs nothing, and a trial where that is long.

The bound is steps × a generous cost of a step by the sizes of the problem alone: 1.4 to 3000 times what
runs of the built-in scenes take, by rk-4, rattle-4, gauss-16 and others. Where it is below an hour,
nobody needs to know better. Beyond, the plan is carried out over the first tenths of a second,
compiled, with all that it watches.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from ..errors import Gathered, StepError
from ..problems.evaluate import value
from ..run.progress import HOUR, time_in_words
from ..run.solution import Solution
from .plan import Plan

TRIAL = 0.1  # seconds
FIRST_TRIAL, FASTER = 64, 8  # steps, and how many times more the next time
EVALUATIONS = 300  # in a step: of long compositions of implicit methods
OPERATION, CALL = 1e-9, 2e-8  # seconds


@dataclass(frozen=True)
class Estimate:
    """Seconds that a plan will take: at most, or as measured in a trial."""

    seconds: float
    measured: bool

    def __str__(self) -> str:
        if not math.isfinite(self.seconds):
            return "not known"
        return f"{'about' if self.measured else 'at most'} {time_in_words(self.seconds)}"


def estimate(plan: Plan, enough: float = HOUR) -> Estimate:
    """Return how long a plan takes; measured if it may be longer than `enough` seconds.

    Of so few steps that a trial would be the run itself, the bound.
    """
    most = _most(plan)
    if most <= enough or steps_of(plan) <= FIRST_TRIAL:
        return Estimate(most, False)
    found = _trial(plan)
    return Estimate(most, False) if found is None else Estimate(found, True)


def expected_time(plans: Iterable[Plan]) -> Estimate:
    """Return how long plans take one after the other; where one is not known, what is known."""
    found = [e for e in map(estimate, plans) if math.isfinite(e.seconds)]
    return Estimate(sum(e.seconds for e in found), any(e.measured for e in found))


def steps_of(plan: Plan) -> float:
    """Return the number of steps, nearly; of an adaptive method as many as its first step makes."""
    known = plan.steps.chosen
    if known is not None:
        return float(known) + 1.0
    distance = _own_distance(plan)
    return distance / abs(plan.timeline.h)


def _own_distance(plan: Plan) -> float:
    """Return how far the end is in the problem's own time; by the rate at the start, or infinity."""
    timeline, clock = plan.timeline, plan.problem.clock
    if timeline.physical_end is None or clock is None:
        return abs(timeline.own_end or 0.0)
    rate = value(plan.problem, clock, plan.state)
    return abs(timeline.physical_end) / rate if rate > 0.0 else math.inf


def _most(plan: Plan) -> float:
    """Return a generous bound of the seconds."""
    problem, every = plan.problem, plan.scene.content.observe.every
    once = CALL + OPERATION * (problem.rows**2 + len(problem.params))
    step = EVALUATIONS * once
    if plan.scene.method.needs == "action" and problem.action is not None:
        step += EVALUATIONS * OPERATION * 10.0 * (2.0 * problem.action.group.algebra_rows) ** 1.5
    steps = steps_of(plan)
    seconds = steps * step
    for watcher in plan.observed.values():
        seen = min(steps, watcher.steps or math.inf) if watcher.sees_all else steps / every
        seconds += seen * step * watcher.cost(problem)
    return seconds


def _trial(plan: Plan) -> float | None:
    """Return the seconds by a short run, or None if that fails or the way is not known."""
    h, distance = plan.timeline.h, _own_distance(plan)
    if not math.isfinite(distance):
        return None
    count = FIRST_TRIAL
    while True:
        length = min(count * abs(h), distance)
        try:
            solution = _short_run(plan, math.copysign(length, h))
        except StepError:
            return None
        seconds = solution.run_seconds + solution.watching_seconds
        if seconds > TRIAL or length == distance or not solution.success:
            break
        count *= FASTER
    own = abs(float(solution.tau[-1]))
    if plan.timeline.physical_end is not None and solution.t[-1] != 0.0:
        return seconds * abs(plan.timeline.physical_end / float(solution.t[-1]))
    return seconds * distance / own if own > 0.0 else None


def _short_run(plan: Plan, end: float) -> Solution:
    """Run to an end in the problem's own time, with what is watched all the way."""
    watched = {name: watcher for name, watcher in plan.observed.items() if watcher.steps is None}
    every = plan.scene.content.observe.every if watched else 1
    with Gathered(quiet=True):  # the run itself will say so
        return plan.run_to(end, observe=watched, observe_every=every, clock=plan.clock.chosen)
