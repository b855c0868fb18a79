"""Options and helpers that several commands share."""

from __future__ import annotations

import shlex
import sys
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from ..scene import Scene
    from ..solution import Solution

__all__ = ["chosen_scene", "exit_code", "reproducing_command", "scene_options", "tell_notes"]

F = TypeVar("F", bound=Callable[..., Any])

_SCENE_OPTIONS = (
    click.argument("scene"),
    click.option("--method", metavar="NAME", help="Another method; see `geomint methods`."),
    click.option("--step", type=float, help="Step in the time that the method works in."),
    click.option("--t-end", type=float, help="End in physical time."),
    click.option("--tau-end", type=float, help="End in the reparametrised time of the problem."),
    click.option("--debug", is_flag=True, hidden=True, expose_value=False),
)


def scene_options(command: F) -> F:
    """Add the argument SCENE and the options that change it."""
    for option in reversed(_SCENE_OPTIONS):
        command = option(command)
    return command


def chosen_scene(
    scene: str,
    method: str | None,
    step: float | None,
    t_end: float | None,
    tau_end: float | None,
    drift: bool = False,
) -> Scene:
    """Return the scene with what the command line changes in it, and print its notes."""
    from ..errors import GeomintWarning, SceneError
    from ..scene.load import load_scene

    if t_end is not None and tau_end is not None:
        raise SceneError(f"--t-end {t_end:g} and --tau-end {tau_end:g}: expected one of them")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GeomintWarning)  # its notes are printed instead
        result = load_scene(scene)
    if drift:
        result = result.for_drift()
    if t_end is not None or tau_end is not None:
        result = result.changed(time={"t_end": t_end, "tau_end": tau_end})
    return result.changed_integration(method, step)


def tell_notes(scene: Scene) -> None:
    """Print what was changed to make the initial state admissible."""
    for note in scene.notes:
        click.echo(f"geomint: note: {note}", err=True)


def reproducing_command(arguments: list[str] | None = None) -> str:
    """Return the command line of this run."""
    return shlex.join(["geomint", *(sys.argv[1:] if arguments is None else arguments)])


def exit_code(solution: Solution) -> int:
    """Return 0, 130 after an interrupt, or 2 after a failure."""
    return {"success": 0, "interrupted": 130}.get(solution.status, 2)
