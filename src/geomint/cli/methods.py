"""``geomint methods``."""

from __future__ import annotations

import click

__all__ = ["command"]


@click.command("methods")
@click.option("--form", metavar="FORM", help="Only those that need field, action or hamiltonian.")
def command(form: str | None) -> None:
    """List the integration methods.

    A symmetric method of order 2 can be composed to higher order by a suffix: gauss-1-suzuki-4.
    """
    from rich.console import Console
    from rich.table import Table

    from ..errors import MethodError, nearest
    from ..methods.registry import methods

    forms = ("field", "action", "hamiltonian")
    if form is not None and form not in forms:
        raise MethodError(f"--form {form!r}: no such form.{nearest(form, forms)}")
    table = Table(box=None, header_style="bold")
    table.add_column("method", no_wrap=True)
    table.add_column("order", justify="right")
    table.add_column("needs")
    table.add_column("structure")
    table.add_column("what it is")
    for method in methods().values():
        if form in (None, method.needs):
            words = [w for w in ("symmetric", "symplectic") if getattr(method, w)]
            if method.needs == "action":
                words.append("stays on group orbits")
            table.add_row(
                method.name, str(method.order), method.needs, ", ".join(words), method.summary
            )
    Console().print(table)
