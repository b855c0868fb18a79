"""Calls from Python into compiled code, by its address.

numba's own way in looks at the type of every argument and looks functions up, 44 µs for a stepper.
Here the arguments lie ready as numbers, a call changes some and takes 3 µs; and no code has to be
compiled to take Python objects apart.

What is called is what compiled code calls itself, by numba's convention: ``int f(result *, error **,
arguments)``, with blocks and functions as their members, one after the other.
"""

from __future__ import annotations

import ctypes
import functools
import pickle
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

_RETURNED, _RETURNED_NONE = 0, -2  # of numba's codes, those that are no errors


@dataclass(frozen=True, eq=False)
class Code:
    """Compiled code of one signature: where it is, and all that keeps it."""

    address: int
    kept: Any
    signature: Any

    def __call__(self, *arguments):
        """Return what the code returns; to call it often, make a `Call`."""
        named = {str(i): argument for i, argument in enumerate(arguments)}
        return Call(self, tuple(named), self)(**named)


class Call:
    """A function and its arguments, some of which each call may change.

    Parameters
    ----------
    function : callable
        What plain Python runs.
    names : tuple of str
        Of all arguments.
    code : Code, optional
        What runs. Without it plain Python does.
    """

    def __init__(
        self, function: Callable[..., Any], names: tuple[str, ...], code: Code | None = None
    ) -> None:
        self._function, self._code = function, code
        self._values: dict[str, Any] = dict.fromkeys(names)
        self._addresses: dict[str, Any] = {}
        if code is None:
            return
        frame = _frame_of(code.signature)
        self._run = frame.prototype(code.address)
        self._places = dict(zip(names, frame.places, strict=True))
        self._form, self._buffer = frame.result, frame.buffer
        self._own([0] * frame.size)

    def _own(self, numbers: list[float]) -> None:
        """Take numbers, and places for the result, that no other call has."""
        self._numbers = numbers
        self._result = self._buffer()
        self._error = ctypes.c_void_p()
        self._out = ctypes.byref(self._result), ctypes.byref(self._error)

    def copy(self) -> Call:
        """Return a call of the same with the same arguments, for instance for another thread."""
        other = Call.__new__(Call)
        other.__dict__.update(self.__dict__)  # what `copy.copy` does in five times the time
        other._values = dict(self._values)
        if self._code is not None:
            other._own(list(self._numbers))
        return other

    def given(self, name: str):
        """Return a block or a function as it is set."""
        return self._values[name]

    def set(self, **values) -> None:
        """Change arguments; blocks and functions are held until they are changed again."""
        self._change(values)

    def _change(self, values: dict[str, Any]) -> None:
        held = self._values
        if self._code is None:
            held.update(values)
            return
        numbers, places = self._numbers, self._places
        for name, value in values.items():
            kind, at = places[name]
            if kind is Any:
                numbers[at] = value
                continue
            held[name] = value
            if kind is Code:
                for i, code in enumerate(value if isinstance(value, tuple) else (value,)):
                    numbers[at + len(_FUNCTION) * i + _CALLED] = code.address
            elif kind is tuple:
                addresses = (ctypes.c_void_p * len(value))(*(code.address for code in value))
                self._addresses = {**self._addresses, name: addresses}
                numbers[at] = ctypes.addressof(addresses)
            elif type(value) is kind:
                numbers[at], numbers[at + 1] = value.address, len(value)
            else:
                raise TypeError(f"{name}: expected a {kind.__name__}, got {value!r}")

    def __call__(self, **values):
        """Change arguments, and return what the function returns of them all."""
        self._change(values)
        if self._code is None:
            with np.errstate(all="ignore"):  # as silent as compiled code
                return self._function(*self._values.values())
        status = self._run(*self._out, *self._numbers)
        if status not in (_RETURNED, _RETURNED_NONE):
            raise self._raised()
        result = self._form.unpack_from(self._result)
        return result if len(result) != 1 else result[0]

    def _raised(self) -> BaseException:
        """Return the exception that compiled code has left: of rows outside of blocks, if checked."""
        data, length = struct.unpack("Pi", ctypes.string_at(self._error.value or 0, 12))
        kind, arguments, *_ = pickle.loads(ctypes.string_at(data, length))
        return kind(*(arguments or ()))


class _Frame(NamedTuple):
    """How a signature's arguments and its result lie in memory.

    A place is what an argument has to be (`Code`: a function or a tuple of them; `tuple`: functions
    behind their addresses; `Any`: a number; else the class of a block), and which of `size` numbers is
    its first.
    """

    places: list[tuple[Any, int]]
    size: int
    prototype: Any
    result: struct.Struct
    buffer: Any


# A function: addresses for C and of a Python object, which stay 0, and of what is called.
_FUNCTION: list[Any] = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
_CALLED = 2


@functools.cache
def _frame_of(signature) -> _Frame:
    from numba.core import types

    from ..numbers.typing_addresses import ADDRESSES

    places = []
    numbers: list[Any] = []
    for argument in signature.args:
        kind: Any
        if isinstance(argument, types.BaseTuple):
            kind, needed = Code, len(argument) * _FUNCTION
        elif isinstance(argument, types.FunctionType):
            kind, needed = Code, _FUNCTION
        elif argument == ADDRESSES:
            kind, needed = tuple, [ctypes.c_void_p]
        elif argument in (types.int64, types.float64):
            whole = argument == types.int64
            kind, needed = Any, [ctypes.c_int64 if whole else ctypes.c_double]
        else:
            kind, needed = argument.held, [ctypes.c_void_p, ctypes.c_int64]
        places.append((kind, len(numbers)))
        numbers += needed
    result = signature.return_type
    parts = getattr(result, "types", (result,))
    letters = {types.int64: "q", types.float64: "d", types.none: ""}
    form = struct.Struct("".join(letters[part] for part in parts))
    prototype = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, *numbers)
    buffer = ctypes.c_char * max(form.size, 1)
    return _Frame(places, len(numbers), prototype, form, buffer)
