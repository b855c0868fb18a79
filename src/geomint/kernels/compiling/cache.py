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
import re
import sys
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core import config as _config, types

from .. import STARTED, sources
from ..numba_inside import machine, packed, unpacked
from ..numbers.typing_addresses import AddressesType
from .beside import other
from .fingerprint import Reach
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


class KeptCode:
    """The file of a function's code for a signature; its name says all that the code depends on.

    There is none if the code is not for other processes, or there is no place for it. Nor is there an
    index: processes that compile at the same time do not meet.
    """

    def __init__(self, name: str, reach: Reach, signature) -> None:
        key = repr((signature, machine(), reach.fingerprint)).encode()
        digest = hashlib.sha256(key).hexdigest()[:16]
        self.name = f"{plain(name)}-{reach.fingerprint}.{digest}.nbc"
        self._arguments, self._checked = tuple(signature.args), config.BOUNDSCHECK
        self._folder = _found() if reach.kept and not sources_edited() else None

    def load(self):
        """Return the code if it is there, or the process beside this one is at it; else None."""
        code = self._read()
        # What takes no functions, as those of problems, is compiled quickly.
        kernel = any(isinstance(x, _FUNCTIONS) for x in self._arguments)
        helped = code is None and self._folder and "failed" not in _notes
        if helped and (beside := other(self.name, kernel)):
            if beside.waited(self.name):
                code = self._read()
            if code is None:
                beside.tell(self.name)
        return code

    def _read(self):
        try:
            if not (self._folder and (content := self._folder.read(self.name))):
                return None
            code = unpacked(content)
        except OSError as failure:
            _note(failure)
            return None
        except Exception:  # of another compiler with the same checksum: compile anew
            return None
        # Types of one name need not be the same.
        return code if tuple(code.signature.args) == self._arguments else None

    def save(self, code) -> None:
        """Write the code, if others can use it."""
        other_checks = self._checked != config.BOUNDSCHECK  # which numba reads anew
        try:
            wanted = self._folder and not (other_checks or sources_edited.__wrapped__())
            if self._folder and wanted and (content := packed(code)):
                self._folder.write(self.name, content)
        except OSError as failure:
            _note(failure)
        except RuntimeError:  # of code that was broken off: it runs here, and is compiled elsewhere
            pass


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
