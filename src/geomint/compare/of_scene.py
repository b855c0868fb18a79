"""A comparison as a scene asks for it: how long it takes, what it compiles, and itself."""

import math
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

from ..errors import Gathered, GeomintError
from ..methods import Method, find_method
from ..plan import Estimate, estimate, make_plan
from ..plan.duration import steps_of
from ..plan.fitting import representation_for
from ..plan.tolerance import wanted_step
from ..problems.evaluate import value
from ..run.progress import HOUR
from ..run.solve import solve
from ..scene.scene import Scene
from .endpoint import MOST_EXTENDED_STEPS, Endpoint
from .ladder import STEP_FACTORS, ladder
from .peers import PEERS
from .point import timed_runs
from .runs import Comparison, compare

EXTENDED, COARSEST = 300.0, max(STEP_FACTORS)  # times gauss-8; times the default step
LONGEST = 1.0  # seconds of a run: those that do not converge turn to another kernel early


def compare_scene(scene: Scene, report: Callable[[str], None] = lambda text: None) -> Comparison:
    """Compare methods on a scene, as its section ``[compare]`` says.

    The scene's own method, if it is one of them, runs with its options and about its step, or the one
    that meets its tolerance; all run in the representation that the scene asks for, if it does. See
    `compare` for the rest.
    """
    asked = scene.content.compare
    return compare(
        scene.model,
        scene.content.time.end,
        methods_of(scene),
        steps=asked.steps,
        first_steps=first_steps(scene),
        representation=scene.content.integrate.representation,
        repeats=asked.repeats,
        reference=asked.reference or "auto",
        peers=PEERS if asked.peers else (),
        report=report,
    )


def methods_of(scene: Scene) -> list[str | Method]:
    """Return the methods of a comparison: the scene's own one with its options, alone by default."""
    own, names = scene.content.integrate.method, scene.content.compare.methods
    return [scene.method if name == own else name for name in names or [own]]


def first_steps(scene: Scene) -> dict[str, float]:
    """Return the step of the scene's own method, if it has one in the scene's own representation."""
    integrate, step = scene.content.integrate, scene.content.integrate.step
    if integrate.tolerance is not None and scene.method.needs in scene.problem.forms:
        step = wanted_step(scene, scene.problem, scene.state)[1]
    return {} if step is None else {scene.method.name: step}


def comparison_time(scene: Scene) -> Estimate:
    """Return how long the reference and the first point of every method take.

    Further points are left out by `geomint.compare.runs.compare` where the first lets expect that they
    take long. A reference in double-double arithmetic takes about 300 times the time of gauss-8 at its
    default step (200 to 1500 were measured); where there is an exact flow, next to nothing.
    """
    asked, reference = scene.content.compare, scene.content.compare.reference or "auto"
    bare = scene.changed(save={"every": None, "t_eval": None}).changed_observation([])
    exact = any(p.make_exact is not None for p in scene.model.problems.values())
    longest = max(asked.steps) if asked.steps else None
    parts: list[tuple[str, float | None, float]] = []
    if reference != "exact":
        parts.append(("gauss-8", None, EXTENDED))
    times = 1.0 / (COARSEST if longest is None else 1.0)
    parts += [(find_method(m).name, longest, times) for m in methods_of(scene)]
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
        if times != EXTENDED and once > 0.0:
            runs, enough = timed_runs(asked.repeats)
            once *= min(runs, max(1, math.ceil(enough / once)))
        seconds += once
    return Estimate(seconds, measured)


def warming(scene: Scene, at: str) -> list[Callable[[], object]]:
    """Return tasks for the methods that are still to come.

    In their order where the comparison is at a reference in double-double arithmetic, which takes as
    long as some of them; else the last one first, as the next one is being compiled already.

    Parameters
    ----------
    at : str
        What has been reported last.
    """
    methods = methods_of(scene)
    tasks: list[Callable[[], object]] = [partial(warm_method, scene, method) for method in methods]
    if "double-double" in at:
        return tasks
    begun = [i + 1 for i, m in enumerate(methods) if at.startswith(f"{find_method(m).name}, ")]
    return tasks[max(begun, default=0) :][::-1]


def warm_method(scene: Scene, method: str | Method) -> None:
    """Compile what the runs of one method need: at its longest step, and of its drifts."""
    chosen, end = find_method(method), scene.content.time.end
    name, problem = representation_for(
        scene.model, chosen, end, scene.content.integrate.representation
    )
    y0, own_end = scene.model.states[name], next(iter(end.values()))
    base = first_steps(scene).get(chosen.name)
    variant, step = ladder(chosen, problem, y0, None, base, own_end)[0]
    t_end = end.get("t_end") or _physical_end(scene, own_end)
    timed = Endpoint(scene.problem, end, t_end, {}).end_for(problem)
    watched = {"t_end": t_end, "observe": [*problem.invariants, *problem.constraints]}
    with Gathered(quiet=True):
        for options in (timed, watched):
            with suppress(GeomintError):  # compiled by then
                run = partial(solve, problem, y0, method=variant, step=step, progress=False)
                run(callback=_over(time.perf_counter() + LONGEST), **options)


def _over(end: float) -> Callable[[Any], bool]:
    """Return what ends a run at a time of the clock."""
    return lambda told: time.perf_counter() > end


def _physical_end(scene: Scene, own_end: float) -> float:
    """Return about where the comparison ends in physical time."""
    own = scene.problem
    return own_end if own.clock is None else own_end * value(own, own.clock, scene.state)
