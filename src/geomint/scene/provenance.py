"""Where the results of a scene come from: what was asked for, and by which command."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..run.provenance import environment, run_record

if TYPE_CHECKING:
    from ..run.solution import Solution
    from .scene import Scene

__all__ = ["scene_provenance", "scene_record"]


def scene_provenance(
    solution: Solution, scene: Scene, command: str | None = None, seed: int | None = None
) -> dict[str, Any]:
    """Return all about a run of a scene, in numbers and strings that JSON can hold.

    Parameters
    ----------
    solution : Solution
    scene : Scene
        What was asked for, with all that the command line changed.
    command : str, optional
        The command line that does it again.
    seed : int, optional
        Of the random numbers, where there are any.
    """
    return {**environment(), **scene_record(scene, command, seed), **run_record(solution)}


def scene_record(
    scene: Scene, command: str | None = None, seed: int | None = None
) -> dict[str, Any]:
    """Return what was asked for, and by which command."""
    return {
        "scene": scene.sections,
        "scene_name": scene.name,
        "scene_toml": scene.toml(),
        "scene_hash": scene.hash,
        "notes": list(scene.notes),
        "command": command,
        "seed": seed,
    }
