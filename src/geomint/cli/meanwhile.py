"""What a command's page will need is imported while compiled code runs, which leaves Python free."""

from __future__ import annotations

import contextlib
import importlib
import threading

__all__ = ["import_meanwhile"]

_DRAWING = (
    "geomint.plots.figure",
    "matplotlib.backends.backend_agg",
    "matplotlib.backends.backend_svg",
)


def import_meanwhile(page: str) -> None:
    """Begin to import a module of `geomint.report`, and what figures are made with.

    What fails here fails again, and is told, where it is imported for use.
    """

    def load() -> None:
        with contextlib.suppress(Exception):
            for name in (f"geomint.report.{page}", *_DRAWING):
                importlib.import_module(name)

    threading.Thread(target=load, name=f"importing {page}").start()
