"""Functions as they are sent to another process: by where they are found, not by their content.

`pickle` sends functions by module and name, and refuses those that are made inside of others. Those are
what problems are made of: a closure for every n. Here such a function is sent as the place of its code
in the module, ``(module, name of the outermost function, positions in the constants of the code)``,
and the contents of its closure cells. The process that receives it imports the module and finds the
same code, so that it finds the compiled code in the cache as well. Functions of a session or notebook
have no module to import; they are sent by cloudpickle, where that is installed.
"""

import copy
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
from .sameness import Compared, contents
from .walk import Wrapped

OTHER = "is another one here: expected the same version of it"
MOST_KEPT = 2**18  # bytes; of these a process that receives others all the time keeps 256


class Sendable(Compared):
    """What pickles with the functions that it is made of.

    Received twice in a process it is the same object, so that what was compiled for it is kept.
    """

    def __reduce__(self):
        return received, (sent(self),)

    def __copy__(self):
        made = object.__new__(type(self))
        vars(made).update(vars(self))
        return made

    def __deepcopy__(self, memo: dict[int, Any]):
        """Return a copy whose functions are the same ones, as Python copies functions."""
        made = self.__copy__()
        memo[id(self)] = made
        vars(made).update(copy.deepcopy(vars(self), memo))
        return made


class _Pickler(pickle.Pickler):
    def reducer_override(self, value):
        if isinstance(value, types.FunctionType) and value.__module__ != __name__:
            return _reduced(value)
        if isinstance(value, Wrapped):
            return _reduced_recorded(value)
        if isinstance(value, types.ModuleType):
            return importlib.import_module, (value.__name__,)
        if isinstance(value, Sendable):
            return copyreg.__newobj__, (type(value),), vars(value)  # type: ignore[attr-defined]
        return NotImplemented


def sent(value) -> bytes:
    """Return the bytes of a value, functions included.

    Raises
    ------
    SendingError
        For a function that another process cannot find.
    """
    buffer = io.BytesIO()
    _Pickler(buffer, pickle.HIGHEST_PROTOCOL).dump(value)
    return buffer.getvalue()


def received(content: bytes):
    """Return what was sent; the same object for the same bytes, unless they are many."""
    return pickle.loads(content) if len(content) > MOST_KEPT else kept(content)


@functools.lru_cache(maxsize=256)
def kept(content: bytes):
    """Return what was sent, and keep it."""
    return pickle.loads(content)


def _found(module: str, name: str):
    """Return what a module has under a qualified name; None if there is nothing."""
    value: Any = importlib.import_module(module)
    for part in name.split("."):  # also of classes
        value = getattr(value, part, None)
    return value


def _there(module: str, name: str, digest: bytes, whole: bool):
    """Return a function of a module, or all that it is wrapped in, if its code is the sender's."""
    found = _imported(module, name)
    code = getattr(_unwrapped(found), "__code__", None)
    if code is None or described(code).digest != digest:
        raise SendingError(name, module, OTHER)
    return found if whole else _unwrapped(found)


def _imported(module: str, name: str):
    """Return what a module has in the process that receives it, or raise `SendingError`."""
    try:
        return _found(module, name)
    except Exception as error:  # a module may raise anything
        raise SendingError(name, module, f"cannot be imported: {error!r}") from error


def _unwrapped(value):
    """Return the function in a recorded or cached one, or in a method of a class."""
    while not isinstance(value, types.FunctionType) and hasattr(value, "__wrapped__"):
        value = value.__wrapped__
    return value


def _by_name(module: str, name: str):
    return _unwrapped(_found(module, name))


def _importable(function: types.FunctionType) -> bool:
    """Tell whether another process can import the module that a function is written in."""
    known = sys.modules.get(function.__module__)
    own = known is not None and getattr(known, "__dict__", None) is function.__globals__
    return own and (function.__module__ != "__main__" or _is_script(known))


def _is_script(main) -> bool:
    """Tell whether spawned processes import it too, as multiprocessing does with scripts."""
    return getattr(main, "__file__", None) is not None and not cloudpickle()


def _reduced_recorded(recorded: Wrapped):
    function = recorded.function
    if _importable(function) and "<locals>" not in function.__qualname__:
        module, name = function.__module__, _name_in(function.__module__, recorded)
        if name is not None:
            return _there, (module, name, _digest(function), True)
    return type(recorded), (function, recorded.inline)


def _name_in(module: str, value) -> str | None:
    """Return the name under which a module has a value: its own, or another."""
    name = getattr(value, "__qualname__", "")
    if _found(module, name) is value:
        return str(name)
    space = vars(sys.modules[module])
    return next((key for key, found in space.items() if found is value), None)


def _reduced(function: types.FunctionType):
    if _importable(function):
        module, name = function.__module__, function.__qualname__
        digest = _digest(function)
        if "<locals>" not in name:
            known = name if _by_name(module, name) is function else _name_in(module, function)
            if known is not None:
                return _there, (module, known, digest, False)
        place = _place(function)
        if place is not None:
            cells = len(function.__closure__ or ())
            return _made, (module, *place, digest, cells), _state(function), None, None, _fill
    if (library := cloudpickle()) is not None:
        return library.loads, (library.dumps(function),)
    raise SendingError(function.__qualname__, function.__module__)


def _digest(function: types.FunctionType) -> bytes:
    return described(function.__code__).digest


def _state(function: types.FunctionType) -> tuple[Any, ...]:
    return (
        [contents(cell) for cell in function.__closure__ or ()],
        function.__defaults__,
        function.__kwdefaults__,
        function.__name__,
        function.__qualname__,
    )


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
    found = _unwrapped(_imported(module, outer))
    code = getattr(found, "__code__", None)
    for i in positions:
        inside = getattr(code, "co_consts", ())
        code = inside[i] if i < len(inside) else None
    if not isinstance(code, types.CodeType) or described(code).digest != digest:
        raise SendingError(outer, module, OTHER)
    space = vars(importlib.import_module(module))
    return types.FunctionType(code, space, closure=tuple(types.CellType() for _ in range(cells)))


def _fill(function: types.FunctionType, state: tuple[Any, ...]) -> None:
    cells, defaults, keywords, name, qualified = state
    for cell, content in zip(function.__closure__ or (), cells, strict=True):
        for value in content:
            cell.cell_contents = value
    function.__defaults__, function.__kwdefaults__ = defaults, keywords
    function.__name__, function.__qualname__ = name, qualified


@functools.cache
def cloudpickle():
    """Return the module cloudpickle, or None where it is not installed."""
    try:
        return importlib.import_module("cloudpickle")
    except ImportError:
        return None
