"""The walk along all that a function reaches: its content in bytes, and what to look at again.

Global names, closure cells, default values and attributes of modules are followed, through helpers,
containers and modules, to values that have a content. A module that is read other than by
``module.name`` (through a local variable, an argument, a result) counts with every attribute that is
named anywhere in the code that is reached.

What numba has compiled by itself keeps values where nobody can look: it is listed, and refused by
`geomint.kernels.compiling.foreign`, as is what has a numba type and no content that could be
hashed. Values without a numba type cannot be part of compiled code and count with their type alone.
"""

import builtins
import ctypes
import enum
import hashlib
import operator
import types
from collections.abc import Callable
from typing import Any

import numpy as np

from .code import CONSTANTS, Path, constant, described, framed

MISSING: Any = object()
LIBRARIES = {"numpy", "numba", "llvmlite"}  # their versions are part of the cache folder's name
KERNELS = __name__.rsplit(".", 2)[0]  # so are the sources of this package
PACKAGE = __name__.partition(".")[0]  # which imports its public names on demand
BY_ADDRESS = 10**6  # bytes; larger arrays numba does not copy into the code
_CALLABLES = (
    types.BuiltinFunctionType,
    types.MethodDescriptorType,
    types.WrapperDescriptorType,
    np.ufunc,
    type(np.sum),
)
_FOREIGN: Any = ctypes.CFUNCTYPE(None).__base__
_kernel_functions: dict[types.FunctionType, bytes] = {}


class Wrapped:
    """What stands for a Python function in compiled code."""

    function: Any  # a function; declared as such, mypy would take it for a method
    inline: bool
    fingerprint: Any


