"""What a comparison compiles, as tasks of a process that compiles beside the one that compares."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

from ..errors import GeomintError
from ..methods import Method, find_method
from ..plan.fitting import representation_for
from ..problems.evaluate import value
from ..problems.problem import Problem
from ..run.solve import solve
from ..scene import Scene
from .ladder import ladder
from .of_scene import end_of, first_steps, methods_of

__all__ = ["warm_method", "warming"]

LONGEST = 1.0  # seconds of a run: those that do not converge turn to another kernel early


def warming(scene: Scene, names: list[str], at: str) -> list[Callable[[], object]]:
    """Return tasks for the methods that are still to come.

    In their order where the comparison is at a reference in double-double arithmetic, which takes as
    long as some of them; else the last one first, as the next one is being compiled already.

    Parameters
    ----------
    at : str
        What has been reported last.
    """
    tasks: list[Callable[[], object]] = []
    tasks += [partial(warm_method, scene, method) for method in methods_of(scene, names)]
    if "double-double" in at:
        return tasks
    begun = [i + 1 for i, name in enumerate(names) if at.startswith(f"{name}, ")]
    return tasks[max(begun, default=0) :][::-1]


def warm_method(scene: Scene, method: str | Method) -> None:
    """Compile what the runs of one method need: at its longest step, and of its drifts."""
    chosen, end = find_method(method), end_of(scene)
    name, problem = representation_for(
        scene.model, chosen, end, scene.content.integrate.representation
    )
    y0, own_end = scene.model.states[name], next(iter(end.values()))
    base = first_steps(scene).get(chosen.name)
    variant, step = ladder(chosen, problem, y0, None, base, own_end)[0]
    own = next(iter(scene.model.problems.values()))
    physical = {"t_end": end.get("t_end") or _physical_end(own, scene, own_end)}
    same = problem is own and "tau_end" in end
    watched = [*problem.invariants, *problem.constraints]
    timed: dict[str, Any] = {**end, "clock": False} if same else physical
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for options in (timed, {**physical, "observe": watched}):
            with suppress(GeomintError):  # compiled by then
                run = partial(solve, problem, y0, method=variant, step=step, progress=False)
                run(callback=_over(time.perf_counter() + LONGEST), **options)


def _over(end: float) -> Callable[[Any], bool]:
    """Return what ends a run at a time of the clock."""
    return lambda told: time.perf_counter() > end


def _physical_end(own: Problem, scene: Scene, own_end: float) -> float:
    """Return about where the comparison ends in physical time."""
    if own.clock is None:
        return own_end
    return own_end * value(own, own.clock, scene.model.states[next(iter(scene.model.problems))])
