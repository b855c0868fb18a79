"""The first turns of the motion of a scene, for the pictures with which its drift report opens."""

from contextlib import suppress
from dataclasses import dataclass

from ..errors import Gathered, GeomintError, StepError
from ..kernels.compiling.sameness import Compared
from ..problems.problem import Problem
from ..problems.time_scale import characteristic_time
from ..run.solution import Solution
from ..run.stretch import Stretch, stretch_of
from .plan import Plan

TIMES = 60.0  # characteristic times: some ten turns
MOST_STEPS = 20_000


@dataclass(frozen=True, eq=False)
class FirstTurns(Compared):
    """A motion from its initial state on, as a plan's method takes it.

    Attributes
    ----------
    problem : Problem
        Of the states.
    method : str
    stretch : Stretch
        In the problem's own time.
    """

    problem: Problem
    method: str
    stretch: Stretch


def first_turns(plan: Plan) -> FirstTurns | None:
    """Return the first states of the run of a plan; None where it gets nowhere.

    By the same method with the same step as the run, and the same compiled code. Some thousand steps
    cost nothing beside those of a drift report.
    """
    step, problem = plan.timeline.h, plan.problem
    with suppress(GeomintError, ArithmeticError), Gathered(quiet=True):  # said of the run itself
        length = TIMES * characteristic_time(problem, plan.state, step)
        if not plan.method.chosen.adaptive:
            length = min(length, MOST_STEPS * abs(step))
        end = plan.timeline.own_end
        if end is not None:
            length = min(length, abs(end))
        signed = length if step > 0.0 else -length
        solution = _short_run(plan, signed)
        stretch = stretch_of(solution)
        lift, asked = plan.route.lift, problem
        if lift is not None:
            asked = plan.scene.model.problems[plan.route.asked]
            stretch = stretch.lifted(lift)
        return FirstTurns(asked, plan.method.chosen.name, stretch)
    return None


def _short_run(plan: Plan, end: float) -> Solution:
    """Return the run to an own time, or as far as it gets."""
    clock = False if plan.problem.time == "tau" else None
    try:
        return plan.run_to(end, dense=True, clock=clock, progress=False)
    except StepError as error:
        if not isinstance(error.partial, Solution):
            raise
        return error.partial
