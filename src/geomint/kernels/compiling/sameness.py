"""Whether two values are made of the same: arrays bit by bit, functions by code and what they hold."""

import dataclasses
import types
from collections.abc import Mapping
from typing import Any

import numpy as np

from .code import described
from .walk import Wrapped


class Compared:
    """What is equal to another one if both are made of the same, arrays and functions included."""

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return self is other or same(self._compared(), other._compared())

    def __hash__(self) -> int:
        return hash((type(self), getattr(self, "name", None)))

    def _compared(self) -> list[Any]:
        """Return what it is made of."""
        return _fields(self) if dataclasses.is_dataclass(self) else list(vars(self).items())


def same(one, other) -> bool:
    """Tell whether two values are equal, with functions and arrays anywhere in them."""
    return _same(one, other, {})


def _same(one, other, met: dict[tuple[int, int], Any]) -> bool:
    if one is other:
        return True
    if type(one) is not type(other):
        return False
    pair = (id(one), id(other))
    if pair in met:  # a closure that holds itself
        return True
    met[pair] = one, other  # kept: the id of what is gone is given to something else
    parts, others = parts_of(one), parts_of(other)
    if parts is None or others is None:
        try:
            return bool(one == other or (one != one and other != other))  # NaN
        except Exception:  # of what is an array in disguise, or foreign
            parts, others = made_of(one), made_of(other)
    return (
        parts is not None
        and others is not None
        and len(parts) == len(others)
        and all(_same(x, y, met) for x, y in zip(parts, others, strict=True))
    )


def parts_of(value):
    """Return what a value is made of, to be compared in turn; None for one that `==` compares."""
    if isinstance(value, np.ndarray):
        plain = type(value) is np.ndarray and not value.dtype.hasobject
        content = value.tobytes() if plain else value.tolist()
        return [str(value.dtype), value.shape, content]
    if isinstance(value, Wrapped):
        return [value.fingerprint, value.inline]
    if isinstance(value, types.FunctionType):
        code = described(value.__code__)
        cells = [contents(cell) for cell in value.__closure__ or ()]
        names = [value.__globals__.get(path.name) for path in code.paths if not path.cell]
        own = [value.__module__, code.digest, value.__defaults__, value.__kwdefaults__]
        return [*own, *cells, *names]
    if isinstance(value, types.MethodType):
        return [value.__func__, value.__self__]
    if isinstance(value, Mapping):
        return [list(value), *value.values()]
    if isinstance(value, list | tuple):
        return list(value)
    attributes = _attributes(value)
    kind: Any = type(value)
    identity = attributes is None and kind.__eq__ is object.__eq__
    return made_of(value) if identity else attributes


def made_of(value) -> list[Any] | None:
    """Return what pickle would make a value of again; None for what it finds by name, or refuses."""
    try:
        made = value.__reduce_ex__(4)
    except Exception:  # of several types
        return None
    if isinstance(made, str):
        return None
    return [*made[:3], *(list(items) for items in made[3:5] if items is not None)]


def _attributes(value) -> list[Any] | None:
    if isinstance(value, Compared):
        return value._compared()
    own = dataclasses.is_dataclass(value) and not isinstance(value, type)
    return _fields(value) if own else None


def _fields(value) -> list[Any]:
    return [getattr(value, each.name) for each in dataclasses.fields(value) if each.compare]


def contents(cell: types.CellType) -> tuple[Any, ...]:
    """Return what is in a cell; nothing for a variable that is not set."""
    try:
        return (cell.cell_contents,)
    except ValueError:
        return ()
