"""Commands that this package adds to ``geomint``."""

import importlib
import sys
from pathlib import Path

import click

import geomint as gi
from geomint.cli.options import list_option

Numbers = list[float] | None
SOURCES = Path(__file__).parents[2]  # of a checkout, where this package is used from one


@click.command("inertia")
@list_option("--moments", of=float, metavar="I1,I2,I3", help="Principal moments of a ball, n = 3.")
@list_option("--a", of=float, metavar="A1,A2,…", help="Of the special inertia operator, any n.")
@click.option("--d", "D", type=float, help="D = m ρ².")
@click.option("--m", type=float, help="Mass m.")
@click.option("--rho", type=float, help="Radius ρ.")
@click.option("--debug", is_flag=True, hidden=True, expose_value=False)
def inertia(
    moments: Numbers, a: Numbers, D: float | None, m: float | None, rho: float | None
) -> None:
    """Convert principal moments of inertia (n = 3) to the parameters `a` of a sphere, or back.

    The special inertia operator is I(E_i∧E_j) = a_i a_j D/(D − a_i a_j). For n = 3 every ball has one.
    """
    from .inertia import SpecialInertia, positive_number
    from .rigid_body import warn_of_moments

    if (moments is None) == (a is None):
        raise gi.DomainError("--moments, --a", (moments, a), "exactly one of them")
    if D is None:
        if m is None or rho is None:
            raise gi.DomainError("--d", D, "D, or --m and --rho")
        rho = positive_number("--rho", rho)
        D = positive_number("--m rho²", m * rho * rho)
    elif m is not None or rho is not None:
        raise gi.DomainError("--d", D, "D alone, or --m and --rho alone")
    if moments is not None:
        special = SpecialInertia.from_moments(moments, D)
        warn_of_moments(moments)
    else:
        special = SpecialInertia(a, D)
    click.echo(f"n = {special.n}")
    click.echo(f"D = {D:.17g}")
    click.echo("a = [" + ", ".join(f"{x:.17g}" for x in special.a) + "]")
    pairs = [(i + 1, j + 1) for i in range(special.n) for j in range(i + 1, special.n)]
    for (i, j), entry in zip(pairs, special.diagonal, strict=True):
        click.echo(f"I(E_{i}∧E_{j}) = {entry:.17g} E_{i}∧E_{j}")
    if special.n == 3:
        click.echo("moments = [" + ", ".join(f"{x:.17g}" for x in special.moments) + "]")


def _of_sources(otherwise: click.Command) -> click.Command:
    """Return the audit of the sources that this package lies in, or the given command without them.

    The current folder does not count: its code may be anybody's.
    """
    project = SOURCES / "pyproject.toml"
    if not project.is_file() or 'name = "geomint"' not in project.read_text(encoding="utf-8"):
        return otherwise
    sys.path.insert(0, str(SOURCES))
    try:
        return importlib.import_module("tests.paper.command").audit
    except ModuleNotFoundError:  # another package is `tests` already
        return otherwise
    finally:
        sys.path.remove(str(SOURCES))


@_of_sources
@click.command("audit", context_settings={"ignore_unknown_options": True, "allow_extra_args": True})
def audit() -> None:
    """Check the formulas of Jovanović's paper at random points.

    The audit is not part of an installation. It is in the folder tests/paper of the sources. There,
    `python -m tests.paper` runs it, and `python -m tests.paper --help` lists its options. If you
    install the sources with `pip install -e`, `geomint audit` does the same.
    """
    raise gi.MissingCodeError(
        "the audit of the paper",
        "it lies in tests/paper of the sources of geomint, not in an installation; run "
        "`python -m tests.paper` there",
    )
