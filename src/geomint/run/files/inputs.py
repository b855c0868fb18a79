"""What is read is not written over: the inputs of a command, or of a session of Python."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from ...errors import OutputError, quoted

_of_session: set[Path] = set()
_inputs: ContextVar[set[Path]] = ContextVar("inputs", default=_of_session)


@contextmanager
def inputs_of_command() -> Iterator[None]:
    """Know within of no other inputs than those that are read there."""
    token = _inputs.set(set())
    try:
        yield
    finally:
        _inputs.reset(token)


def note_input(path: Path, copied: bool = False) -> None:
    """Note a file that is read; one that a session has `copied` to memory may be written anew."""
    inputs = _inputs.get()
    if not (copied and inputs is _of_session):
        inputs.add(path.absolute())


def check_no_input(path: str | os.PathLike[str], target: Path) -> None:
    """Raise `OutputError` if the file at `target` is an input, by whatever name.

    The sources of what runs are inputs too, and the file of matplotlib's settings.
    """
    inputs = [*_inputs.get(), Path(os.environ.get("MATPLOTLIBRC", ""))]
    for name, module in list(sys.modules.items()):
        source = str(getattr(module, "__dict__", {}).get("__file__") or "")
        if name == "__main__" or source.endswith(target.name):
            inputs.append(Path(source))
    for place in inputs:
        if os.path.exists(place) and target.samefile(place):
            raise OutputError(path, f"it is the input {quoted(str(place))}; expected another place")
