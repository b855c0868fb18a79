"""Products of spaces: their states one after another."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arguments import Array, Booleans
from ...errors import DomainError
from ...kernels.compiling.recorded import Recorded
from .conditions import both
from .pieces import Pieces, check_known
from .space import Space

__all__ = ["Product"]


class Product(Space):
    """The product A × B × … of spaces.

    Parameters
    ----------
    *factors : Space
        Pieces have names unlike each other. A product of products is one of all their factors.

    Notes
    -----
    Constraints of several factors that have one name end with the name of their piece: "norm-q".
    Neighbours that SO(n) turns, of one n, are turned by one rotation.
    """

    def __init__(self, *factors: Space) -> None:
        for factor in factors or (None,):
            if not isinstance(factor, Space):
                raise DomainError("factors", factors, "one space or more")
        self._factors = tuple(one for factor in factors for one in factor.factors)
        self.check_names()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Product) and self._factors == other._factors

    def __hash__(self) -> int:
        return hash(self._factors)

    def __repr__(self) -> str:
        text = " * ".join(repr(factor) for factor in self._factors)
        return text if len(self._factors) > 1 else f"Product({text})"

    @property
    def factors(self) -> tuple[Space, ...]:
        """All factors, in their order."""
        return self._factors

    @property
    def pieces(self) -> Pieces:
        """Those of the factors."""
        return tuple(piece for factor in self._factors for piece in factor.pieces)

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Those of the factors."""
        return {name: shape for factor in self._factors for name, shape in factor.shapes.items()}

    @property
    def params(self) -> Array:
        """Those of the only factor that has some."""
        return next((f.params for f in self._factors if len(f.params)), np.zeros(0))

    @property
    def conditions(self) -> int:
        """Those of all factors."""
        return sum(factor.conditions for factor in self._factors)

    def _placed(self) -> Iterator[tuple[Space, int]]:
        """Yield the factors and their first rows."""
        first = 0
        for factor in self._factors:
            yield factor, first
            first += factor.rows

    def manifold_at(self, first: int) -> Recorded | None:
        """Those of the factors, one after another."""
        found = None
        count = 0
        for factor, row in self._placed():
            own = factor.manifold_at(first + row)
            if own is not None:
                found = own if found is None else both(found, count, own, factor.conditions)
                count += factor.conditions
        return found

    def constraints_at(self, first: int) -> dict[str, Recorded]:
        """Those of the factors, by names unlike each other."""
        named = [
            (name, f, factor.pieces[0][0])
            for factor, row in self._placed()
            for name, f in factor.constraints_at(first + row).items()
        ]
        names = [name for name, _, _ in named]
        return {f"{name}-{piece}" if names.count(name) > 1 else name: f for name, f, piece in named}

    def admit(self, y: Array) -> Array:
        """Return the state, each factor by itself."""
        return np.concatenate([f._admitted(y[row : row + f.rows]) for f, row in self._placed()])

    def settled(self, states: Array) -> Booleans:
        """Tell of which every factor says so."""
        told = [f.settled(states[:, row : row + f.rows]) for f, row in self._placed()]
        return np.logical_and.reduce(told)

    def project(self, **components: Any) -> Array:
        """Return the state that is named, each factor by itself."""
        check_known(self.pieces, components)
        given = [
            {name: components[name] for name, _ in factor.pieces if name in components}
            for factor in self._factors
        ]
        return np.concatenate(
            [f.project(**own) for f, own in zip(self._factors, given, strict=True)]
        )

    def random(self, rng: np.random.Generator) -> dict[str, Array]:
        """Return a random point of each factor, one after another."""
        return {name: x for factor in self._factors for name, x in factor.random(rng).items()}

    def tangent(self, y: Array, v: Array) -> Array:
        """Return the tangent part, each factor by itself."""
        ends = [(f, slice(row, row + f.rows)) for f, row in self._placed()]
        return np.concatenate([f.tangent(y[s], v[s]) for f, s in ends])
