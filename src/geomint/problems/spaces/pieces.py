"""The pieces of a flat state: names and rows, in their order."""

import functools
import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...arguments import Array, as_vector, numbers_of
from ...errors import DomainError, nearest

__all__ = ["check_known", "joined_pieces", "piece_slices"]

Pieces = tuple[tuple[str, int], ...]


def piece_slices(pieces: Pieces) -> dict[str, slice]:
    """Return where each piece lies in the flat state."""
    return dict(_slices(tuple(pieces)))


@functools.lru_cache(maxsize=256)
def _slices(pieces: Pieces) -> dict[str, slice]:
    bounds = itertools.pairwise(itertools.accumulate((rows for _, rows in pieces), initial=0))
    return {name: slice(*ends) for (name, _), ends in zip(pieces, bounds, strict=True)}


def check_known(pieces: Pieces, components: Mapping[str, Any]) -> None:
    """Raise `DomainError` for a component that is none of the pieces."""
    names = [name for name, _ in pieces]
    for name in components:
        if name not in names:
            raise DomainError(name, components[name], f"one of {names}.{nearest(name, names)}")


def joined_pieces(pieces: Pieces, components: Mapping[str, Any]) -> Array:
    """Return the flat state of these pieces, or raise `DomainError` for others."""
    check_known(pieces, components)
    for name, rows in pieces:
        if name not in components:
            raise DomainError(name, ..., numbers_of(rows))
    return np.concatenate([as_vector(name, components[name], rows) for name, rows in pieces])
