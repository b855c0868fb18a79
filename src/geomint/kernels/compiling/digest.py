"""A digest of what a value is made of: the same in every process, another one for another value.

`geomint.kernels.compiling.sameness` compares two values of one process; this one can be written down.
"""

import functools
import hashlib
import sys
import types
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from .cache import kernel_stamp
from .code import CONSTANTS, constant, framed
from .sameness import contents, made_of, parts_of
from .walk import Wrapped

# What is told by its name: the stamp and the versions below say which it is.
_STAMPED = {"geomint", "numpy", "scipy", "numba", "llvmlite", "mpmath", *sys.stdlib_module_names}
_IN_CLASSES = (types.FunctionType, property, classmethod, staticmethod, *CONSTANTS)


def digest(value) -> str:
    """Return 32 digits of what a value is made of: arrays bit by bit, functions by their code."""
    return _Digests().of(value).hex()[:32]


class _Digests:
    """Digests of what has been met, by identity; what holds itself is told by its number."""

    def __init__(self) -> None:
        self._met: dict[int, tuple[bytes, Any]] = {}  # with the value, so that its id stays its own

    def of(self, value) -> bytes:
        if isinstance(value, np.generic):
            value = value.item()  # what a user computed is what a user wrote
        if type(value) in CONSTANTS:
            return hashlib.sha256(constant(value)).digest()
        if id(value) in self._met:
            return self._met[id(value)][0]
        self._met[id(value)] = b"%d" % len(self._met), value
        found = hashlib.sha256(self._content(value)).digest()
        self._met[id(value)] = found, value
        return found

    def _content(self, value) -> bytes:
        if isinstance(value, types.ModuleType):
            return framed(b"module", value.__name__.encode())
        if isinstance(value, type):
            return self._of_class(value)
        if isinstance(value, set | frozenset):  # in an order that is not the process's own
            return framed(b"set", *sorted(map(self.of, value)))
        if isinstance(value, types.FunctionType) and _stamped(value.__module__):
            cells = [contents(cell) for cell in value.__closure__ or ()]
            return framed(b"function", _name(value), *map(self.of, cells))
        if isinstance(value, property):
            return framed(b"property", *map(self.of, (value.fget, value.fset, value.fdel)))
        if isinstance(value, classmethod | staticmethod):
            return framed(_name(type(value)), self.of(value.__func__))
        parts = parts_of(value)
        if parts is None:
            parts = made_of(value)
        if parts is None:  # found by its name, such as a function of numpy
            return framed(b"named", _name(value))
        # A part that is a tuple, as of a cell, is one of a kind: only its content counts.
        plain = isinstance(value, list | tuple | Mapping | np.ndarray | Wrapped)
        kind = type(value).__name__.encode() if plain else self.of(type(value))
        return framed(kind, *map(self.of, parts))

    def _of_class(self, kind: type) -> bytes:
        """Return a class by its name, with its own code where no stamp stands for it."""
        if _stamped(kind.__module__):
            return framed(b"class", _name(kind))
        own = {
            name: x
            for name, x in vars(kind).items()
            if isinstance(x, _IN_CLASSES) and name not in ("__module__", "__doc__")
        }
        bases = map(self.of, kind.__bases__)
        code = (framed(name.encode(), self.of(own[name])) for name in sorted(own))
        return framed(b"class", _name(kind), *bases, *code)


def _stamped(module) -> bool:
    return isinstance(module, str) and module.partition(".")[0] in _STAMPED


def _name(value) -> bytes:
    names = (getattr(value, name, "") for name in ("__module__", "__qualname__", "__name__"))
    return " ".join(map(str, (type(value).__name__, *names))).encode()


@functools.cache
def source_stamp() -> str:
    """Return a hash of geomint's sources, of Python, numpy and the compiler."""
    stamp = hashlib.sha256(kernel_stamp().encode())
    for path in sorted(filter(Path.is_file, Path(__file__).parents[2].rglob("*.py"))):
        stamp.update(path.read_bytes())
    return stamp.hexdigest()


def versions_of_numbers() -> str:
    """Return in words the versions of all that numbers may depend on."""
    told = [f"Python {sys.version_info.major}.{sys.version_info.minor}"]
    for name in ("numpy", "scipy", "numba", "llvmlite", "mpmath"):
        try:
            told.append(f"{name} {metadata.version(name)}")
        except metadata.PackageNotFoundError:
            continue
    return f"sources {source_stamp()[:12]}, {', '.join(told)}"
