"""An on-disk cache of compiled code that a change anywhere in the sources empties.

numba stamps a cached function with its own source file only: after an edit of a helper, stale
machine code would run silently. Every dispatcher made by geomint instead carries a stamp of the
compiler's sources (`geomint.kernels.sources`) and of everything that the function reaches, wherever
it is written (`Recorded.fingerprint`). The files lie in the user's cache folder
(`geomint.kernels.compiling.private`), so an installation that cannot be written works too;
``NUMBA_CACHE_DIR`` moves them. Where there is no such folder that is the user's alone, every process
compiles anew; `take_note` says once what is not as it was wanted.

A file holds the code of one function for one signature: what is damaged, of another process that runs
at the same time, or of somebody else is compiled anew.
"""

from __future__ import annotations

import errno
import functools
import hashlib
import os
import pickle
import re
import sys
from collections.abc import Callable
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core import config as _config, types
from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from .. import STARTED, sources
from ..numbers.typing_addresses import AddressesType
from .beside import other
from .private import PrivateFolder, private_folder

_FUNCTIONS = (types.FunctionType, types.BaseTuple, AddressesType)
config: Any = _config
_notes: dict[str, str] = {}  # by kind, each of which is told once


@functools.cache
def kernel_stamp() -> str:
    """Return a hash of the compiler's source files, of Python, numpy and numba."""
    versions = (sys.implementation.cache_tag, *(m.__version__ for m in (numba, llvmlite, np)))
    digest = hashlib.sha256(" ".join(versions).encode())
    for path in sources():
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


@functools.cache
def sources_edited() -> bool:
    """Tell whether the stamp is of other sources than this process runs, or may be."""
    if edited := not STARTED or sources() != STARTED:
        why = (
            "sources of geomint are not there, or changed after this process began; start it again"
        )
        _notes.setdefault("edited", f"compiled code is not kept: {why}")
    return edited


def plain(name: str) -> str:
    """Return what is left of a name, whoever gave it, in a file's name and a symbol."""
    return re.sub(r"\W", "_", name, flags=re.ASCII)[:40]


def cache_folder() -> PrivateFolder:
    """Return the folder of the compiled code of this version of the compiler."""
    # Bounds checking is not part of numba's own key: such code lives in a folder of its own.
    return private_folder(f"kernels-{kernel_stamp()}{'-boundscheck' * bool(config.BOUNDSCHECK)}")


def take_note() -> str:
    """Return why compiled code is not kept where it was wanted, once a process; empty if it is."""
    for kind, note in _notes.items():
        if note:
            _notes[kind] = ""
            return note
    return ""


class StampedCache(NullCache):
    """The cache of one dispatcher; `fingerprint` stands for all that its code depends on.

    None, if the code is not to be `kept` for other processes, or there is no place for it.

    A file for each signature. No index: processes that compile different signatures at the same time
    do not meet.
    """

    def __init__(self, py_func, fingerprint: str, on_miss: Callable[[], None], kept: bool) -> None:
        self._fingerprint, self._on_miss = fingerprint, on_miss
        self._folder = _found() if kept else None
        self._base = f"{plain(py_func.__name__)}-{fingerprint}"
        self._checked = config.BOUNDSCHECK

    def load_overload(self, sig, target_context):
        name = self._name(sig, target_context.codegen())
        code = self._code(name, sig, target_context)
        helped = code is None and self._folder and "failed" not in _notes
        # What takes no functions, as those of problems, is compiled quickly.
        kernel = any(isinstance(x, _FUNCTIONS) for x in getattr(sig, "args", sig))
        if helped and (beside := other(name, kernel)):
            if beside.waited(name):
                code = self._code(name, sig, target_context)
            if code is None:
                beside.tell(name)
        if code is None:
            self._on_miss()
        return code

    def _code(self, name: str, sig, target_context):
        """Return the code that a file holds; None if there is none."""
        # Nothing of what numba knows about types is needed to load code: it takes 0.3 s to import.
        try:
            if not (self._folder and (content := self._folder.read(name))):
                return None
            code = CompileResult._rebuild(target_context, *pickle.loads(content))
        except OSError as failure:
            _note(failure)
            return None
        except Exception:  # of another compiler with the same checksum: compile anew
            return None
        # Types of one name need not be the same.
        same = tuple(code.signature.args) == tuple(getattr(sig, "args", sig))
        return code if same else None

    def save_overload(self, sig, data) -> None:
        name = self._name(sig, data.codegen)
        try:
            other_checks = self._checked != config.BOUNDSCHECK  # which numba reads anew
            alone = data.library.has_dynamic_globals or any(not x.can_cache for x in data.lifted)
            if self._folder and not (alone or other_checks or sources_edited.__wrapped__()):
                self._folder.write(name, dumps(data._reduce()))
        except OSError as failure:
            _note(failure)
        except RuntimeError:  # of code that was broken off: it runs here, and is compiled elsewhere
            pass

    def _name(self, sig, codegen) -> str:
        key = (sig, codegen.magic_tuple(), self._fingerprint)
        digest = hashlib.sha256(repr(key).encode()).hexdigest()
        return f"{self._base}.{digest[:16]}.nbc"


def _found() -> PrivateFolder | None:
    """Return the folder of code, or None where there is no place for one."""
    try:
        found = cache_folder()
    except OSError as failure:
        _note(failure)
        return None
    if found.instead_of:
        _notes.setdefault(
            "elsewhere",
            f"compiled code is kept in {found.path}, not where it was asked for: {found.instead_of}; "
            "let NUMBA_CACHE_DIR name a folder that nobody else can write to",
        )
    return found


def _note(failure: OSError) -> None:
    """Keep why something could not be kept; on Windows files that others have open are no reason."""
    if os.name != "nt" or failure.errno != errno.EACCES:
        _notes.setdefault(
            "failed",
            f"compiled code cannot be kept, every process compiles anew: {failure}; let "
            "NUMBA_CACHE_DIR name a folder that can be written, and by nobody else",
        )
