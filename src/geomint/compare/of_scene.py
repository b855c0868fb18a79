"""A comparison as a scene asks for it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from ..plan.tolerance import wanted_step
from .endpoint import Source
from .runs import Comparison, compare

if TYPE_CHECKING:
    from ..scene import Scene

__all__ = ["compare_scene"]


def compare_scene(
    scene: Scene,
    methods: list[str],
    steps: list[float] | None = None,
    repeats: int = 3,
    reference: Source = "auto",
    peers: Iterable[str] = (),
    report: Callable[[str], None] = lambda text: None,
) -> Comparison:
    """Compare methods on a scene.

    The scene's own method, if it is one of them, runs with its options and about its step, or the one
    that meets its tolerance; all run in the representation that the scene asks for, if it does. See
    `compare` for the rest.
    """
    time, integrate = scene.content.time, scene.content.integrate
    end = {"tau_end": time.tau_end} if time.tau_end is not None else {"t_end": time.t_end}
    return compare(
        scene.model,
        {key: value for key, value in end.items() if value is not None},
        [scene.method if name == integrate.method else name for name in methods],
        steps=steps,
        first_steps=_first_steps(scene),
        representation=integrate.representation,
        repeats=repeats,
        reference=reference,
        peers=peers,
        report=report,
    )


def _first_steps(scene: Scene) -> dict[str, float]:
    """Return the step of the scene's own method, if it has one in the scene's own representation."""
    integrate, step = scene.content.integrate, scene.content.integrate.step
    if integrate.tolerance is not None and scene.method.needs in scene.problem.forms:
        step = wanted_step(scene, scene.problem, scene.state)[1]
    return {} if step is None else {scene.method.name: step}
