"""``geomint section``."""

from pathlib import Path
from typing import Any

import click

from . import options
from .meanwhile import import_meanwhile


@click.command("section")
@options.scene_choice
@click.option(
    "--event", metavar="NAME", help="One of [events], a component (gamma[2]), a quantity."
)
@click.option("--direction", type=click.Choice(["up", "down", "both"]), help="Of its changes.")
@click.option("--level", type=float, help="The value that is looked for.")
@click.option("--points", type=click.IntRange(min=1), help="Points of each motion.")
@click.option("--motions", type=click.IntRange(min=1), help="The scene's and others of its energy.")
@click.option("--seed", type=click.IntRange(min=0), help="Of the other motions.")
@options.list_option("--axes", metavar="X,Y", help="Components or quantities of the picture.")
@click.option("--exact", is_flag=True, help="Follow the exact flow, without steps.")
@options.folder_option(
    "section", "section.html, section.csv, section.json, section.png and section.svg"
)
@options.paper_option
@options.quiet_option
@options.debug_option
def command(scene: str, exact: bool, out: Path, paper: bool, quiet: bool, **keys: Any) -> int:
    """Follow motions of a scene until each has crossed a surface so many times.

    The scene's own end is not used, but for the step that meets a tolerance there: motions are followed
    until they have their points, or do not cross for a million steps.
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
