"""Folders that nobody else can write to: files in them are unpickled and run.

Every folder on the way belongs to the user or to root, and others may not write to it, or, as in
``/tmp``, not remove the user's own; so do the links that lead there, each in such a folder. Whenever
a file is read or written, each folder is opened beneath the one before, and the file beneath the last
one: who swaps a folder swaps nothing that is held. What is not private is left as it is, and another
folder is taken. A file is replaced if it is one of the user's under its name; nothing is removed. It
begins with a checksum of its name and its content.
"""

import functools
import hashlib
import os
import secrets
import stat
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

import platformdirs

MOST_LINKS = 40
_CHECKSUM = hashlib.sha256().digest_size
OTHERS = (stat.S_IWGRP | stat.S_IWOTH) * (os.name == "posix")
_user = getattr(os, "geteuid", lambda: 0)
_HELD = os.open in os.supports_dir_fd
_FILE = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)  # a FIFO would wait
# Folders that one may not read can be passed through.
_FOLDER = getattr(os, "O_DIRECTORY", 0) | getattr(os, "O_PATH", getattr(os, "O_SEARCH", 0)) | _FILE


def private_folder(name: str) -> "PrivateFolder":
    """Return a folder for what is kept: under ``NUMBA_CACHE_DIR``, else the user's cache folder.

    Raises
    ------
    OSError
        Why neither is there, is the user's alone, or can be made.
    """
    failures: list[str] = []
    for root in _roots():
        try:
            if root is None:
                raise OSError("folders cannot be held open on this system")
            found = PrivateFolder(Path(root, name).absolute(), "; ".join(failures))
            with found.held():
                return found
        except OSError as failure:
            failures.append(str(failure))
    raise OSError("; ".join(failures) or "there is no home folder")


def _roots() -> Iterator[Path | None]:
    if given := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(given, "geomint") if _HELD else None
    with suppress(RuntimeError):  # neither HOME nor an entry of the user
        own = platformdirs.user_cache_path("geomint")
        if own.is_absolute():
            yield own
        if "XDG_CACHE_HOME" in os.environ:
            yield Path("~/.cache/geomint").expanduser()


class PrivateFolder(NamedTuple):
    """A folder that is the user's alone, made if it is not there.

    Attributes
    ----------
    path : Path
    instead_of : str
        Why the folder that was wanted is not taken; empty if it is.
    """

    path: Path
    instead_of: str

    @contextmanager
    def held(self) -> Iterator[tuple[int | None, str]]:
        """Hold the folder, and all on the way to it; give the last one, and what names begin with."""
        if not _HELD:
            self.path.mkdir(parents=True, exist_ok=True)
            yield None, f"{self.path}{os.sep}"
            return
        left, place, here, links = [*reversed(self.path.parts)], Path(), None, MOST_LINKS
        with ExitStack() as ends:
            while left:
                name = left.pop()
                try:
                    found = os.lstat(name, dir_fd=here)
                except FileNotFoundError:
                    with suppress(FileExistsError):  # another process has made it
                        os.mkdir(name, 0o700, dir_fd=here)
                    found = os.lstat(name, dir_fd=here)
                if stat.S_ISLNK(found.st_mode) and links:
                    if found.st_uid not in (0, _user()):
                        raise PermissionError(f"{place / name}, a link, belongs to another user")
                    left += reversed(Path(os.readlink(name, dir_fd=here)).parts)
                    links -= 1
                    continue
                here, place = os.open(name, _FOLDER, dir_fd=here), place / name
                ends.callback(os.close, here)
                _check(os.fstat(here), place, not left)
            yield here, ""

    def read(self, name: str) -> bytes | None:
        """Return the content of a file; None if there is none that is whole and the user's alone."""
        with (
            self.held() as (here, before),
            suppress(OSError),
            open(before + name, "rb", opener=_opener(here)) as file,
        ):
            found = os.fstat(file.fileno())
            if _own(found) and not found.st_mode & OTHERS:
                checksum, content = file.read(_CHECKSUM), file.read()
                return content if checksum == _checksum(name, content) else None
        return None

    def write(self, name: str, content: bytes) -> None:
        """Write a file, whole or not at all, in place of one of the user's that has that name."""
        with self.held() as (here, before), ExitStack() as undone:
            place, unfinished = before + name, f"{before}{name}.{secrets.token_hex(8)}"
            with suppress(FileNotFoundError):
                if not _own(os.lstat(place, dir_fd=here)):
                    raise FileExistsError(f"{self.path / name} is no file of geomint's: left alone")
            with open(unfinished, "xb", opener=_opener(here)) as file:
                undone.callback(os.unlink, unfinished, dir_fd=here)
                file.write(_checksum(name, content) + content)
            os.replace(unfinished, place, src_dir_fd=here, dst_dir_fd=here)
            undone.pop_all()


def _checksum(name: str, content: bytes) -> bytes:
    return hashlib.sha256(name.encode() + b"\0" + content).digest()


def _opener(here: int | None) -> Callable[[str, int], int]:
    """Return what opens a file in a folder, without following a link."""
    return lambda path, flags: os.open(path, flags | _FILE, 0o600, dir_fd=here)


def _own(found: os.stat_result) -> bool:
    """Tell whether that is a regular file of the user."""
    return stat.S_ISREG(found.st_mode) and found.st_uid == _user()


def _check(found: os.stat_result, place: Path, last: bool) -> None:
    """Refuse a folder that somebody else may change, or may have changed."""
    own = found.st_uid == _user() or not (last or found.st_uid)
    if found.st_mode & OTHERS and (last or not found.st_mode & stat.S_ISVTX):
        listed = hasattr(os, "listxattr") and "system.posix_acl_access" in os.listxattr(place)
        own &= not found.st_mode & stat.S_IWOTH and not listed and _alone(found.st_gid, _user())
    if not own:
        raise PermissionError(f"{place} belongs to another user, or others may write to it")


@functools.cache
def _alone(number: int, user_id: int) -> bool:
    """Tell whether the user is alone in a group, which may write then, as with a umask of 002."""
    import grp  # not on Windows
    import pwd

    try:
        name, group = pwd.getpwuid(user_id).pw_name, grp.getgrgid(number)
    except KeyError:
        return False
    members = {user.pw_name for user in pwd.getpwall() if user.pw_gid == number}
    return {name} == {group.gr_name, *group.gr_mem, *members}
