"""Places to write in: a folder of one process alone, taking turns, and moments without Ctrl-C."""

import errno
import os
import platform
import secrets
import shutil
import signal
import threading
import time
import zlib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from ...errors import OutputError

try:
    import fcntl
except ImportError:  # not on this platform: processes that write to one folder may mix files
    fcntl = None  # type: ignore[assignment]

_FOLDER = os.O_RDONLY | getattr(os, "O_DIRECTORY", 0)
PATIENCE = 20.0  # seconds for another process to finish moving its files
YOUNG = 60.0  # seconds: what was left is not looked at before
# A lock on a folder that other machines see too may not be known to them: each removes its own.
LEFT = f".geomint-{zlib.crc32(platform.node().encode()):08x}-"


@contextmanager
def workplace(folder: Path) -> Iterator[Path]:
    """Make a folder of this process alone in another one, and remove it with what it holds."""
    _remove_left(folder)
    place = folder / f"{LEFT}{secrets.token_hex(8)}"
    with ExitStack() as ends:
        ends.callback(_remove, place)
        with undisturbed():
            place.mkdir(mode=0o700)
            (place / place.name).touch()  # a mark: no other folder can be given the name and this
        ends.enter_context(held(place, place))
        yield place


def _remove(place: Path) -> None:
    """Remove a folder if it has the mark; where folders can be held, nothing that took its place."""
    with undisturbed(), suppress(OSError), ExitStack() as ends:
        if fcntl is None:
            shutil.rmtree(place, ignore_errors=True)
            return
        descriptor = os.open(place, _FOLDER | os.O_NOFOLLOW)
        ends.callback(os.close, descriptor)
        os.stat(place.name, dir_fd=descriptor)
        shutil.rmtree(".", ignore_errors=True, dir_fd=descriptor)
        place.rmdir()


def _remove_left(folder: Path) -> None:
    """Remove what processes of this machine and user that were killed have left in a folder."""
    for place in folder.glob(f"{LEFT}{'[0-9a-f]' * 16}"):
        with suppress(OSError):
            found = place.lstat()
            if time.time() - found.st_mtime < YOUNG:
                continue
            with held(place, place) as locked:
                if locked and found.st_uid == os.geteuid():  # nobody is writing there
                    _remove(place)


@contextmanager
def undisturbed() -> Iterator[None]:
    """Keep Ctrl-C, and what the command line makes one, waiting to the end of the block."""
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(handler):
        yield
        return
    came = []
    signal.signal(signal.SIGINT, lambda number, frame: came.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        if came:
            signal.raise_signal(signal.SIGINT)


def synced(folder: Path) -> None:
    """Bring the names in a folder to the disk, where folders can be opened."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


_held: set[int] = set()  # descriptors


def _let_go() -> None:
    """Forget what the process that this one was forked from holds: a lock ends with its last owner."""
    while _held:
        os.close(_held.pop())


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_let_go)


@contextmanager
def held(folder: Path, named: str | os.PathLike[str], patience: float = 0.0) -> Iterator[bool]:
    """Keep a folder for this process, `named` in messages; one that is killed lets it go.

    Gives whether it is kept: not where there are no locks.

    Raises
    ------
    OutputError
        If another process, or thread, has it for more seconds than `patience`.
    """
    if fcntl is None:
        yield False
        return
    descriptor, end = os.open(folder, _FOLDER), time.monotonic() + patience
    _held.add(descriptor)
    try:
        yield _locked(descriptor, named, end)
    finally:
        _held.discard(descriptor)
        os.close(descriptor)  # which ends the lock


def _locked(descriptor: int, named: str | os.PathLike[str], end: float) -> bool:
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except OSError as failure:
            if failure.errno not in (errno.EAGAIN, errno.EACCES):
                return False  # no file system for locks
            if time.monotonic() >= end:
                raise OutputError(named, "somebody else is writing to it") from None
        time.sleep(0.01)
