"""What a code object says: its bytes, and the names by which it reaches values.

numba freezes what a function finds by a global name, in a closure cell, or as an attribute of a
module. Here is which names those are; `geomint.kernels.compiling.fingerprint` looks the values up.
"""

import dis
import functools
import hashlib
import marshal
import types
from collections.abc import Iterator
from typing import NamedTuple

CONSTANTS = (type(None), type(...), bool, int, float, complex, str, bytes)

_GLOBALS = {"LOAD_GLOBAL", "LOAD_NAME", "LOAD_FROM_DICT_OR_GLOBALS"}
_CELLS = {"LOAD_DEREF", "LOAD_CLASSDEREF", "LOAD_FROM_DICT_OR_DEREF"}
_ATTRIBUTES = {"LOAD_ATTR", "LOAD_METHOD"}
_NOTHING = {"EXTENDED_ARG", "CACHE", "NOP"}  # may stand between a name and its attribute


class Path(NamedTuple):
    """A global name or a name of a closure cell, and the attributes that are read from it at once.

    What is read later, through a local variable, an argument or a returned value, is not here.
    """

    cell: bool
    name: str
    attributes: tuple[str, ...]


class Code(NamedTuple):
    """What a code object and those in it say: their bytes, paths, and words: ``x.word`` of any x."""

    digest: bytes
    paths: tuple[Path, ...]
    words: frozenset[str]


def framed(*pieces: bytes) -> bytes:
    """Return pieces as one, from which they could be separated again."""
    return b"".join(len(piece).to_bytes(8, "little") + piece for piece in pieces)


def constant(value) -> bytes:
    """Return a constant of code as bytes: the same in every process, others for another type or bit."""
    cls = type(value)
    if cls is types.CodeType:
        pieces = [described(value).digest]
    elif cls in (tuple, frozenset):
        pieces = [*map(constant, value)]
    else:
        pieces = [marshal.dumps(value, 2)]  # whose bytes do not depend on who else has the value
    if cls is frozenset:  # in the order of the bytes: its own depends on the process
        pieces.sort()
    return framed(cls.__name__.encode(), *pieces)


@functools.lru_cache(maxsize=4096)
def reads(code: types.CodeType, place: int) -> bool:
    """Tell whether a function's code names its argument at a place at all: if not, it is not read."""
    if place >= code.co_argcount:
        return True
    name = code.co_varnames[place]
    # Some instructions of newer Pythons have a tuple of names.
    found = (instruction.argval for instruction in dis.get_instructions(code))
    return any(name == value or (type(value) is tuple and name in value) for value in found)


@functools.lru_cache(maxsize=4096)
def described(code: types.CodeType) -> Code:
    """Return what a code object says, without its place in the file."""
    words: set[str] = set()
    paths = dict.fromkeys(path for path, _ in paths_in(code, words))
    for value in code.co_consts:
        if isinstance(value, types.CodeType):
            inner = described(value)
            paths.update(dict.fromkeys(inner.paths))
            words |= inner.words
    read = {path.name for path in paths if path.cell}
    paths.update((Path(True, name, ()), None) for name in code.co_freevars if name not in read)
    names = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
    counts = (code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags)
    pieces = (code.co_code, code.co_exceptiontable, constant(names), constant(counts))
    digest = hashlib.sha256(framed(*pieces, constant(code.co_consts))).digest()
    return Code(digest, tuple(paths), frozenset(words))


def paths_in(code: types.CodeType, words: set[str]) -> Iterator[tuple[Path, int | None]]:
    """Yield the paths of a code object and their lines; add the names of attributes to `words`."""
    path = None
    line = None
    for instruction in dis.get_instructions(code):
        name = instruction.opname
        if name in _NOTHING:
            continue
        if name in _ATTRIBUTES:
            words.add(instruction.argval)
            if path is not None:
                path = path._replace(attributes=(*path.attributes, instruction.argval))
            continue
        if path is not None:
            yield path, line
        path = None
        if name in _GLOBALS or name in _CELLS:
            path = Path(name in _CELLS, instruction.argval, ())
            line = instruction.positions.lineno if instruction.positions else None
