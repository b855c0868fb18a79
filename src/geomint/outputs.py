"""Files that appear whole or not at all: what geomint writes for its users goes through here.

New content is written beside its place under a name of its own, brought to the disk, and renamed.
Whatever goes wrong, what was there before is still there; of several processes that write to one
place, the last complete one wins.
"""

from __future__ import annotations

import os
import secrets
import shutil
import stat
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from os import PathLike
from pathlib import Path

from .errors import DomainError, OutputError, told

try:
    import fcntl
except ImportError:  # not on this platform: processes that write to one folder may mix files
    fcntl = None  # type: ignore[assignment]

__all__ = ["check_file", "check_folder", "whole_file", "whole_folder"]

PROBE = 4096  # bytes written to see whether anything can be
PATIENCE = 20.0  # seconds for another process to finish moving its files
LONGEST_SUFFIX = 16


def check_file(path: str | PathLike[str]) -> None:
    """See whether a file can be written, before the work that it is to hold; make its folder.

    Raises
    ------
    OutputError
        If something else than a regular file is there, or nothing can be written.
    """
    with _told(path):
        target = _regular(Path(path))
        target.parent.mkdir(parents=True, exist_ok=True)
        _probe(target.parent)


def check_folder(path: str | PathLike[str]) -> None:
    """Make a folder, and see whether files can be written to it.

    Raises
    ------
    OutputError
    """
    with _told(path):
        folder = Path(path)
        folder.mkdir(parents=True, exist_ok=True)
        _probe(folder)


@contextmanager
def whole_file(path: str | PathLike[str]) -> Iterator[Path]:
    """Give the place to write a file to, and move it to `path` once it is complete.

    Symlinks are followed. A file that is there is replaced with its permissions kept.

    Raises
    ------
    OutputError
        If something else than a regular file is there, or it cannot be written; what was there is
        as it was.
    """
    with _told(path):
        target = _regular(Path(path))
        unfinished = _beside(target)
        try:
            _create(unfinished)
            if target.exists():  # what nobody else may read is not to be read while it is written
                shutil.copymode(target, unfinished)
            yield unfinished
            _put(unfinished, target)
            _synced(target.parent)
        finally:
            unfinished.unlink(missing_ok=True)


@contextmanager
def whole_folder(path: str | PathLike[str]) -> Iterator[Path]:
    """Give an empty folder to write files to, and move them all to the folder `path`, or none.

    Other files that are there stay.

    Raises
    ------
    OutputError
        If one of the files cannot be written or moved; what was there is as it was.
    """
    with _told(path):
        folder = Path(path)
        folder.mkdir(parents=True, exist_ok=True)
        unfinished = _beside(folder / "files")
        unfinished.mkdir()
        try:
            yield unfinished
            with _alone(folder):
                _move_all(unfinished, folder)
        finally:
            shutil.rmtree(unfinished, ignore_errors=True)


def _move_all(source: Path, folder: Path) -> None:
    """Move files; if one cannot be, bring back what the others have replaced."""
    names = sorted(file.name for file in source.iterdir())
    targets = {name: _regular(folder / name) for name in names}
    home = Path(os.path.realpath(folder))
    with ExitStack() as back:
        for name, target in targets.items():
            if target.exists():
                kept = _beside(source / name)
                shutil.copy2(target, kept)
                back.callback(shutil.move, kept, target)
            else:
                back.callback(target.unlink, missing_ok=True)
            if target.parent == home:
                _put(source / name, target)
            else:  # a symlink leads elsewhere, where one cannot rename to perhaps
                with whole_file(target) as place:
                    shutil.copyfile(source / name, place)
        _synced(folder)
        back.pop_all()


def _put(unfinished: Path, target: Path) -> None:
    """Bring a complete file to the disk and to its place, with the permissions of the old one."""
    with unfinished.open("rb") as file:
        os.fsync(file.fileno())
    if target.exists():
        shutil.copymode(target, unfinished)
    unfinished.replace(target)


def _regular(path: Path) -> Path:
    """Return where `path` leads; refuse whatever is no regular file there, or may not be changed."""
    target = Path(os.path.realpath(path))
    try:
        mode = target.stat().st_mode
    except FileNotFoundError:
        return target
    if not stat.S_ISREG(mode):
        kind = "a folder" if stat.S_ISDIR(mode) else "no regular file"
        raise OutputError(path, f"that is {kind}, which is left alone")
    if not os.access(target, os.W_OK):
        raise OutputError(path, "that file may not be written")
    return target


def _beside(target: Path) -> Path:
    """Return a name that nobody has, in the same folder and with the same suffix."""
    suffix = target.suffix if len(target.suffix) <= LONGEST_SUFFIX else ""
    return target.with_name(f".geomint-{secrets.token_hex(8)}{suffix}")


def _create(path: Path) -> None:
    os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))


def _probe(folder: Path) -> None:
    trial = _beside(folder / "trial")
    try:
        _create(trial)
        with trial.open("wb") as file:
            file.write(bytes(PROBE))
            file.flush()
            os.fsync(file.fileno())
    finally:
        trial.unlink(missing_ok=True)


def _synced(folder: Path) -> None:
    """Bring the names in a folder to the disk, where folders can be opened."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Wait for other processes that are moving files to this folder, and keep others waiting."""
    if fcntl is None:
        yield
        return
    descriptor, end = os.open(folder, os.O_RDONLY), time.monotonic() + PATIENCE
    try:
        while True:
            try:
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                if time.monotonic() > end:
                    raise OutputError(folder, "another process keeps writing to it") from None
                time.sleep(0.01)
        yield
    finally:
        os.close(descriptor)  # which ends the lock


@contextmanager
def _told(path: str | PathLike[str]) -> Iterator[None]:
    """Turn errors of the operating system into the typed error that names what was to be written."""
    if not isinstance(path, str | PathLike):
        raise DomainError("path", path, "the path of a file or folder")
    try:
        yield
    except OutputError:
        raise
    except OSError as failure:
        why, other = failure.strerror or str(failure), failure.filename
        known = Path(path).name
        if other is not None and ".geomint-" not in str(other) and Path(other).name != known:
            why = f"{why}: {told(other)}"
        raise OutputError(path, why, failure.errno) from failure
    except UnicodeEncodeError as failure:
        raise OutputError(path, "its name has characters that no name can have") from failure
    except ValueError as failure:
        if "null" not in str(failure):  # no name of a file has a null character
            raise
        raise OutputError(path, str(failure)) from failure
