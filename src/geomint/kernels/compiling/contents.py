"""What a value is made of, said once: for fingerprints, for digests, and for equality.

A value is words that say what it is, and parts that are values again: of an array its bits, of a
function its code, defaults, cells and what its names lead to, of an object its fields or what pickle
would make it of. `geomint.kernels.compiling.fingerprint` goes the same way with eyes of its own: for
what numba freezes, and for what changes later.
"""

import builtins
import dataclasses
import enum
import hashlib
import sys
import types
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from .code import CONSTANTS, Path, constant, described, framed

Made = tuple[Iterable[Any], Iterable[Any]]  # words, which are bytes or become strings, and parts
# What is told by its name, as versions and a stamp of sources say which it is.
_STAMPED = {"geomint", "numpy", "scipy", "numba", "llvmlite", "mpmath", *sys.stdlib_module_names}
_IN_CLASSES = (types.FunctionType, property, classmethod, staticmethod, *CONSTANTS)


class MISSING:
    """In place of what is not there; a class, so that it is itself where it is sent to."""


class Wrapped:
    """What stands for a Python function in compiled code."""

    function: Any  # a function; declared as such, mypy would take it for a method
    inline: bool
    fingerprint: Any


class Contents:
    """Digests of values. What has been met is known by identity; what holds itself, by its number.

    Attributes
    ----------
    place : str
        Where what is looked at was found, in words.
    """

    def __init__(self) -> None:
        self.place = ""
        self._met: dict[int, tuple[bytes, Any]] = {}  # with the value, so that its id stays its own

    def of(self, value) -> bytes:
        """Return what is the same for values that are made of the same, and for no others."""
        if type(value) in CONSTANTS:
            return constant(value)
        found, _ = self._met.get(id(value), (None, None))
        if found is None:
            self._met[id(value)] = b"%d" % len(self._met), value
            place, (words, parts) = self.place, self.parts(value)
            said = (word if isinstance(word, bytes) else str(word).encode() for word in words)
            found = hashlib.sha256(framed(framed(*said), *map(self.of, parts))).digest()
            self._met[id(value)], self.place = (found, value), place
        return found

    def parts(self, value) -> Made:
        """Return words that say what a value is, and the values that it is made of."""
        known = (name for kinds, name in _KINDS.items() if isinstance(value, kinds))
        return getattr(self, next(known, "other"))(value)

    def function(self, function: types.FunctionType) -> Made:
        """Return its code and what it finds; modules that it reads from are told by their names."""
        paths, followed = described(function.__code__).paths, not _stamped(home_of(function))
        short = (path._replace(attributes=()) for path in paths if path.cell or followed)
        return self.body(function, dict.fromkeys(short))

    def body(self, function: types.FunctionType, paths: Iterable[Path]) -> Made:
        words = home_of(function), function.__module__, described(function.__code__).digest
        return words, self._read(function, paths)

    def _read(self, function: types.FunctionType, paths: Iterable[Path]) -> Iterator[Any]:
        self.place = f"a default of {function.__qualname__}"
        yield from (function.__defaults__, function.__kwdefaults__)
        for path in paths:
            self.place = f"{'.'.join((path.name, *path.attributes))} in {function.__qualname__}"
            found = None
            for space, name, found in looked_up(function, path):
                self.look(space, name, found, function)
            yield found  # None of a local variable

    def look(self, space, name: str, found, function: types.FunctionType | None = None) -> None:
        """Take note of where a function has found something."""

    def kind(self, value: type) -> Made:
        """Return a class by its name, with its own code where no stamp stands for it."""
        if _stamped(value.__module__):
            return ("class", name_of(value)), ()
        own = {name: x for name, x in sorted(vars(value).items()) if isinstance(x, _IN_CLASSES)}
        for name in ("__module__", "__doc__"):
            own.pop(name, None)
        return ("class", name_of(value), *own), [*value.__bases__, *own.values()]

    def array(self, value) -> Made:
        words = name_of(type(value)), value.dtype, value.shape
        if value.dtype.hasobject or isinstance(value, np.ma.MaskedArray):
            return words, (value.tolist(),)
        return (*words, value.tobytes()), ()

    def container(self, value) -> Made:
        words = name_of(type(value)), *getattr(value, "_fields", ())
        if isinstance(value, set | frozenset):  # in an order that is not the process's own
            return (*words, *sorted(map(self.of, value))), ()
        return words, [*value, *value.values()] if isinstance(value, Mapping) else value

    def other(self, value) -> Made:
        """Return an object as its fields, or as what pickle would make it of; else by its name."""
        for kinds, names in _ATTRIBUTES.items():
            if isinstance(value, kinds):
                return (), (type(value), *(getattr(value, name) for name in names.split()))
        fields = value._compared() if hasattr(type(value), "_compared") else fields_of(value)
        return self.unknown(value) if fields is None else ((), (type(value), *fields))

    def unknown(self, value) -> Made:
        """Return an object as what pickle would make it of; else by its name, as of numpy's."""
        try:
            made = value.__reduce_ex__(4)
        except Exception:  # of several types
            made = ""
        if not isinstance(made, str):
            items = (list(part) for part in made[3:5] if part is not None)
            return (), (type(value), *made[:3], *items)
        names = (getattr(value, x, "") for x in ("__module__", "__qualname__", "__name__"))
        return ("named", name_of(type(value)), *names), ()


