"""Motions are equal if the numbers that they are made of are, bit by bit."""

from functools import cached_property

import numpy as np

from ..manifold import Named


class MadeOfNumbers:
    """Equal to another one of its class whose attributes hold the same numbers; caches do not count."""

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return self._numbers() == other._numbers()

    def __hash__(self) -> int:
        return hash(tuple(self._numbers().items()))

    def _numbers(self) -> Named:
        found: Named = {}
        for name, value in vars(self).items():
            if isinstance(getattr(type(self), name, None), cached_property):
                continue
            if isinstance(value, np.ndarray | float | int):
                found[name] = np.asarray(value).tobytes()
            elif isinstance(value, MadeOfNumbers):
                found[name] = value
        return found
