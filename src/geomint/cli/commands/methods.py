"""List the integration methods."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.console import Console

    from ...methods.method import Method


NAME, WIDE = 39, 110  # columns: of the longest name, and of a terminal with room for more


@click.command("methods")
@click.option(
    "--form",
    metavar="FORM",
    help="List only methods that need this form: field, action, hamiltonian, splitting.",
)
def command(form: str | None) -> None:
    """List the integration methods by family, and what each family conserves.

    A suffix raises the order of a symmetric method of order 2 by composition: gauss-1-suzuki-4. A wide
    terminal also describes each method.
    """
    from rich.console import Console

    from ...errors import MethodError, nearest
    from ...methods.registry import methods
    from ...problems.forms import FORMS

    if form is not None and form not in FORMS:
        raise MethodError(f"--form {form!r}: no such form.{nearest(form, FORMS)}")
    families: dict[tuple[Any, ...], list[Method]] = {}
    for method in methods().values():
        if form in (None, method.needs):
            alike = (method.needs, method.symmetric, method.symplectic, method.keeps)
            families.setdefault((method.family, *alike), []).append(method)
    console = Console()
    for members in families.values():
        _print_family(console, members)
    if form in (None, "field"):
        console.print("¹ for Hamiltonian fields on flat space, not for flows on a manifold")


def _print_family(console: Console, members: list[Method]) -> None:
    from rich.table import Table

    first = members[0]
    mark = "¹" if first.needs == "field" else ""
    keeps = [*["symmetric"] * first.symmetric, *[f"symplectic{mark}"] * first.symplectic]
    keeps += [f"keeps {' and '.join(first.keeps)}"] * bool(first.keeps)
    console.print(
        f"[bold]{first.family or 'of other packages'}[/bold] (needs {first.needs}): "
        f"{', '.join(keeps) or 'preserves nothing'}",
        highlight=False,
    )
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column(min_width=NAME + 2, no_wrap=True)
    table.add_column(no_wrap=True)
    wide = console.width >= WIDE  # else the description would be a column of single words
    for method in members:
        row = [f"  {method.name}", f"order {method.order}"]
        table.add_row(*row, *([method.summary] if wide else []))
    console.print(table)
    console.print()