_KINDS: dict[Any, str] = {
    types.FunctionType: "function",
    type: "kind",
    np.generic | np.ndarray: "array",
    list | tuple | Mapping | set | frozenset: "container",
}
_ATTRIBUTES: dict[Any, str] = {
    Wrapped: "fingerprint inline",
    types.ModuleType: "__name__",
    types.MethodType: "__func__ __self__",
    property: "fget fset fdel",
    classmethod | staticmethod: "__func__",
    enum.Enum: "_name_ _value_",
    slice | range: "start stop step",
}


def fields_of(value) -> list[Any] | None:
    """Return what a dataclass compares; None for what is of none."""
    if isinstance(value, type) or not dataclasses.is_dataclass(value):
        return None
    return [getattr(value, each.name) for each in dataclasses.fields(value) if each.compare]


def looked_up(function: types.FunctionType, path: Path) -> Iterator[tuple[Any, str, Any]]:
    """Yield where a path is looked up, by what name, and what is there; last, what it leads to.

    Through modules, up to the first value that is none. Nothing for a local variable that a function
    inside reads.
    """
    found: Any = MISSING
    if path.cell:
        cells = dict(zip(function.__code__.co_freevars, function.__closure__ or (), strict=True))
        if path.name not in cells:
            return
        found = content_of(cells[path.name])
        yield cells[path.name], path.name, found
    else:
        for space in (function.__globals__, vars(builtins)):
            if found is MISSING:
                found = space.get(path.name, MISSING)
                yield space, path.name, found
    for word in path.attributes:
        if not isinstance(found, types.ModuleType):
            break
        module, found = found, attribute(found, word)
        yield module, word, found


def attribute(module: types.ModuleType, word: str):
    """Return an attribute of a module, which may make it, and fail at it, in any way."""
    try:
        return getattr(module, word)
    except Exception:
        return MISSING


def content_of(cell: types.CellType):
    """Return what a closure cell holds, `MISSING` if nothing yet."""
    try:
        return cell.cell_contents
    except ValueError:
        return MISSING


def home_of(function: types.FunctionType) -> str:
    """Return the name of the module whose globals a function has, whatever it calls itself."""
    return str(function.__globals__.get("__name__"))


def name_of(cls: type) -> str:
    """Return the name of a class, with that of its module."""
    return f"{cls.__module__}.{cls.__qualname__}"


def _stamped(module) -> bool:
    return isinstance(module, str) and module.partition(".")[0] in _STAMPED
