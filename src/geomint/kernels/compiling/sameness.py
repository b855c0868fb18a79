"""Whether two values are made of the same: arrays bit by bit, functions by code and what they hold."""

from __future__ import annotations

import dataclasses
import types
from collections.abc import Mapping
from typing import Any

import numpy as np

from .code import described
from .walk import Wrapped

__all__ = ["Compared", "same"]


class Compared:
    """What is equal to another one if both are made of the same, arrays and functions included."""

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return self is other or same(_attributes(self), _attributes(other))

    def __hash__(self) -> int:
        return hash((type(self), getattr(self, "name", None)))


def same(one: Any, other: Any) -> bool:
    """Tell whether two values are equal, with functions and arrays anywhere in them."""
    return _same(one, other, set())


def _same(one: Any, other: Any, met: set[tuple[int, int]]) -> bool:
    if one is other:
        return True
    if type(one) is not type(other):
        return False
    pair = (id(one), id(other))
    if pair in met:  # a closure that holds itself
        return True
    parts = _parts(one)
    if parts is None:
        return bool(one == other)
    met.add(pair)
    others = _parts(other)
    return len(parts) == len(others) and all(
        _same(x, y, met) for x, y in zip(parts, others, strict=True)
    )


def _parts(value: Any) -> Any:
    """Return what a value is made of, to be compared in turn; None for one that `==` compares."""
    if isinstance(value, np.ndarray):
        return [str(value.dtype), value.shape, value.tobytes()]
    if isinstance(value, Wrapped):
        return [value.fingerprint, value.inline]
    if isinstance(value, types.FunctionType):
        cells = [cell.cell_contents for cell in value.__closure__ or () if _is_set(cell)]
        code = [value.__module__, described(value.__code__).digest]
        return [*code, value.__defaults__, value.__kwdefaults__, *cells]
    if isinstance(value, types.MethodType):
        return [value.__func__, value.__self__]
    if isinstance(value, Mapping):
        return [list(value), *value.values()]
    if isinstance(value, list | tuple):
        return list(value)
    return _attributes(value)


def _attributes(value: Any) -> list[Any] | None:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return [getattr(value, each.name) for each in dataclasses.fields(value) if each.compare]
    return list(vars(value).items()) if isinstance(value, Compared) else None


def _is_set(cell: types.CellType) -> bool:
    try:
        return cell.cell_contents is cell.cell_contents
    except ValueError:
        return False
