"""HTML pages from the templates of this package: self-contained, everything escaped."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from ..errors import printable
from .text import number, with_error

__all__ = ["render", "section"]


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
