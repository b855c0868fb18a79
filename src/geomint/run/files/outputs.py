"""Files that appear whole or not at all: what geomint writes for its users goes through here.

New content is written to a folder of its own beside its place, brought to the disk, and renamed.
Whatever goes wrong, what was there before is still there; of several processes that write to one
place, the last complete one wins. What a process that was killed has left there, the next one
removes.
"""

import csv
import hashlib
import json
import os
import shutil
import stat
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from os import PathLike
from pathlib import Path

from ...arguments import Array, file_path
from ...errors import DomainError, OutputError, quoted
from ...plots.style import figure_style
from .inputs import check_no_input
from .workplace import PATIENCE, held, synced, undisturbed, workplace

UNSEALED = "0" * 64  # in place of a digest that is not known yet
PROBE = 4096  # bytes written to see whether anything can be


def check_file(path: str | PathLike[str]) -> None:
    """See whether a file can be written, before the work that it is to hold; make its folder.

    Raises
    ------
    OutputError
        If something else than a regular file is there, or one that was read, or nothing can be
        written.
    """
    with refused_as_output(path):
        _probe(_made(_regular(Path(path)).parent))


def check_folder(path: str | PathLike[str], names: Iterable[str] = ()) -> None:
    """Make a folder, and see whether files can be written to it.

    Parameters
    ----------
    path : str or path
    names : iterable of str
        Of the files that will be: nothing else may have them but files of an earlier report, none of
        which was read. Pictures are among them.

    Raises
    ------
    OutputError
    MissingCodeError
        If pictures cannot be made.
    """
    with refused_as_output(path):
        folder = _made(Path(path))
        if names:
            with held(folder, path, PATIENCE), figure_style():  # or pictures fail after the run
                _targets(folder, names)
        _probe(folder)


