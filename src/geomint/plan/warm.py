"""What a scene's commands compile, compiled ahead of them: they find it in the cache."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial

from ..errors import Gathered, StepError
from ..scene.scene import Scene
from .first_turns import first_turns
from .plan import Plan, make_plan
from .several import expected_plans


def warm(scene: Scene, methods: Iterable[str], progress: bool | None = None) -> None:
    """Compile what ``geomint run`` and ``geomint drift`` of a scene run, and nothing else.

    Each plan is carried out as far as its first steps. A method without a plan is left out.

    Raises
    ------
    GeomintError
        As `expected_plans`, and `make_plan`.
    """
    drifting = scene.for_drift()
    plans = [p for p in expected_plans(drifting, methods).values() if isinstance(p, Plan)]
    for plan in (*plans, make_plan(scene)):
        warm_plan(plan, progress)


def warm_plan(plan: Plan, progress: bool | None = False) -> None:
    """Compile what carrying out a plan runs, and the pictures of a drift report."""
    with Gathered(quiet=True):  # the run itself will say so
        try:
            _ = plan.solve(progress, callback=lambda told: True).local_error
        except StepError:  # compiled by then
            return
        if plan.purpose == "drift":
            first_turns(plan)


def warming(plans: Sequence[Plan]) -> list[Callable[[], object]]:
    """Return the plans as tasks of a process that compiles beside this one: the last one first."""
    return [partial(warm_plan, plan) for plan in reversed(plans)]
