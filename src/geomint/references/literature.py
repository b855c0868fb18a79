"""The sources of the methods, the package itself, and the paper whose systems come with it.

They lie in ``literature.toml``, a table each under the name that it has here; methods and tableaux say
which are theirs.
"""

import tomllib
import typing
from pathlib import Path

from .reference import Reference


def sources(module: str) -> dict[str, Reference]:
    """Return the sources of the file of a module's name, with the ending ``.toml``, by their names."""
    tables = tomllib.loads(Path(module).with_suffix(".toml").read_text(encoding="utf-8"))
    return {name: Reference(**table) for name, table in tables.items()}


globals().update(sources(__file__))

if typing.TYPE_CHECKING:

    def __getattr__(name: str) -> Reference: ...