@contextmanager
def whole_file(path: str | PathLike[str]) -> Iterator[Path]:
    """Give the place to write a file to, and move it to `path` once it is complete.

    Symlinks are followed. A file that is there is replaced; its permissions are kept, and its owner
    and group where the system allows that.

    Raises
    ------
    OutputError
        If something else than a regular file is there, or a file that was read, such as a scene, or
        it cannot be written; what was there is as it was.
    """
    with refused_as_output(path):
        target = _regular(Path(path))
        with workplace(target.parent) as place:
            unfinished = place / target.name
            os.close(os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
            _as_old(unfinished, target)
            yield unfinished
            with undisturbed():
                _complete(unfinished, target)
                _put(unfinished, target)
                synced(target.parent)


def write_table(path: str | PathLike[str], names: Iterable[str], columns: Iterable[Array]) -> None:
    """Write columns as CSV, whole or not at all."""
    file_path("path", path, (".csv", ".txt"), strict=False)
    with (
        whole_file(path) as unfinished,
        unfinished.open("w", encoding="utf-8", newline="") as stream,
    ):
        writer = csv.writer(stream)
        writer.writerow(names)
        writer.writerows(zip(*(column.tolist() for column in columns), strict=True))


@contextmanager
def whole_folder(path: str | PathLike[str], names: Iterable[str] = ()) -> Iterator[Path]:
    """Give an empty folder to write files to, and move them all to the folder `path`, or none.

    Other files that are there stay; a symlink that has the name of one is left alone.

    Parameters
    ----------
    path : str or path
    names : iterable of str
        Of the files of a report: of an earlier one that is not written anew nothing stays. What is
        there as no earlier report has written it, as its JSON says, is left alone.

    Raises
    ------
    OutputError
        If one of the files cannot be written or moved; what was there is as it was.
    """
    with refused_as_output(path):
        folder = _made(Path(path))
        with workplace(folder) as place:
            unfinished, old = place / "new", place / "old"
            unfinished.mkdir()
            old.mkdir()
            yield unfinished
            with held(folder, path, PATIENCE), undisturbed():
                _move_all(unfinished, folder, old, names)


def _move_all(source: Path, folder: Path, old: Path, names: Iterable[str]) -> None:
    """Move files; if one cannot be, bring back what the others have replaced."""
    new = {file.name for file in source.iterdir()}
    targets = _targets(folder, names, new)
    for name, target in targets.items():
        if target.exists():
            _kept(target, old / name)
        if name in new:
            _complete(source / name, target)
    with ExitStack() as back:  # from here on every moment counts: nothing but renaming
        for name, target in targets.items():
            if (old / name).exists():
                back.callback(shutil.move, old / name, target)
            else:
                back.callback(target.unlink, missing_ok=True)
            if name in new:
                _put(source / name, target)
            else:
                target.unlink(missing_ok=True)
        synced(folder)
        back.pop_all()


def digest(content: bytes, own: str = UNSEALED) -> str:
    """Return the SHA-256 by which the JSON of a report knows a file, with zeros for its own digits."""
    return hashlib.sha256(content.replace(own.encode(), UNSEALED.encode())).hexdigest()


def _targets(folder: Path, names: Iterable[str], more: Iterable[str] = ()) -> dict[str, Path]:
    """Return the places of files; of `names` refuse what no earlier report has written."""
    names = set(names)
    # The JSON first: what a process that is killed has moved after it is of a report.
    order = sorted(names.union(more), key=lambda name: (not name.endswith(".json"), name))
    targets = {name: _regular(folder / name, followed=False) for name in order}
    others = [name for name in order if name in names and targets[name].exists()]
    with suppress(OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        files = json.loads(targets[others[0]].read_bytes())["files"]
        for name in [*others]:
            own = files.get(name, "")
            if len(own) == len(UNSEALED) and own == digest(targets[name].read_bytes(), own):
                others.remove(name)
    if others:
        raise OutputError(
            folder,
            f"{', '.join(others)}: of no earlier report, or changed since, and left alone; move "
            "what is yours, or name another folder",
        )
    return targets


def _kept(file: Path, kept: Path) -> None:
    """Keep a file under a second name, or a copy of it."""
    try:
        os.link(file, kept)
    except OSError:
        shutil.copy2(file, kept)


def _complete(unfinished: Path, target: Path) -> None:
    """Bring a complete file to the disk."""
    with unfinished.open("rb") as file:
        os.fsync(file.fileno())
    _as_old(unfinished, target)


def _put(unfinished: Path, target: Path) -> None:
    unfinished.replace(target)


def _as_old(unfinished: Path, target: Path) -> None:
    """Give a file the owner, as far as one may, and the permissions of the one that it replaces."""
    if not target.exists():
        return
    if hasattr(os, "chown"):
        found = target.stat()
        for owner in (found.st_uid, -1):
            with suppress(OSError):
                os.chown(unfinished, owner, found.st_gid)
                break
    shutil.copymode(target, unfinished)


def _made(folder: Path) -> Path:
    """Make a folder; say what is there instead."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError) as failure:
        place = next(p for p in (folder, *folder.parents) if os.path.lexists(p) and not p.is_dir())
        kind = "a symlink that leads nowhere" if not place.exists() else "no folder"
        raise OutputError(
            folder, f"{quoted(str(place))} is {kind}; expected a folder, or nothing", failure.errno
        ) from None
    return folder


def _regular(path: Path, followed: bool = True) -> Path:
    """Return where `path` leads; refuse what is no regular file, may not be changed, or was read."""
    if not followed and path.is_symlink():
        raise OutputError(
            path, "that is a symlink, which is left alone; expected a file, or nothing"
        )
    target = Path(os.path.realpath(path))
    try:
        mode = target.stat().st_mode
    except FileNotFoundError:
        return target
    if not stat.S_ISREG(mode):
        kind = "a folder" if stat.S_ISDIR(mode) else "no regular file"
        raise OutputError(path, f"that is {kind}, which is left alone; expected a file, or nothing")
    if not os.access(target, os.W_OK):
        raise OutputError(path, "that file may not be written")
    check_no_input(path, target)
    return target


def _probe(folder: Path) -> None:
    with workplace(folder) as place, (place / "trial").open("wb") as file:
        file.write(bytes(PROBE))
        file.flush()
        os.fsync(file.fileno())
    synced(folder)


@contextmanager
def refused_as_output(path: str | PathLike[str]) -> Iterator[None]:
    """Turn errors of the operating system into the typed error that names what was to be written."""
    if not isinstance(path, str | PathLike):
        raise DomainError("path", path, "the path of a file or folder")
    if not os.fspath(path):
        raise OutputError(path, "an empty name; expected the path of a file or folder")
    try:
        yield
    except OutputError:
        raise
    except OSError as failure:
        _interrupted(failure)
        why, other = failure.strerror or str(failure), failure.filename
        known = Path(path).name
        if other is not None and ".geomint-" not in str(other) and Path(other).name != known:
            why = f"{why}: {quoted(other)}"
        raise OutputError(path, why, failure.errno) from failure
    except UnicodeEncodeError as failure:
        raise OutputError(path, "its name has characters that no name can have") from failure
    except ValueError as failure:
        _interrupted(failure)
        if "null" not in str(failure):  # no name of a file has a null character
            raise
        raise OutputError(path, str(failure)) from failure


def _interrupted(failure: BaseException) -> None:
    """Raise the KeyboardInterrupt of which an error is but what it left half done, if it is one."""
    before = failure.__context__
    while before is not None:
        if isinstance(before, KeyboardInterrupt):
            raise before from None
        before = before.__context__