class Walk:
    """What has been met so far: `geomint.kernels.compiling.fingerprint.Reach` is made of it."""

    def __init__(self) -> None:
        self.pieces: list[bytes] = []
        self.names: dict[tuple[int, str], tuple[dict[str, Any], str, Any]] = {}
        self.cells: list[tuple[Any, Any]] = []
        self.functions: list[tuple[types.FunctionType, Any, Any, Any]] = []
        self.tests: list[Callable[[], bool]] = []
        self.compiled: list[tuple[str, Any]] = []
        self.others: list[tuple[str, Any]] = []
        self.kept = True
        self._place = ""
        self._numbers: dict[int, tuple[int, Any]] = {}  # of what may be met again
        self._modules: dict[int, types.ModuleType] = {}
        self._words: set[str] = set()

    def put(self, *words) -> None:
        self.pieces.append(framed(*(w if isinstance(w, bytes) else str(w).encode() for w in words)))

    def value(self, value) -> None:
        """Count a value with its content."""
        cls = type(value)
        if cls in CONSTANTS:
            self.put(constant(value))
        elif isinstance(value, Wrapped):
            self._watch(vars(value), "function", value.function)
            self.put("recorded", value.inline)
            self._function(value.function)
        elif isinstance(value, types.FunctionType):
            self.others.append((self._place, value))
            self._plain(value)
        elif isinstance(value, types.ModuleType):
            self.put("module", value.__name__)
            self._modules[id(value)] = value
        elif isinstance(value, type):
            self._class(value)
        elif isinstance(value, enum.Enum):
            self._watch(vars(value), "_value_", value._value_)
            self.put("member", _name(cls), value._name_)
            self.value(value._value_)
        elif isinstance(value, np.generic | np.ndarray):
            self._array(value)
        elif isinstance(value, np.dtype):
            self.put("dtype", repr(value))
        elif cls.__module__.partition(".")[0] == "numba":
            self._numba(value)
        elif isinstance(value, tuple | list | dict | set | frozenset | slice | range):
            self._container(value)
        else:
            self._other(value)

    def follow_modules(self) -> None:
        """Count what may be read from modules that are handed on, until nothing new is met."""
        done: set[tuple[int, str]] = set()
        while pairs := {(key, word) for key in self._modules for word in self._words} - done:
            done |= pairs
            order = list(self._modules)
            for key, word in sorted(pairs, key=lambda pair: (order.index(pair[0]), pair[1])):
                module = self._modules[key]
                found = self._attribute(module, word, watched=True)
                if found is not MISSING:
                    self._place = f"{module.__name__}.{word}"
                    self.put("attribute", self._place)
                    self.value(found)
        if self._modules:  # which numba's own functions for these keep
            self.compiled += [(p, v) for p, v in self.others if v is getattr or v is hasattr]

    def _plain(self, function: types.FunctionType) -> None:
        """Count a function that is not recorded: compiled code has an implementation instead."""
        home = home_of(function)
        if home.partition(".")[0] in LIBRARIES or home.startswith(KERNELS + "."):
            self.put("library", home, function.__qualname__)
        else:
            self._function(function)

    def _function(self, function: types.FunctionType) -> None:
        own = home_of(function).startswith(KERNELS + ".")
        if own and function.__closure__ is None:
            self.put("kernel", _kernel_function(function))
        elif not self._met(function):
            # Sources of kernels are part of the folder's name, and do not change in a process.
            self.body(function, watched=not own)

    def body(self, function: types.FunctionType, watched: bool) -> None:
        code = described(function.__code__)
        self.put("function", home_of(function), function.__module__, code.digest)
        self._words |= code.words
        if watched:
            found = (function.__code__, function.__defaults__, function.__kwdefaults__)
            self.functions.append((function, *found))
        place, self._place = self._place, f"a default of {function.__qualname__}"
        self.value(function.__defaults__)
        if function.__kwdefaults__ is not None:
            self.value(function.__kwdefaults__)
        cells = dict(zip(function.__code__.co_freevars, function.__closure__ or (), strict=True))
        if watched:
            self.cells += [(cell, content_of(cell)) for cell in cells.values()]
        for path in code.paths:
            self._path(function, cells, path, watched)
        for name in sorted(cells.keys() - {path.name for path in code.paths if path.cell}):
            self.value(content_of(cells[name]))
        self._place = place

    def _path(
        self, function: types.FunctionType, cells: dict[str, Any], path: Path, watched: bool
    ) -> None:
        """Count what a path leads to: through modules, up to the first value that is none."""
        words = (path.name, *path.attributes)
        self._place = f"{'.'.join(words)} in {function.__qualname__}"
        if not path.cell:
            found = self._global(function.__globals__, path.name, watched)
        elif path.name in cells:
            found = content_of(cells[path.name])
        else:  # a local variable, read by a function inside
            return
        for word in path.attributes:
            if not isinstance(found, types.ModuleType):
                break
            found = self._attribute(found, word, watched)
        self.put("path", path.cell, *words)
        self.value(found)

    def _global(self, space: dict[str, Any], name: str, watched: bool):
        for names in (space, vars(builtins)):
            found = names.get(name, MISSING)
            if watched:
                self._watch(names, name, found)
            if found is not MISSING:
                break
        return found

    def _attribute(self, module: types.ModuleType, word: str, watched: bool):
        found = _read(module, word)
        present = vars(module).get(word, MISSING)
        if watched:
            self._watch(vars(module), word, present)
            if present is not found and module.__name__ != PACKAGE:  # made when it is asked for
                self.tests.append(lambda: _read(module, word) is found)
        return found

    def _watch(self, space: dict[str, Any], name: str, value) -> None:
        self.names[id(space), name] = (space, name, value)

    def _met(self, value) -> bool:
        """Tell whether a value was met before, and if so count it as that one."""
        if id(value) in self._numbers:
            self.put("again", self._numbers[id(value)][0])
            return True
        self._numbers[id(value)] = (len(self._numbers), value)
        return False

    def _container(self, value) -> None:
        cls = type(value)
        self.put("container", _name(cls), getattr(value, "_fields", ""))
        if isinstance(value, list | dict | set):
            if self._met(value):
                return
            self.tests.append(_unchanged(value))
        if isinstance(value, set | frozenset):
            self._unordered(value)
            return
        if isinstance(value, slice | range):
            items = [value.start, value.stop, value.step]
        elif isinstance(value, dict):
            items = [part for pair in value.items() for part in pair]
        else:
            items = list(value)
        self.put(len(items))
        for item in items:
            self.value(item)

    def _unordered(self, value) -> None:
        """Count the items of a set in the order of their bytes: their own depends on the process."""
        before, found = self.pieces, []
        for item in value:
            self.pieces = []
            self.value(item)
            found.append(framed(*self.pieces))
        self.pieces = before
        self.put("set", *sorted(found))

    def _array(self, value) -> None:
        cls = type(value)
        if (
            value.dtype.hasobject
            or value.dtype.char in "gG"
            or isinstance(value, np.ma.MaskedArray)
        ):
            self._other(value)
            return
        flags = value.flags
        layout = (flags.c_contiguous, flags.f_contiguous, flags.writeable, flags.aligned)
        self.put(_name(cls), repr(value.dtype), value.shape, layout, value.tobytes())
        if isinstance(value, np.ndarray | np.void):
            before = _array_state(value)
            self.tests.append(lambda: _array_state(value) == before)
            contiguous = flags.c_contiguous or flags.f_contiguous
            self.kept = self.kept and contiguous and value.nbytes <= BY_ADDRESS

    def _class(self, value: type) -> None:
        self.put("class", _name(value))
        if isinstance(value, enum.EnumMeta):
            members: dict[str, Any] = dict(value.__members__)  # with other names of the same
            for member in members.values():
                self.value(member)
        elif issubclass(value, tuple) and hasattr(value, "_fields"):
            self.put(*value._fields)
            new = value.__new__  # whose defaults count
            self.value(new)
        elif type(value).__module__.partition(".")[0] == "numba":
            self.compiled.append((self._place, value))
        else:
            self.others.append((self._place, value))

    def _numba(self, value) -> None:
        """Count an object of numba: a type, or something compiled, of numba's own or of others."""
        from numba.core import types as numba_types

        self.put("numba", _name(type(value)), getattr(value, "__qualname__", ""))
        function = getattr(value, "py_func", None) or getattr(value, "_defn", None)
        if isinstance(value, numba_types.Number | numba_types.Boolean):
            self.put(value)
        elif not function or home_of(function).partition(".")[0] != "numba":
            self.compiled.append((self._place, value))

    def _other(self, value) -> None:
        self.put("other", _name(type(value)))
        if isinstance(value, _CALLABLES):
            self.put(value.__name__, getattr(value, "__module__", ""))
        if isinstance(value, _FOREIGN) or _name(type(value)).startswith("_cffi_backend."):
            self.kept = False  # an address of this process
            before = _pointer_state(value)
            self.tests.append(lambda: _pointer_state(value) == before)
        else:
            self.others.append((self._place, value))


