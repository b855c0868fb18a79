"""New figures in the look of all others; matplotlib is imported when one is made."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from .style import figure_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@contextmanager
def new_figure(width: float, height: float, **options: Any) -> Iterator[Figure]:
    """Give a figure of that size in inches, within `figure_style`; notebooks show it."""
    with figure_style():
        from .figure import ShownFigure

        yield ShownFigure(figsize=(width, height), **options)
