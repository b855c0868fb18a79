"""Check a scene and show how geomint would run it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from .. import options

if TYPE_CHECKING:
    from rich.console import Console

    from ...plan import Plan
    from ...scene import Scene


WIDE = 90  # columns: with fewer, three of words would be too narrow to read


@click.command("check")
@options.scene_options
@options.methods_option
@click.option("--for-drift", is_flag=True, help="Plan `geomint drift` instead of `geomint run`.")
def command(
    scene: str,
    methods: list[str] | None,
    for_drift: bool,
    **changes: Any,
) -> None:
    """Check a scene and show how geomint would run it, with reasons and the expected time.

    The command does not run the scene. If the run may take more than an hour, it runs for 0.1 seconds
    to estimate the time. With --tolerance it integrates a short part of the motion to find the step.

    With --methods, the command shows what `geomint drift` would do with each method.
    """
    from rich.console import Console
    from rich.text import Text

    from ...errors import printable
    from ...plan import make_plan, plan_methods
    from ...plan.several import drift_methods
    from ...problems.declared import claims_kept

    for_drift = for_drift or methods is not None
    sections = {"drift": {"methods": methods}} if methods else {}
    use = "drift" if for_drift else "run"
    chosen = options.chosen_scene(scene, use, sections=sections, **changes)
    with options.patience("planning"):
        plans: dict[str, Plan | str] = {}
        if for_drift:
            each = plan_methods(chosen, drift_methods(chosen), costs=True).each
            plans = {label: one.plan or str(one.error) for label, one in each.items()}
        else:
            plans[""] = make_plan(chosen, costs=True)
    options.print_notes(chosen, [text for _, _, text in claims_kept(chosen.problem, chosen.state)])
    console = Console()
    console.print(Text(printable(chosen.title), style="bold"))
    if chosen.content.description:
        console.print(Text(printable(" ".join(chosen.content.description.split()))), "")
    for label, plan in plans.items():
        if len(plans) > 1:
            console.print("", Text(label, style="bold"), sep="\n")
        _print_plan(console, chosen, plan)


def _print_plan(console: Console, scene: Scene, plan: Plan | str) -> None:
    from rich.text import Text

    from ...plan import estimate
    from ...reports.columns import fitted

    if isinstance(plan, str):
        console.print(Text(f"not possible: {plan}"))
        return
    rows = [("system", Text(scene.content.system.name), Text("[system] name"))]
    rows += [(c.what, Text(c.value), Text(c.reason)) for c in plan.choices]
    if scene.content.time.tau_end is not None and plan.scene.content.time.tau_end is None:
        why = "estimated by the rate at the start; the run goes where the scene's τ leads"
        rows.append(("end", Text(f"about t = {plan.scene.content.time.t_end:.4g}"), Text(why)))
    with options.patience("timing"):
        time = estimate(plan)
    why = "by a trial of the first steps" if time.measured else "by the sizes, a generous bound"
    rows.append(("time", Text(str(time)), Text(why)))
    if console.width < WIDE:  # reasons go below choices
        stacked = [(what, Text("\n").join((choice, why))) for what, choice, why in rows]
        console.print(fitted(console, ["what", "choice and why"], stacked))
    else:
        console.print(fitted(console, ["what", "choice", "why"], rows))
