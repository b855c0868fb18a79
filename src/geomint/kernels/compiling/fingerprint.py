"""What a function reaches: one fingerprint of it, and whether it is still as it was.

numba compiles what a function reaches into machine code, and sees no later change. So that no stale
code runs, its contents are gone through once, as far as numba may freeze them, and where each value
was found is kept. `Reach.holds` looks there again: for the same objects, and for the same content of
those that can be changed.

Global names, closure cells, default values and attributes of modules are followed, through helpers,
containers and modules, to values that have a content. A module that is read other than by
``module.name`` (through a local variable, an argument, a result) counts with every attribute that is
named anywhere in the code that is reached.

What numba has compiled by itself keeps values where nobody can look: it is listed, and refused by
`geomint.kernels.compiling.foreign`, as is what has a numba type and no content that could be
hashed. Values without a numba type cannot be part of compiled code and count with their type alone.
"""

import ctypes
import enum
import hashlib
import itertools
import operator
import os
import types
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from .code import described, framed
from .contents import MISSING, Contents, Made, Wrapped, attribute, home_of, name_of

PACKAGE = __name__.partition(".")[0]  # which imports its public names on demand
# What the cache folder's name stands for: by the versions, and by the sources.
LIBRARIES = {"numpy", "numba", "llvmlite"}
COMPILER = (f"{PACKAGE}.kernels.compiling.", f"{PACKAGE}.kernels.numbers.")
KERNELS = (f"{PACKAGE}.kernels.", f"{PACKAGE}.methods.")  # sources that no process changes
BY_ADDRESS = 10**6  # bytes; larger arrays numba does not copy into the code
_BUILTIN = types.BuiltinFunctionType | types.MethodDescriptorType | types.WrapperDescriptorType
_CALLABLES: Any = _BUILTIN | np.ufunc | type(np.sum)
_STATE = operator.attrgetter("dtype", "shape", "strides", "flags.writeable")
_FOREIGN: Any = ctypes.CFUNCTYPE(None).__base__
_kernels: dict[types.FunctionType, str] = {}
_changes = itertools.count()
_process = os.urandom(16)