def _kernel_function(function: types.FunctionType) -> bytes:
    """Return the fingerprint of a function of a module of the kernel layer: found once a process."""
    if function not in _kernel_functions:
        _kernel_functions[function] = function.__qualname__.encode()  # where it meets itself
        walk = Walk()
        walk.body(function, watched=False)
        walk.follow_modules()
        _kernel_functions[function] = hashlib.sha256(framed(*walk.pieces)).digest()
    return _kernel_functions[function]


def home_of(function: types.FunctionType) -> str:
    """Return the name of the module whose globals a function has, whatever it calls itself."""
    return str(function.__globals__.get("__name__"))


def _name(cls: type) -> str:
    return f"{cls.__module__}.{cls.__qualname__}"


def _read(module: types.ModuleType, word: str):
    try:
        return getattr(module, word)
    except Exception:  # a module may make attributes, and fail at it, in any way
        return MISSING


def content_of(cell):
    """Return what a closure cell holds, `MISSING` if nothing yet."""
    try:
        return cell.cell_contents
    except ValueError:  # not yet filled
        return MISSING


def _unchanged(value: list[Any] | dict[Any, Any] | set[Any]) -> Callable[[], bool]:
    """Return a test of whether a container holds the same objects."""

    def items() -> list[Any]:
        return [*value, *value.values()] if isinstance(value, dict) else [*value]

    before = items()
    return lambda: len(now := items()) == len(before) and all(map(operator.is_, now, before))


def _array_state(value) -> tuple[Any, ...]:
    return value.dtype, value.shape, value.strides, value.flags.writeable, value.tobytes()


def _pointer_state(value) -> tuple[Any, ...]:
    return getattr(value, "restype", None), getattr(value, "argtypes", None)
