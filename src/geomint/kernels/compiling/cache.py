"""An on-disk cache of compiled code that a change anywhere in the sources empties.

numba stamps a cached function with its own source file only: after an edit of a helper, stale
machine code would run silently. Every dispatcher made by geomint instead carries a stamp of the
kernel layer's sources and of everything that the function reaches (`Recorded.fingerprint`). The
files lie in the user's cache folder (`geomint.kernels.compiling.private`), so an installation that
cannot be written works too; ``NUMBA_CACHE_DIR`` moves them. Where that folder cannot be written
either, every process compiles anew, and `take_failure` says why.

A file holds the code of one function for one signature, after its checksum: what is damaged, of
another process that runs at the same time, or of somebody else is compiled anew.
"""

from __future__ import annotations

import errno
import functools
import hashlib
import os
import pickle
import secrets
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core import config as _config
from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from .. import STARTED
from .beside import other
from .private import cache_root, private_folder

_KERNELS = Path(__file__).parents[1]
config: Any = _config
_CHECKSUM = hashlib.sha256().digest_size
_failures: list[OSError] = []
_failure_taken = False
_ROOMS = tuple(f"geomint.kernels.{room}." for room in ("solve", "tangent", "groups"))


@functools.cache
def kernel_stamp() -> str:
    """Return a hash of every source file of the kernel layer, of Python, numpy and the compiler."""
    versions = (sys.implementation.cache_tag, *(m.__version__ for m in (numba, llvmlite, np)))
    digest = hashlib.sha256(" ".join(versions).encode())
    for path in _sources():
        digest.update(str(path.relative_to(_KERNELS)).encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _sources() -> list[Path]:
    return sorted(_KERNELS.rglob("*.py"))


@functools.cache
def sources_edited() -> bool:
    """Tell whether the stamp is of other sources than this process runs, or may be."""
    return any(path.stat().st_mtime > STARTED for path in _sources())


def cache_folder() -> Path:
    """Return the folder of the compiled code of this version of the kernel layer."""
    # Bounds checking is not part of numba's own key: such code lives in a folder of its own.
    checked = "-boundscheck" if config.BOUNDSCHECK else ""
    return cache_root() / f"kernels-{kernel_stamp()}{checked}"


def take_failure() -> OSError | None:
    """Return why compiled code could not be kept, once a process; None if nothing failed."""
    global _failure_taken
    if not _failures or _failure_taken:
        return None
    _failure_taken = True
    return _failures[0]


class StampedCache(NullCache):
    """The cache of one dispatcher; `fingerprint` stands for all that its code depends on.

    A file for each signature, checksum first. No index: processes that compile different signatures
    at the same time do not meet.
    """

    def __init__(self, py_func, fingerprint: str, on_miss: Callable[[], None]) -> None:
        self._fingerprint, self._on_miss = fingerprint, on_miss
        self._folder = cache_folder()
        self._base = f"{py_func.__name__.strip('<>')}-{fingerprint}"
        # Functions of problems are compiled quickly.
        self._kernel = str(py_func.__module__).startswith(_ROOMS)

    @property
    def cache_path(self) -> str:
        return str(self._folder)

    def load_overload(self, sig, target_context):
        path = self._path(sig, target_context.codegen())
        code = self._code(path, sig, target_context)
        if code is None and not _failures and (beside := other(path.name, self._kernel)):
            if beside.waited(path.name):
                code = self._code(path, sig, target_context)
            if code is None:
                beside.tell(path.name)
        if code is None:
            self._on_miss()
        return code

    def _code(self, path: Path, sig, target_context):
        """Return the code that a file holds; None if there is none."""
        # Nothing of what numba knows about types is needed to load code: it takes 0.3 s to import.
        try:
            found = self._load(path)
            code = found and CompileResult._rebuild(target_context, *found)
        except OSError as failure:
            _note(failure)
            return None
        except Exception:  # of another compiler with the same checksum: compile anew
            return None
        # Types of one name need not be the same.
        same = code is not None and tuple(code.signature.args) == tuple(getattr(sig, "args", sig))
        return code if same else None

    def save_overload(self, sig, data) -> None:
        path = self._path(sig, data.codegen)
        try:
            if not (data.library.has_dynamic_globals or any(not x.can_cache for x in data.lifted)):
                private_folder(self._folder)
                self._save(path, dumps(data._reduce()))
        except OSError as failure:
            _note(failure)
        except RuntimeError:  # of code that was broken off: it runs here, and is compiled elsewhere
            pass
        if beside := other(path.name, False):
            beside.tell("")

    def flush(self) -> None:
        for path in self._folder.glob(f"{self._base}.*.nbc"):
            path.unlink(missing_ok=True)

    def _path(self, sig, codegen) -> Path:
        key = (sig, codegen.magic_tuple(), self._fingerprint)
        digest = hashlib.sha256(repr(key).encode()).hexdigest()
        return self._folder / f"{self._base}.{digest[:16]}.nbc"

    def _load(self, path: Path):
        private_folder(self._folder)  # what is in it is unpickled
        if not path.is_file():  # nor a FIFO, which would wait for ever
            return None
        content = path.read_bytes()
        checksum, data = content[:_CHECKSUM], content[_CHECKSUM:]
        return pickle.loads(data) if hashlib.sha256(data).digest() == checksum else None

    def _save(self, path: Path, content: bytes) -> None:
        unfinished = path.with_suffix(f".{secrets.token_hex(8)}")
        try:
            unfinished.write_bytes(hashlib.sha256(content).digest() + content)
            unfinished.replace(path)
        finally:
            unfinished.unlink(missing_ok=True)


def _note(failure: OSError) -> None:
    """Keep why something could not be kept; on Windows files that others have open are no reason."""
    if os.name != "nt" or failure.errno != errno.EACCES:
        _failures.append(failure)


def make_cache(
    py_func, fingerprint: str, on_miss: Callable[[], None]
) -> StampedCache | UnkeptCache:
    """Return a cache on the disk, or none where there is no place for it."""
    try:
        return StampedCache(py_func, fingerprint, on_miss)
    except OSError as failure:
        _failures.append(failure)
        return UnkeptCache(on_miss)


class UnkeptCache(NullCache):
    """No cache: for code that no other process may run."""

    def __init__(self, on_miss: Callable[[], None]) -> None:
        self._on_miss = on_miss

    def load_overload(self, sig, target_context) -> None:
        self._on_miss()
