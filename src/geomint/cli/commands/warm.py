"""Compile the code of scenes now, so that later runs start at once."""

import time

import click

from ...errors import GeomintError
from .. import options


@click.command("warm")
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@options.list_option(
    "--methods", metavar="LIST", help="Methods, separated by commas; default: those of each scene."
)
@options.quiet_option
@options.debug_option
def command(scenes: tuple[str, ...], methods: list[str] | None, quiet: bool) -> None:
    """Compile the code of scenes now, so that later runs start at once.

    `geomint run` and `geomint drift` of these scenes then load the code from the cache. Without SCENE,
    the command compiles the code of all built-in scenes. If a scene fails, the others continue.
    """
    from ...plan.several import drift_methods, warm
    from ...scene import load_scene, scene_names

    failure = None
    for name in scenes or scene_names():
        begun = time.perf_counter()
        try:
            scene = load_scene(name)
            warm(scene, methods or drift_methods(scene.for_drift()), False if quiet else None)
        except GeomintError as error:
            if failure is not None:
                options.print_failure(failure)
            failure = error
            continue
        if not quiet:
            click.echo(f"{name}: ready, {time.perf_counter() - begun:.1f} s")
    if failure is not None:
        raise failure
