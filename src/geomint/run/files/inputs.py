"""What is read is not written over: the inputs of a command, or of a session of Python."""

import os
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
    """Raise `OutputError` if the file at `target` is an input, by whatever name."""
    for place in _inputs.get():
        if place.exists() and target.samefile(place):
            raise OutputError(path, f"it is the input {quoted(str(place))}; expected another place")
