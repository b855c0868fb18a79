"""The table of commands: one module of `commands` for each, and entry points of other packages."""

from __future__ import annotations

import functools
import importlib
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

from ..errors import GeomintError, loaded, nearest, offered

FIRST = ("scenes", "methods", "check", "run", "drift")  # in the list; then the others


@functools.cache
def own_commands() -> dict[str, str]:
    """Return the modules of this package's commands by the names of these."""
    names = {path.stem for path in (Path(__file__).parent / "commands").glob("*.py")}
    names -= {"__init__", *FIRST}
    return {name: f"{__package__}.commands.{name}" for name in (*FIRST, *sorted(names))}


def other_commands() -> dict[str, EntryPoint]:
    """Return the commands of other packages."""
    return offered("geomint.commands", own_commands())


def find_command(name: str) -> Any:
    """Return the `Command` of that name, or a click command; its module is imported.

    Raises
    ------
    GeomintError
        For a name that is none, and for what is no command.
    """
    from click import Command as OfClick

    from .command import Command

    own, others = own_commands(), other_commands()
    if name in own:
        module = importlib.import_module(own[name])
        made = (x for x in vars(module).values() if isinstance(x, Command))
        return getattr(module, "command", None) or next(made)
    if name not in others:
        raise GeomintError(f"no such command {name!r}.{nearest(name, [*own, *others])}")
    found = loaded(others[name])
    if not isinstance(found, Command | OfClick):
        raise GeomintError(f"command {name!r} is neither one of geomint nor of click: {found!r}")
    return found
