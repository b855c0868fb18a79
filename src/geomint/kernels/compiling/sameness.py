"""Whether two values are made of the same: arrays bit by bit, functions by code and what they hold."""

from typing import Any

from .contents import Contents, Made, fields_of


class Compared:
    """What is equal to another one if both are made of the same, arrays and functions included."""

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        if self is other:
            return True
        mine, yours = self._compared(), other._compared()
        return len(mine) == len(yours) and all(map(same, mine, yours))

    def __hash__(self) -> int:
        return hash((type(self), getattr(self, "name", None)))

    def _compared(self) -> list[Any]:
        """Return what it is made of."""
        fields = fields_of(self)
        return [*vars(self), *vars(self).values()] if fields is None else fields


def same(one, other) -> bool:
    """Tell whether two values are equal, with functions and arrays anywhere in them."""
    told: list[Any] = []
    return one is other or _Both(told).of(one) == _Both(told).of(other)


class _Both(Contents):
    """What one of two values is made of, down to objects that say what they are equal to.

    These are `told` to the other one.
    """

    def __init__(self, told: list[Any]) -> None:
        super().__init__()
        self._told = told

    def unknown(self, value) -> Made:
        """Return the number of the first object that is equal, if it can tell."""
        words, parts = super().unknown(value)
        cls: Any = type(value)
        if not words and (cls.__eq__ is object.__eq__ or not _equal(value, value)):
            return words, parts
        alike = (i for i, x in enumerate(self._told) if type(x) is cls and _equal(x, value))
        number = next(alike, len(self._told))
        self._told.append(value)
        return (cls, number), ()


def _equal(one, other) -> bool:
    try:
        return bool(one == other or (one != one and other != other))  # NaN
    except Exception:  # of what is an array in disguise, or foreign
        return False
