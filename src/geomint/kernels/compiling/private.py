"""The user's cache folder: nobody else may write to it, for what is in it is unpickled and run."""

import errno
import functools
import os
import shutil
import stat
from pathlib import Path

import platformdirs

OTHERS = stat.S_IWGRP | stat.S_IWOTH


def cache_root() -> Path:
    """Return the folder under which everything is kept; nothing is made there.

    Raises
    ------
    FileNotFoundError
        If the user has no home and ``NUMBA_CACHE_DIR`` is not set.
    """
    base = os.environ.get("NUMBA_CACHE_DIR")
    if base:
        return Path(base).absolute() / "geomint"
    try:
        root = platformdirs.user_cache_path("geomint")
    except RuntimeError:
        root = Path("~")
    if not root.is_absolute():  # neither HOME nor an entry of the user
        raise FileNotFoundError(errno.ENOENT, "no home folder; set NUMBA_CACHE_DIR to another one")
    return root


@functools.cache
def private_folder(folder: Path) -> Path:
    """Make a folder that only the user may write to, or see that it is one; looked at once.

    Raises
    ------
    OSError
        If it cannot be made, or belongs to another user.
    """
    folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    folder.mkdir(mode=0o700, exist_ok=True)
    if os.name != "posix":
        return folder
    found = folder.stat()
    if found.st_uid != os.geteuid():
        raise PermissionError(errno.EPERM, f"{folder} belongs to another user")
    if found.st_mode & OTHERS:
        folder.chmod(stat.S_IMODE(found.st_mode) & ~OTHERS)
        try:
            for entry in folder.iterdir():  # of whom?
                if entry.is_dir() and not entry.is_symlink():
                    shutil.rmtree(entry)
                else:
                    entry.unlink()
        except OSError:
            folder.chmod(stat.S_IMODE(found.st_mode))  # nor may the next process trust what stays
            raise
    return folder
