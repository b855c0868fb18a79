"""A comparison as a scene asks for it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from ..methods import Method
from ..plan.tolerance import wanted_step
from .endpoint import Source
from .runs import Comparison, compare

if TYPE_CHECKING:
    from ..scene import Scene

__all__ = ["compare_scene", "end_of", "first_steps", "methods_of"]


def compare_scene(
    scene: Scene,
    methods: list[str],
    steps: list[float] | None = None,
    repeats: int | None = None,
    reference: Source = "auto",
    peers: Iterable[str] = (),
    report: Callable[[str], None] = lambda text: None,
) -> Comparison:
    """Compare methods on a scene.

    The scene's own method, if it is one of them, runs with its options and about its step, or the one
    that meets its tolerance; all run in the representation that the scene asks for, if it does. See
    `compare` for the rest.
    """
    return compare(
        scene.model,
        end_of(scene),
        methods_of(scene, methods),
        steps=steps,
        first_steps=first_steps(scene),
        representation=scene.content.integrate.representation,
        repeats=repeats,
        reference=reference,
        peers=peers,
        report=report,
    )


def end_of(scene: Scene) -> dict[str, float]:
    """Return where a comparison ends, under the name of the time that it is in."""
    time = scene.content.time
    end = {"tau_end": time.tau_end} if time.tau_end is not None else {"t_end": time.t_end}
    return {key: value for key, value in end.items() if value is not None}


def methods_of(scene: Scene, names: list[str]) -> list[str | Method]:
    """Return the methods of those names: the scene's own one with its options."""
    own = scene.content.integrate.method
    return [scene.method if name == own else name for name in names]


def first_steps(scene: Scene) -> dict[str, float]:
    """Return the step of the scene's own method, if it has one in the scene's own representation."""
    integrate, step = scene.content.integrate, scene.content.integrate.step
    if integrate.tolerance is not None and scene.method.needs in scene.problem.forms:
        step = wanted_step(scene, scene.problem, scene.state)[1]
    return {} if step is None else {scene.method.name: step}
