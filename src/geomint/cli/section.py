"""``geomint section``."""

from pathlib import Path
from typing import Any

import click

from . import options
from .meanwhile import import_meanwhile


@click.command("section")
@options.scene_choice
@click.option(
    "--event", metavar="NAME", help="Surface: one of [events], a component (gamma[2]), a quantity."
)
@click.option("--direction", type=click.Choice(["up", "down", "both"]), help="Crossings to count.")
@click.option("--level", type=float, help="Value of the event on the surface.")
@click.option("--points", type=click.IntRange(min=1), help="Number of points of each motion.")
@click.option("--motions", type=click.IntRange(min=1), help="Motions, all of the scene's energy.")
@click.option("--seed", type=click.IntRange(min=0), help="Random seed of the other motions.")
@options.list_option("--axes", metavar="X,Y", help="Plot these two components or quantities.")
@click.option("--exact", is_flag=True, help="Follow the exact flow, without steps.")
@options.folder_option(
    "section", "section.html, section.csv, section.json, section.png and section.svg"
)
@options.paper_option
@options.quiet_option
@options.debug_option
def command(scene: str, exact: bool, out: Path, paper: bool, quiet: bool, **keys: Any) -> int:
    """Compute a Poincaré section of a scene.

    Each motion ends when it has all its points, or when it has not crossed the surface for a million
    steps. A tolerance holds at the end time of the scene, which has no other effect.
    """
    from ..plan import plan_section
    from ..report import SECTION_FILES
    from ..run.files.outputs import check_folder

    chosen = options.chosen_scene(scene, **options.taken(keys))
    chosen = chosen.changed(integrate={"exact": True}) if exact else chosen
    declared = [p.name for p in click.get_current_context().command.params]  # as files have them
    plan = plan_section(chosen, **{str(key): keys[key] for key in declared if key in keys})
    options.print_notes(chosen)
    check_folder(out, SECTION_FILES)
    import_meanwhile("section_page")
    section = plan.run(not quiet)

    from ..report.section_page import write_section_report

    page = write_section_report(plan, section, out, options.reproducing_command(), paper)
    if not section.complete:
        options.print_message(f"not all points were found: {len(section)}")
    if not quiet:
        click.echo(repr(section))
        options.say_report("report" if section.complete else "report (incomplete)", page, paper)
    return options.exit_code(section.status)
