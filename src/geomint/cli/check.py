"""``geomint check``."""

from __future__ import annotations

import click

from .options import chosen_scene, scene_options, tell_notes

__all__ = ["command"]


@click.command("check")
@scene_options
@click.option("--for-drift", is_flag=True, help="Plan for `geomint drift`, not `geomint run`.")
def command(
    scene: str,
    method: str | None,
    step: float | None,
    t_end: float | None,
    tau_end: float | None,
    for_drift: bool,
) -> None:
    """Say what a scene would compute, how, and why so. Nothing is integrated."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    chosen = chosen_scene(scene, method, step, t_end, tau_end, for_drift)

    from ..plan import make_plan

    plan = make_plan(chosen, "drift" if for_drift else "run", costs=True)
    tell_notes(chosen)
    console = Console()
    console.print(Text(chosen.title, style="bold"))
    if chosen.content.description:
        console.print(Text(" ".join(chosen.content.description.split())), "")
    table = Table("what", "choice", "why", box=None, header_style="bold")
    table.add_row("system", chosen.content.system.name, "[system] name".replace("[", r"\["))
    for choice in plan.choices:
        table.add_row(choice.what, Text(choice.value), Text(choice.reason))
    console.print(table)
