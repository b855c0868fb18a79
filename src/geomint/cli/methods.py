"""``geomint methods``."""

from __future__ import annotations

import click

__all__ = ["command"]

WIDE = 110  # columns


@click.command("methods")
@click.option(
    "--form",
    metavar="FORM",
    help="Only those that need this form: field, action, hamiltonian, splitting.",
)
def command(form: str | None) -> None:
    """List the integration methods.

    A symmetric method of order 2 can be composed to higher order by a suffix: gauss-1-suzuki-4. Group
    methods stay on the orbits of their group; a wide terminal also shows what each method is.
    """
    from rich.console import Console
    from rich.table import Table

    from ..errors import MethodError, nearest
    from ..methods.registry import methods
    from ..problems.forms import FORMS

    if form is not None and form not in FORMS:
        raise MethodError(f"--form {form!r}: no such form.{nearest(form, FORMS)}")
    console = Console()
    wide = console.width >= WIDE  # else the description would be a column of single words
    table = Table(box=None, header_style="bold", pad_edge=False)
    table.add_column("method", no_wrap=True)
    table.add_column("order", justify="right")
    table.add_column("needs", no_wrap=True)
    table.add_column("structure")
    if wide:
        table.add_column("what it is")
    for method in methods().values():
        if form in (None, method.needs):
            mark = "¹" if method.needs == "field" else ""
            words = ["symm."] * method.symmetric + [f"symplectic{mark}"] * method.symplectic
            if method.needs == "action":
                words.append("on orbits")
            row = [method.name, str(method.order), method.needs, ", ".join(words)]
            table.add_row(*row, *([method.summary] if wide else []))
    console.print(table)
    if form in (None, "field"):
        console.print("¹ for Hamiltonian fields on flat space, not for flows on a manifold")
