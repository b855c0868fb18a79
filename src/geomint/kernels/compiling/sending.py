"""Functions as they are sent to another process: by where they are found, not by their content.

`pickle` sends functions by module and name, and refuses those that are made inside of others. Those are
what problems are made of: a closure for every n. Here such a function is sent as the place of its code
in the module, ``(module, name of the outermost function, positions in the constants of the code)``,
and the contents of its closure cells. The process that receives it imports the module and finds the
same code, so that it finds the compiled code in the cache as well. Functions of a session or notebook
have no module to import; they are sent by cloudpickle, where that is installed.

It does not go by `geomint.kernels.compiling.contents` as digests and equality do: who receives must be
able to make what is sent again, and that is what pickle says of all that is no function. Of these it
has in common the digest of their code, by which another version is refused, and what cells hold.
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
from .contents import MISSING, Wrapped, content_of
from .sameness import Compared

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
        own = getattr(value, "__module__", None) == __name__  # what makes the others again
        if isinstance(value, types.FunctionType | Wrapped) and not own:
            return _reduced(value)
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


def _there(module: str, name: str, at: tuple[int, ...], digest: bytes, whole: bool):
    """Return a function of a module, or all that it is wrapped in, if its code is the sender's.

    Of one that is made inside of it the place is given too: it is made again, with empty cells.
    """
    try:
        found = _found(module, name)
    except Exception as error:  # a module may raise anything
        raise SendingError(name, module, f"cannot be imported: {error!r}") from error
    code = getattr(_unwrapped(found), "__code__", None)
    for i in at:
        inside = getattr(code, "co_consts", ())
        code = inside[i] if i < len(inside) else None
    if not isinstance(code, types.CodeType) or described(code).digest != digest:
        raise SendingError(name, module, OTHER)
    if at:
        cells = tuple(types.CellType() for _ in code.co_freevars)
        return types.FunctionType(code, vars(sys.modules[module]), closure=cells)
    return found if whole else _unwrapped(found)


def _unwrapped(value):
    """Return the function in a recorded or cached one, or in a method of a class."""
    while not isinstance(value, types.FunctionType) and hasattr(value, "__wrapped__"):
        value = value.__wrapped__
    return value


def _importable(function: types.FunctionType) -> bool:
    """Tell whether another process can import the module that a function is written in."""
    known = sys.modules.get(function.__module__)
    own = known is not None and getattr(known, "__dict__", None) is function.__globals__
    return own and (function.__module__ != "__main__" or _is_script(known))


def _is_script(main) -> bool:
    """Tell whether spawned processes import it too, as multiprocessing does with scripts."""
    return getattr(main, "__file__", None) is not None and not cloudpickle()


def _reduced(value: types.FunctionType | Wrapped):
    """Return how a function is found or made, by itself or with what it is recorded in."""
    recorded = isinstance(value, Wrapped)
    function = value.function if isinstance(value, Wrapped) else value
    if _importable(function):
        module, digest = function.__module__, described(function.__code__).digest
        name = _name_in(module, function.__qualname__, value)
        if name is not None:
            return _there, (module, name, (), digest, recorded)
        place = None if recorded else _place(function)
        if place is not None:
            return _there, (module, *place, digest, False), _state(function), None, None, _fill
    if isinstance(value, Wrapped):
        return type(value), (function, value.inline)
    if (library := cloudpickle()) is not None:
        return library.loads, (library.dumps(function),)
    raise SendingError(function.__qualname__, function.__module__)


def _name_in(module: str, name: str, value) -> str | None:
    """Return the name under which a module has a value: its own, or another."""
    if "<locals>" in name:  # whose cells may hold something else there
        return None
    found = _found(module, name)
    if found is value or _unwrapped(found) is value:
        return name
    return next((key for key, x in vars(sys.modules[module]).items() if x is value), None)


def _state(function: types.FunctionType) -> tuple[Any, ...]:
    cells = [content_of(cell) for cell in function.__closure__ or ()]
    names = function.__name__, function.__qualname__
    return cells, function.__defaults__, function.__kwdefaults__, names


def _place(function: types.FunctionType) -> tuple[str, tuple[int, ...]] | None:
    """Return the outermost function's name and the positions of the code in its constants."""
    outer = function.__qualname__.partition(".<locals>")[0]
    found = _unwrapped(_found(function.__module__, outer))
    inside = _codes(found.__code__) if isinstance(found, types.FunctionType) else ()
    return next(((outer, at) for at, code in inside if code is function.__code__), None)


def _codes(code: types.CodeType) -> Iterator[tuple[tuple[int, ...], types.CodeType]]:
    for i, value in enumerate(code.co_consts):
        if isinstance(value, types.CodeType):
            yield (i,), value
            yield from (((i, *inner), found) for inner, found in _codes(value))


def _fill(function: types.FunctionType, state: tuple[Any, ...]) -> None:
    cells, function.__defaults__, function.__kwdefaults__, names = state
    for cell, content in zip(function.__closure__ or (), cells, strict=True):
        if content is not MISSING:
            cell.cell_contents = content
    function.__name__, function.__qualname__ = names


def cloudpickle():
    """Return the module cloudpickle, or None where it is not installed."""
    try:
        return importlib.import_module("cloudpickle")
    except ImportError:
        return None
