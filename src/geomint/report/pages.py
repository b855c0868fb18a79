"""HTML pages from the templates of this package: self-contained, everything escaped."""

from __future__ import annotations

import functools
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from .text import number, with_error

__all__ = ["render"]


@functools.cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("geomint.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals.update(number=number, with_error=with_error)
    return environment


def render(template: str, **context: Any) -> str:
    """Return a page; templates share ``report.css`` and have `number` and `with_error`."""
    return _environment().get_template(template).render(**context)
