"""Folders that nobody else can write to: files in them are unpickled and run.

Every folder on the way belongs to the user or to root, and others may not write to it, or, as in
``/tmp``, not remove the user's own. Whenever a file is read or written, each is opened beneath the
one before, and the file beneath the last one, without following links: who swaps a folder swaps
nothing that is held. What is not private is left as it is, and another folder is taken. A file is
replaced if it is one of the user's under its name; nothing is removed.
"""

import errno
import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import platformdirs

OTHERS = stat.S_IWGRP | stat.S_IWOTH
_POSIX = os.name == "posix"
_HELD = {os.open, os.mkdir, os.stat, os.rename, os.unlink} <= os.supports_dir_fd
_FLAGS = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
# One may pass through folders that one may not read.
_FOLDER = _FLAGS | getattr(os, "O_DIRECTORY", 0) | getattr(os, "O_PATH", getattr(os, "O_SEARCH", 0))
_READ = _FLAGS | os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)  # a FIFO would wait
_NEW = _FLAGS | os.O_WRONLY | os.O_CREAT | os.O_EXCL


def private_folder(name: str) -> "PrivateFolder":
    """Return a folder for what is kept: under ``NUMBA_CACHE_DIR``, else the user's cache folder.

    Raises
    ------
    OSError
        Why neither is there, is the user's alone, or can be made.
    """
    failures: list[OSError] = []
    for root in _roots():
        try:
            if root is None:
                raise OSError(errno.ENOTSUP, "folders cannot be held open on this system")
            found = PrivateFolder(Path(root, name).absolute(), str(*failures[:1]))
            with found.held():
                return found
        except OSError as failure:
            failures.append(failure)
    none = FileNotFoundError(errno.ENOENT, "no home folder; set NUMBA_CACHE_DIR to another one")
    raise (*failures, none)[0]


def _roots() -> Iterator[Path | None]:
    if given := os.environ.get("NUMBA_CACHE_DIR"):
        yield Path(given, "geomint") if _HELD else None
    with suppress(RuntimeError):  # neither HOME nor an entry of the user
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

    def __init__(self, path: Path, instead_of: str) -> None:
        self.path, self.instead_of = path, instead_of

    @contextmanager
    def held(self) -> Iterator[int | None]:
        """Hold the folder open, and all on the way to it; None where that cannot be."""
        last = Path(os.path.realpath(self.path))
        with ExitStack() as ends:
            here = None
            if not _HELD:
                last.mkdir(mode=0o700, parents=True, exist_ok=True)
            for place in (*reversed(last.parents), last):
                if _HELD:
                    here = _beneath(here, place)
                    ends.callback(os.close, here)
                _check(os.stat(place if here is None else here), place, place == last)
            for place in self.path.parents:  # who leads the user elsewhere by links
                _check(place.stat(), place, False)
            yield here

    def read(self, name: str) -> bytes | None:
        """Return the content of a file; None if there is none that is the user's alone."""
        with self.held() as here:
            try:
                descriptor = os.open(self._place(name, here), _READ, dir_fd=here)
            except OSError:  # also a link, a socket
                return None
            try:
                found = os.fstat(descriptor)
                if not _own(found) or (_POSIX and found.st_mode & OTHERS):
                    return None
                with open(descriptor, "rb", closefd=False) as file:
                    return file.read()
            finally:
                os.close(descriptor)

    def write(self, name: str, content: bytes) -> None:
        """Write a file, whole or not at all, in place of one of the user's that has that name."""
        with self.held() as here:
            place = self._place(name, here)
            with suppress(FileNotFoundError):
                if not _own(os.lstat(place, dir_fd=here)):
                    told = "this is no file of geomint's, and left alone"
                    raise FileExistsError(errno.EEXIST, told, str(self.path / name))
            unfinished = f"{place}.{secrets.token_hex(8)}"
            descriptor = os.open(unfinished, _NEW, 0o600, dir_fd=here)
            try:
                with open(descriptor, "wb") as file:
                    file.write(content)
                os.replace(unfinished, place, src_dir_fd=here, dst_dir_fd=here)
            except BaseException:
                os.unlink(unfinished, dir_fd=here)
                raise

    def _place(self, name: str, here: int | None) -> str:
        return str(self.path / name) if here is None else name


def _own(found: os.stat_result) -> bool:
    """Tell whether that is a regular file of the user."""
    return stat.S_ISREG(found.st_mode) and not (_POSIX and found.st_uid != os.geteuid())


def _beneath(here: int | None, place: Path) -> int:
    """Open a folder in another one that is held; make it if it is not there."""
    name = place.name or "/"
    try:
        with suppress(FileNotFoundError):
            return os.open(name, _FOLDER, dir_fd=here)
        with suppress(FileExistsError):  # another process was first
            os.mkdir(name, 0o700, dir_fd=here)
        return os.open(name, _FOLDER, dir_fd=here)
    except OSError as failure:
        raise OSError(failure.errno, failure.strerror, str(place)) from failure


def _check(found: os.stat_result, place: Path, last: bool) -> None:
    """Refuse a folder that somebody else may change, or may have changed."""
    if not _POSIX:
        return
    if found.st_uid != os.geteuid() and (last or found.st_uid != 0):
        raise PermissionError(errno.EPERM, "a folder of another user", str(place))
    if _open_to_others(place, found) and (last or not found.st_mode & stat.S_ISVTX):
        raise PermissionError(errno.EPERM, "a folder that others may write to", str(place))


def _open_to_others(place: Path, found: os.stat_result) -> bool:
    """Tell whether others may write; the group may where it is the user's own, as with umask 002."""
    if not found.st_mode & OTHERS:
        return False
    import grp  # not on Windows
    import pwd

    try:
        name, group = pwd.getpwuid(os.geteuid()).pw_name, grp.getgrgid(found.st_gid)
    except KeyError:
        return True
    members = {user.pw_name for user in pwd.getpwall() if user.pw_gid == group.gr_gid}
    own = {name} == {group.gr_name, *group.gr_mem, *members}
    listed = hasattr(os, "listxattr") and "system.posix_acl_access" in os.listxattr(place)
    return bool(found.st_mode & stat.S_IWOTH) or listed or not own
