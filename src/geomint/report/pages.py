"""HTML pages from the templates of this package: self-contained, everything escaped."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from ..errors import printable
from ..plots.style import save_figure
from ..run.files.outputs import whole_folder
from .text import number, with_error

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .paper import Paper

__all__ = ["render", "section", "write_files"]


def _harmless(value: Any) -> Any:
    """Return a value without control characters, which no HTML may have and which may mislead."""
    plain = isinstance(value, str) and not isinstance(value, Markup)
    return printable(value) if plain and not value.isprintable() else value


@functools.cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("geomint.report"),
        autoescape=True,
        finalize=_harmless,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals.update(number=number, with_error=with_error)
    return environment


def render(template: str, **context: Any) -> str:
    """Return a page; templates share ``report.css`` and have `number` and `with_error`."""
    return _environment().get_template(template).render(**context)


def section(template: str, content: Mapping[str, Any] | None) -> Markup:
    """Return a part of a page from its own template; nothing if it has no content."""
    return Markup("" if content is None else render(template, **content))


def write_files(
    folder: Path,
    names: Sequence[str],
    page: str,
    data: str,
    figures: Mapping[str, Figure],
    others: Mapping[str, Callable[[Path], None]] = MappingProxyType({}),
    paper: Paper | None = None,
) -> Path:
    """Write the files of a report, all or none: page, JSON, and each figure as PNG and SVG.

    And the `others`, by functions that take a path; with a `paper` all that is for one. Returns the
    path of the page.

    Raises
    ------
    OutputError
        If the folder cannot be written; what was there is as it was.
    """
    html, json = (next(n for n in names if n.endswith(kind)) for kind in (".html", ".json"))
    with whole_folder(folder, names) as unfinished:
        (unfinished / html).write_text(page, encoding="utf-8")
        (unfinished / json).write_text(data, encoding="utf-8")
        for name, figure in figures.items():
            save_figure(figure, unfinished, name)
        for name, write in others.items():
            write(unfinished / name)
        if paper is not None:
            paper.write(unfinished, figures)
    return folder / html