class Reach(Contents):
    """What a function reaches, as it is now.

    Attributes
    ----------
    fingerprint : str
        The same in every process for the same code and contents.
    kept : bool
        Whether compiled code may be kept on disk: all contents are known.
    compiled : list of (str, object)
        What numba has compiled by itself, and where it was found.
    others : list of (str, object)
        Callables and values whose content is not known, and where they were found.
    functions : dict
        All that are reached outside of kernels and of libraries, with what they were made of.
    """

    def __init__(
        self, function: Wrapped | types.FunctionType, within: tuple[types.FunctionType, ...] = ()
    ) -> None:
        super().__init__()
        self.kept = True
        self.compiled: list[tuple[str, Any]] = []
        self.others: list[tuple[str, Any]] = []
        self._names: dict[tuple[int, str], tuple[dict[str, Any], str, Any]] = {}
        self.functions: dict[types.FunctionType, tuple[Any, Any, Any]] = {}
        self._cells: dict[int, tuple[types.CellType, Any]] = {}
        self._tests: list[Callable[[], bool]] = []
        self._modules: list[types.ModuleType] = []  # that are handed on
        self._words: set[str] = set()
        self._within = within
        digest = hashlib.sha256(framed(self.of(function), *self._handed_on()))
        if not self.kept:  # no two of these are the same, here or elsewhere
            digest.update(_process + str(next(_changes)).encode())
        self.fingerprint = digest.hexdigest()[:24]

    @property
    def can_change(self) -> bool:
        """Whether there is anything to look at again: not of kernels alone."""
        return bool(self._names or self.functions or self._cells or self._tests)

    def holds(self) -> bool:
        """Tell whether all of it is still as it was: in a few microseconds for most functions."""
        for space, name, value in self._names.values():
            if space.get(name, MISSING) is not value:
                return False
        for function, (code, defaults, keywords) in self.functions.items():
            if function.__code__ is not code or function.__defaults__ is not defaults:
                return False
            if function.__kwdefaults__ is not keywords:
                return False
        try:
            for cell, value in self._cells.values():
                if cell.cell_contents is not value:
                    return False
            for test in self._tests:
                if not test():
                    return False
        except ValueError:  # a cell that holds nothing yet, or no more
            return False
        return True

    def _handed_on(self) -> Iterator[bytes]:
        """Count what may be read from modules that are handed on, until nothing new is met."""
        done: set[tuple[int, str]] = set()
        while pairs := {(i, x) for i in range(len(self._modules)) for x in self._words} - done:
            done |= pairs
            for i, word in sorted(pairs):
                module = self._modules[i]
                found = attribute(module, word)
                self.look(module, word, found)
                if found is not MISSING:
                    self.place = f"{module.__name__}.{word}"
                    yield framed(self.place.encode(), self.of(found))
        if self._modules:  # which numba's own functions for these keep
            self.compiled += [(p, v) for p, v in self.others if v is getattr or v is hasattr]

    def look(self, space, name: str, found, function: types.FunctionType | None = None) -> None:
        """Keep where something was found; sources of kernels do not change in a process."""
        if function is not None and home_of(function).startswith(KERNELS):
            return
        if isinstance(space, types.CellType):
            self._cells[id(space)] = space, found
        elif isinstance(space, types.ModuleType):
            present = vars(space).get(name, MISSING)
            if present is not found and space.__name__ != PACKAGE:  # made when it is asked for
                self._tests.append(lambda: attribute(space, name) is found)
            self.look(vars(space), name, present)
        else:
            self._names[id(space), name] = space, name, found

    def parts(self, value) -> Made:
        if isinstance(value, Wrapped):
            self.look(vars(value), "function", value.function)
            words, parts = self._followed(value.function)
            return ("recorded", value.inline, *words), parts
        if isinstance(value, types.ModuleType):
            self._modules.append(value)
        elif isinstance(value, enum.Enum):
            self.look(vars(value), "_value_", value._value_)
        elif isinstance(value, list | dict | set):
            self._tests.append(_unchanged(value))
        return super().parts(value)

    def function(self, function: types.FunctionType) -> Made:
        """Count a function that is not recorded: compiled code has an implementation instead."""
        home = home_of(function)
        self.others.append((self.place, function))
        if home.partition(".")[0] in LIBRARIES or home.startswith(COMPILER):
            return ("library", home, function.__qualname__), ()
        return self._followed(function)

    def _followed(self, function: types.FunctionType) -> Made:
        own, code = home_of(function).startswith(KERNELS), described(function.__code__)
        if own and function.__closure__ is None and function not in self._within:
            if function not in _kernels:  # found once a process
                _kernels[function] = Reach(function, (*self._within, function)).fingerprint
            return ("kernel", _kernels[function]), ()
        self._words |= code.words
        if not own:
            found = function.__code__, function.__defaults__, function.__kwdefaults__
            self.functions[function] = found
        return self.body(function, code.paths)

    def array(self, value) -> Made:
        masked = isinstance(value, np.ma.MaskedArray)
        if value.dtype.hasobject or value.dtype.char in "gG" or masked:
            return self.other(value)
        flags = value.flags
        if isinstance(value, np.ndarray | np.void):
            self._steady(lambda x: (*_STATE(x), x.tobytes()), value)
            contiguous = flags.c_contiguous or flags.f_contiguous
            self.kept = self.kept and contiguous and value.nbytes <= BY_ADDRESS
        words, _ = super().array(value)
        layout = (flags.c_contiguous, flags.f_contiguous, flags.writeable, flags.aligned)
        return (*words, layout), ()

    def kind(self, value: type) -> Made:
        words = ("class", name_of(value))
        if isinstance(value, enum.EnumMeta):
            members: dict[str, Any] = dict(value.__members__)  # with other names of the same
            return (*words, *members), members.values()
        if issubclass(value, tuple) and hasattr(value, "_fields"):
            return (*words, *value._fields), (value.__new__,)  # whose defaults count
        of_numba = type(value).__module__.partition(".")[0] == "numba"
        (self.compiled if of_numba else self.others).append((self.place, value))
        return words, ()

    def container(self, value) -> Made:
        known = isinstance(value, tuple | list | dict | set | frozenset)
        return super().container(value) if known else self.other(value)

    def other(self, value) -> Made:
        """Return an object by its class alone, unless it is one of the few that numba knows."""
        if isinstance(value, types.ModuleType | enum.Enum | slice | range):
            return super().other(value)
        cls = name_of(type(value))
        if cls.startswith("numba."):
            return ("numba", cls, self._numba(value)), ()
        if isinstance(value, _FOREIGN) or cls.startswith("_cffi_backend."):
            self.kept = False  # an address of this process
            self._steady(_pointer_state, value)
        else:
            self.others.append((self.place, value))
        names: tuple[Any, ...] = (value,) if isinstance(value, np.dtype) else ()
        if isinstance(value, _CALLABLES):
            names = (value.__name__, getattr(value, "__module__", ""))
        return ("other", cls, *names), ()

    def _numba(self, value) -> Any:
        """Return a word for an object of numba: a type, or something compiled, its own or of others."""
        from numba.core.types import Boolean, Number

        from ..numba_inside import function_in

        if isinstance(value, Number | Boolean):
            return value
        function = function_in(value)
        if not function or home_of(function).partition(".")[0] != "numba":
            self.compiled.append((self.place, value))
        return getattr(value, "__qualname__", "")

    def _steady(self, state: Callable[[Any], Any], value) -> None:
        before = state(value)
        self._tests.append(lambda: state(value) == before)


def _unchanged(value: list[Any] | dict[Any, Any] | set[Any]) -> Callable[[], bool]:
    """Return a test of whether a container holds the same objects."""

    def items() -> list[Any]:
        return [*value, *value.values()] if isinstance(value, dict) else [*value]

    before = items()
    return lambda: len(now := items()) == len(before) and all(map(operator.is_, now, before))


def _pointer_state(value) -> tuple[Any, ...]:
    return getattr(value, "restype", None), getattr(value, "argtypes", None)
