"""Commands, from the shell and from Python: ``geomint drift``, ``geomint.drift_report``.

Commands are loaded when they are called: ``geomint --help`` imports none of them. Other packages
add commands under the entry-point group ``geomint.commands``.
"""

import importlib
from typing import Any

__all__ = ["find_command", "main"]
_MODULES = {"find_command": "table", "main": "group"}


def __getattr__(name: str) -> Any:
    """Import what is used: what commands are for Python needs no click."""
    if name not in _MODULES:
        raise AttributeError(name)
    return getattr(importlib.import_module(f"{__name__}.{_MODULES[name]}"), name)
