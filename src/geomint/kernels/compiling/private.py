"""Folders that nobody else can write to, held open: files in them are unpickled and run.

Every folder on the way, through symlinks too, belongs to the user or to root, and others may not
write to it, or, as in ``/tmp``, not remove the user's own. Each is opened beneath the one before,
and files beneath the last one, without following links: who swaps a folder later swaps nothing that
is held. What is not private is left as it is, and another folder is taken.
"""

import contextlib
import errno
import functools
import os
import secrets
import stat
from collections.abc import Iterator
from pathlib import Path

import platformdirs

OTHERS = stat.S_IWGRP | stat.S_IWOTH
LINKS = 40  # on one way, at most
_HELD = os.name == "posix"  # elsewhere folders cannot be held open
_FLAGS = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0)
_FOLDER = _FLAGS | getattr(os, "O_DIRECTORY", 0)
_FILE = _FLAGS | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)  # a FIFO would wait


def private_folder(name: str) -> "PrivateFolder":
    """Return a folder for what is kept: under ``NUMBA_CACHE_DIR``, else the user's cache folder.

    Raises
    ------
    OSError
        Why neither is there, is the user's own, or can be made.
    """
    failures: list[OSError] = []
    for root in _roots():
        try:
            found = _opened(root / name)
        except OSError as failure:
            failures.append(failure)
            continue
        found.instead_of = str(failures[0]) if failures else ""
        return found
    if not failures:
        told = "no home folder; set NUMBA_CACHE_DIR to another one"
        raise FileNotFoundError(errno.ENOENT, told)
    raise failures[0]


def _roots() -> Iterator[Path]:
    given = os.environ.get("NUMBA_CACHE_DIR")
    if given:
        yield Path(given).absolute() / "geomint"
    with contextlib.suppress(RuntimeError):  # neither HOME nor an entry of the user
        own = platformdirs.user_cache_path("geomint")
        if own.is_absolute():
            yield own
            if "XDG_CACHE_HOME" in os.environ:
                yield Path("~/.cache/geomint").expanduser()


class PrivateFolder:
    """A folder that is the user's alone, made if it is not there.

    Attributes
    ----------
    path : Path
    instead_of : str
        Why the folder that was wanted is not taken; empty if it is.
    """

    def __init__(self, path: Path) -> None:
        self.path, self.instead_of = path, ""
        self._open()

    def _open(self) -> None:
        if _HELD:
            self._descriptor: int | None = _held(self.path)
        else:
            self.path.mkdir(mode=0o700, parents=True, exist_ok=True)
            self._descriptor = None

    def __del__(self) -> None:
        if getattr(self, "_descriptor", None) is not None:
            os.close(self._descriptor)  # type: ignore[arg-type]

    def read(self, name: str) -> bytes | None:
        """Return the content of a file; None if there is none that is the user's alone."""
        try:
            descriptor = os.open(self._place(name), _FILE, dir_fd=self._descriptor)
        except FileNotFoundError:
            return None
        except OSError as failure:
            if failure.errno in (errno.ELOOP, errno.EMLINK, errno.ENXIO):  # a link, a socket
                return None
            raise
        try:
            found = os.fstat(descriptor)
            own = not _HELD or (found.st_uid == os.geteuid() and not found.st_mode & OTHERS)
            if not (own and stat.S_ISREG(found.st_mode)):
                return None
            with open(descriptor, "rb", closefd=False) as file:
                return file.read()
        finally:
            os.close(descriptor)

    def write(self, name: str, content: bytes) -> None:
        """Write a file, whole or not at all, in place of whatever has that name."""
        try:
            self._write(name, content)
        except FileNotFoundError:  # the folder was removed meanwhile
            self._open()
            self._write(name, content)

    def _write(self, name: str, content: bytes) -> None:
        unfinished, here = self._place(f"{name}.{secrets.token_hex(8)}"), self._descriptor
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        descriptor = os.open(unfinished, flags, 0o600, dir_fd=here)
        try:
            with open(descriptor, "wb") as file:
                file.write(content)
            os.replace(unfinished, self._place(name), src_dir_fd=here, dst_dir_fd=here)
        except BaseException:
            os.unlink(unfinished, dir_fd=here)
            raise

    def _place(self, name: str) -> str:
        return name if self._descriptor is not None else str(self.path / name)


_opened = functools.cache(PrivateFolder)


def _held(path: Path) -> int:
    """Return a descriptor of a folder that is the user's alone, as is the way to it."""
    left, links = [*reversed(path.parts[1:])], 0
    here = os.open("/", _FOLDER)
    try:
        _check(here, Path("/"), bool(left))
        while left:
            name = left.pop()
            try:
                found = os.lstat(name, dir_fd=here)
            except FileNotFoundError:
                with contextlib.suppress(FileExistsError):  # another process was first
                    os.mkdir(name, 0o700, dir_fd=here)
                found = os.lstat(name, dir_fd=here)
            if stat.S_ISLNK(found.st_mode):
                links += 1
                if links > LINKS or found.st_uid not in (0, os.geteuid()):
                    raise PermissionError(errno.EPERM, f"{path}: the link {name!r} is not yours")
                target = Path(os.readlink(name, dir_fd=here))
                left += reversed(target.parts[1:] if target.is_absolute() else target.parts)
                if not target.is_absolute():
                    continue
                name = "/"
            below = os.open(name, _FOLDER, dir_fd=here)
            os.close(here)
            here = below
            _check(here, path, bool(left))
    except BaseException:
        os.close(here)
        raise
    return here


def _check(descriptor: int, path: Path, on_the_way: bool) -> None:
    """Refuse a folder that somebody else may change, or may have changed."""
    found = os.fstat(descriptor)
    if found.st_uid != os.geteuid() and not (on_the_way and found.st_uid == 0):
        whose = "a folder on the way" if on_the_way else "it"
        raise PermissionError(errno.EPERM, f"{path}: {whose} belongs to another user")
    if _open_to_others(descriptor, found) and not (on_the_way and found.st_mode & stat.S_ISVTX):
        what = "a folder on the way" if on_the_way else "it"
        raise PermissionError(errno.EPERM, f"{path}: others may write to {what}")


def _open_to_others(descriptor: int, found: os.stat_result) -> bool:
    """Tell whether others may write; the group may where it is the user's own, as with umask 002."""
    if not found.st_mode & OTHERS:
        return False
    import grp  # not on Windows
    import pwd

    try:
        user, group = pwd.getpwuid(os.geteuid()), grp.getgrgid(found.st_gid)
    except KeyError:
        return True
    own = (group.gr_gid, group.gr_name) == (user.pw_gid, user.pw_name)
    own &= set(group.gr_mem) <= {user.pw_name}
    listed = hasattr(os, "listxattr") and "system.posix_acl_access" in os.listxattr(descriptor)
    return bool(found.st_mode & stat.S_IWOTH) or listed or not own
