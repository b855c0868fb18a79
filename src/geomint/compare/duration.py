"""How long a comparison takes."""

from __future__ import annotations

import math
from collections.abc import Iterable

from ..errors import GeomintError
from ..plan import Estimate, estimate, make_plan
from ..plan.duration import steps_of
from ..run.progress import HOUR
from ..scene.scene import Scene
from .endpoint import MOST_EXTENDED_STEPS
from .ladder import STEP_FACTORS
from .point import timed_runs

__all__ = ["comparison_time"]

EXTENDED, COARSEST = 300.0, max(STEP_FACTORS)  # times gauss-8; times the default step


def comparison_time(
    scene: Scene,
    methods: Iterable[str],
    steps: list[float] | None,
    repeats: int | None,
    reference: str,
) -> Estimate:
    """Return how long the reference and the first point of every method take.

    Further points are left out by `geomint.compare.runs.compare` where the first lets expect that they
    take long. A reference in double-double arithmetic takes about 300 times the time of gauss-8 at its
    default step (200 to 1500 were measured); where there is an exact flow, next to nothing.
    """
    bare = scene.changed(save={"every": None, "t_eval": None}).changed_observation([])
    exact = any(p.make_exact is not None for p in scene.model.problems.values())
    parts: list[tuple[str, float | None, float]] = []
    if reference != "exact":
        parts.append(("gauss-8", None, EXTENDED))
    longest = max(steps) if steps else None
    parts += [(m, longest, 1.0 / (COARSEST if steps is None else 1.0)) for m in methods]
    seconds, measured = 0.0, False
    for name, step, times in parts:
        try:
            plan = make_plan(bare.changed_integration(name, step))
        except GeomintError:
            continue  # the comparison reports it
        few = steps_of(plan) <= MOST_EXTENDED_STEPS
        if times == EXTENDED and reference == "auto" and exact and not few:
            continue
        found = estimate(plan, HOUR / times)
        measured = measured or found.measured
        once = times * found.seconds if math.isfinite(found.seconds) else 0.0
        seconds += once if times == EXTENDED else _together(once, repeats)
    return Estimate(seconds, measured)


def _together(once: float, repeats: int | None) -> float:
    """Return how long the timed runs of a point take, if one takes so long."""
    runs, enough = timed_runs(repeats)
    return once * min(runs, max(1, math.ceil(enough / once))) if once > 0.0 else 0.0
