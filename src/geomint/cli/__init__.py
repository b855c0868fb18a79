"""The command line: ``geomint scenes | methods | check | run | drift | compare``.

Commands are loaded when they are called: ``geomint --help`` imports none of them. Other packages
add commands under the entry-point group ``geomint.commands``.
"""

from .group import main

__all__ = ["main"]
