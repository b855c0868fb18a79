"""Functions as they are sent to another process: by where they are found, not by their content.

`pickle` sends functions by module and name, and refuses those that are made inside of others. Those are
what problems are made of: a closure for every n. Here such a function is sent as the place of its code
in the module, ``(module, name of the outermost function, positions in the constants of the code)``,
and the contents of its closure cells. The process that receives it imports the module and finds the
same code, so that it finds the compiled code in the cache as well. Functions of a session or notebook
have no module to import; they are sent by cloudpickle, where that is installed.
"""

from __future__ import annotations

import copyreg
import functools
import importlib
import io
import pickle
import sys
import types
from collections.abc import Iterator
from typing import Any

from ...errors import SendingError
from .code import described
from .sameness import Compared
from .walk import Wrapped

__all__ = ["Sendable", "cloudpickle", "received", "sent"]


class Sendable(Compared):
    """What pickles with the functions that it is made of.

    Received twice in a process it is the same object, so that what was compiled for it is kept.
    """

    def __reduce__(self) -> Any:
        return received, (sent(self),)


class _Pickler(pickle.Pickler):
    def reducer_override(self, value: Any) -> Any:
        if isinstance(value, types.FunctionType):
            return _reduced(value)
        if isinstance(value, Wrapped):
            return _reduced_recorded(value)
        if isinstance(value, types.ModuleType):
            return importlib.import_module, (value.__name__,)
        if isinstance(value, Sendable):
            return copyreg.__newobj__, (type(value),), vars(value)  # type: ignore[attr-defined]
        return NotImplemented


def sent(value: Any) -> bytes:
    """Return the bytes of a value, functions included.

    Raises
    ------
    SendingError
        For a function that another process cannot find.
    """
    buffer = io.BytesIO()
    _Pickler(buffer, pickle.HIGHEST_PROTOCOL).dump(value)
    return buffer.getvalue()


@functools.lru_cache(maxsize=256)
def received(content: bytes) -> Any:
    """Return what was sent; the same object for the same bytes."""
    return pickle.loads(content)


def _found(module: str, name: str) -> Any:
    """Return what a module has under a qualified name; None if there is nothing."""
    value: Any = importlib.import_module(module)
    for part in name.split("."):  # also of classes
        value = getattr(value, part, None)
    return value


def _unwrapped(value: Any) -> Any:
    """Return the function in a recorded or cached one, or in a method of a class."""
    while not isinstance(value, types.FunctionType) and hasattr(value, "__wrapped__"):
        value = value.__wrapped__
    return value


def _by_name(module: str, name: str) -> Any:
    return _unwrapped(_found(module, name))


def _importable(function: types.FunctionType) -> bool:
    """Tell whether another process can import the module that a function is written in."""
    known = sys.modules.get(function.__module__)
    own = known is not None and getattr(known, "__dict__", None) is function.__globals__
    return own and (function.__module__ != "__main__" or _is_script(known))


def _is_script(main: Any) -> bool:
    """Tell whether spawned processes import it too, as multiprocessing does with scripts."""
    return getattr(main, "__file__", None) is not None and not cloudpickle()


def _reduced_recorded(recorded: Wrapped) -> Any:
    function = recorded.function
    if _importable(function) and "<locals>" not in function.__qualname__:
        module, name = function.__module__, _name_in(function.__module__, recorded)
        if name is not None:
            return _found, (module, name)
    return type(recorded), (function, recorded.inline)


def _name_in(module: str, value: Any) -> str | None:
    """Return the name under which a module has a value: its own, or another."""
    name = getattr(value, "__qualname__", "")
    if _found(module, name) is value:
        return str(name)
    space = vars(sys.modules[module])
    return next((key for key, found in space.items() if found is value), None)


def _reduced(function: types.FunctionType) -> Any:
    if _importable(function):
        module, name = function.__module__, function.__qualname__
        if "<locals>" not in name:
            if _found(module, name) is function:
                return NotImplemented  # as pickle does it
            if _by_name(module, name) is function:
                return _by_name, (module, name)
            other = _name_in(module, function)
            if other is not None:
                return _found, (module, other)
        place = _place(function)
        if place is not None:
            cells = len(function.__closure__ or ())
            digest = described(function.__code__).digest
            return _made, (module, *place, digest, cells), _state(function), None, None, _fill
    if (library := cloudpickle()) is not None:
        return library.loads, (library.dumps(function),)
    raise SendingError(function.__qualname__, function.__module__)


def _state(function: types.FunctionType) -> tuple[Any, ...]:
    return (
        [_content(cell) for cell in function.__closure__ or ()],
        function.__defaults__,
        function.__kwdefaults__,
        function.__name__,
        function.__qualname__,
    )


def _content(cell: types.CellType) -> tuple[Any, ...]:
    """Return what is in a cell; nothing for a variable that is not set."""
    try:
        return (cell.cell_contents,)
    except ValueError:
        return ()


def _place(function: types.FunctionType) -> tuple[str, tuple[int, ...]] | None:
    """Return the outermost function's name and the positions of the code in its constants."""
    outer = function.__qualname__.partition(".<locals>")[0]
    found = _by_name(function.__module__, outer)
    if not isinstance(found, types.FunctionType):
        return None
    for positions, code in _codes(found.__code__):
        if code is function.__code__:
            return outer, positions
    return None


def _codes(code: types.CodeType) -> Iterator[tuple[tuple[int, ...], types.CodeType]]:
    for i, value in enumerate(code.co_consts):
        if isinstance(value, types.CodeType):
            yield (i,), value
            yield from (((i, *inner), found) for inner, found in _codes(value))


def _made(
    module: str, outer: str, positions: tuple[int, ...], digest: bytes, cells: int
) -> types.FunctionType:
    """Return the function whose code is at that place, with empty cells."""
    found: Any = _by_name(module, outer)
    code: Any = getattr(found, "__code__", None)
    for i in positions:
        inside = getattr(code, "co_consts", ())
        code = inside[i] if i < len(inside) else None
    if not isinstance(code, types.CodeType) or described(code).digest != digest:
        raise SendingError(outer, module, "is another one here: expected the same version of it")
    space = vars(importlib.import_module(module))
    return types.FunctionType(code, space, closure=tuple(types.CellType() for _ in range(cells)))


def _fill(function: types.FunctionType, state: tuple[Any, ...]) -> None:
    contents, defaults, keywords, name, qualified = state
    for cell, content in zip(function.__closure__ or (), contents, strict=True):
        for value in content:
            cell.cell_contents = value
    function.__defaults__, function.__kwdefaults__ = defaults, keywords
    function.__name__, function.__qualname__ = name, qualified


@functools.cache
def cloudpickle() -> Any:
    """Return the module cloudpickle, or None where it is not installed."""
    try:
        return importlib.import_module("cloudpickle")
    except ImportError:
        return None
