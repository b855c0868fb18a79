"""``geomint check``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from .options import chosen_scene, methods_option, scene_options, several_methods, tell_notes

if TYPE_CHECKING:
    from rich.console import Console

    from ..plan import Plan
    from ..scene import Scene

__all__ = ["command"]


@click.command("check")
@scene_options
@methods_option
@click.option("--for-drift", is_flag=True, help="Plan for `geomint drift`, not `geomint run`.")
def command(
    scene: str,
    method: str | None,
    step: float | None,
    t_end: float | None,
    tau_end: float | None,
    representation: str | None,
    observe: str | None,
    methods: str | None,
    for_drift: bool,
) -> None:
    """Say what a scene would compute, how, and why so. Nothing is integrated.

    With --methods: what `geomint drift` would do with each of them.
    """
    from rich.console import Console
    from rich.text import Text

    for_drift = for_drift or methods is not None
    chosen = chosen_scene(scene, method, step, t_end, tau_end, representation, observe, for_drift)
    several = several_methods(chosen, methods, method, step) if for_drift else None
    # A plan that fails is told alone: before the title if it is the only one.
    plans = {} if several is not None else {"": _plan(chosen, for_drift)}
    tell_notes(chosen)
    console = Console()
    console.print(Text(chosen.title, style="bold"))
    if chosen.content.description:
        console.print(Text(" ".join(chosen.content.description.split())), "")
    for label, plan in (plans or _plans(chosen, several or [])).items():
        if label:
            console.print("", Text(label, style="bold"), sep="\n")
        _print_plan(console, chosen, plan)


def _plan(scene: Scene, for_drift: bool) -> Plan:
    from ..plan import make_plan

    return make_plan(scene, "drift" if for_drift else "run", costs=True)


def _plans(scene: Scene, methods: list[str]) -> dict[str, Plan | str]:
    """Return the plan of each method, or why there is none.

    The physical end of methods in t is estimated by the rate at the start if the scene ends in τ.
    """
    from ..errors import GeomintError
    from ..evaluate import value
    from ..plan import labelled_scenes, plan_method

    def physical_end() -> float:
        clock, tau_end = scene.problem.clock, scene.content.time.tau_end
        assert clock is not None
        assert tau_end is not None
        return tau_end * value(scene.problem, clock, scene.state)

    plans: dict[str, Plan | str] = {}
    for label, variant in labelled_scenes(scene, methods).items():
        try:
            plans[label] = plan_method(variant, physical_end, costs=True)
        except GeomintError as error:
            plans[label] = str(error)
    return plans


def _print_plan(console: Console, scene: Scene, plan: Plan | str) -> None:
    from rich.table import Table
    from rich.text import Text

    if isinstance(plan, str):
        console.print(Text(f"not possible: {plan}"))
        return
    table = Table("what", "choice", "why", box=None, header_style="bold")
    table.add_row("system", scene.content.system.name, "[system] name".replace("[", r"\["))
    for choice in plan.choices:
        table.add_row(choice.what, Text(choice.value), Text(choice.reason))
    if scene.content.time.tau_end is not None and plan.scene.content.time.tau_end is None:
        why = "estimated by the rate at the start; the run goes where the scene's τ leads"
        table.add_row("end", f"about t = {plan.scene.content.time.t_end:.4g}", why)
    console.print(table)
