"""Where the results of a scene come from: what was asked for, and by which command."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..run.provenance import environment

if TYPE_CHECKING:
    from .scene import Scene


def scene_record(scene: Scene, command: str | None = None) -> dict[str, Any]:
    """Return what was asked for, by which command, and where: numbers and strings that JSON can hold.

    Parameters
    ----------
    scene : Scene
        With all that the command line changed.
    command : str, optional
        The command line that does it again.
    """
    source, state = scene.system.source, {}
    if scene.system.own:  # it may come with its state, which is in no section then
        state = {piece: scene.state[rows].tolist() for piece, rows in scene.problem.slices.items()}
    return {
        **environment(),
        **({"python": source} if source else {}),
        **({"state": state} if state else {}),
        "scene": scene.sections,
        "scene_name": scene.name,
        "scene_toml": scene.toml(),
        "scene_hash": scene.hash,
        "notes": list(scene.notes),
        "command": command,
        "seed": None,  # nothing is random
    }
