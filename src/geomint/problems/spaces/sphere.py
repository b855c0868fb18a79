"""The unit sphere of R^n."""

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arguments import Array, Booleans, as_vector
from ...errors import DomainError
from ...kernels.compiling.recorded import Recorded, observable
from .repair import SILENT, length, repaired, warn
from .stiefel import Orthonormal

__all__ = ["Sphere"]


@dataclass(frozen=True)
class Sphere(Orthonormal):
    """S^(n−1), the unit vectors of R^n, turned by SO(n).

    Parameters
    ----------
    n : int
        At least 2.
    name : str
        Of the piece of the state.
    """

    n: int
    name: str = "gamma"
    vectors = 1

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """A vector."""
        return {self.name: (self.n,)}

    def constraints_at(self, first: int) -> dict[str, Recorded]:
        """(γ, γ) − 1."""
        return {"norm": product(self.n, first, first, 1.0)}

    def tangencies_at(self, first: int, second: int) -> dict[str, Recorded]:
        """(γ, v)."""
        return {"tangency": product(self.n, first, second)}

    def point(self, value: Any) -> Array:
        """Return the unit vector along `value`; warn if that is another one.

        Raises
        ------
        DomainError
            If `value` is zero, not finite or not n numbers.
        """
        name = self.name
        given = as_vector(name, value, self.n)
        size = length(given)
        if size == 0.0:
            raise DomainError(name, value, "a vector that is not zero")
        if abs(size - 1.0) <= 0.5 * SILENT:
            return given
        text = f"{name} has length {size!r}, not 1: the state uses {name}/|{name}|"
        warn(text, name, abs(size - 1.0))
        result = given / np.max(np.abs(given))
        return result / length(result)

    def admit(self, y: Array) -> Array:
        """Return a vector of a flat state, divided by its length if need be."""
        if abs(y.dot(y) - 1.0) <= SILENT:
            return y
        size = length(y)
        defect = abs(size - 1.0) * (size + 1.0)
        said = f"|{self.name}|² − 1"
        return repaired(self.name, y, defect, said, "a unit vector", lambda: y / size)

    def settled(self, states: Array) -> Booleans:
        """Tell which are unit vectors, to half of what is silent."""
        with np.errstate(all="ignore"):
            defects = np.abs((states * states).sum(axis=1) - 1.0)
        return defects <= 0.5 * SILENT

    def leaning(self, y: Array, v: Array) -> float:
        """Return |(y, v)|/|v|."""
        numbers = v.tolist()
        size = math.hypot(*numbers) or 1.0
        along = sum([a * (b / size) for a, b in zip(y.tolist(), numbers, strict=True)])
        return float(abs(along))

    def tangent(self, y: Array, v: Array) -> Array:
        """Return v less its part along y; twice, so that the result is orthogonal to round-off."""
        size = length(v)
        result = v / (size or 1.0)
        for _ in range(2):
            result -= (y @ result) / (y @ y) * y
        return result * size

    def random(self, rng: np.random.Generator) -> dict[str, Array]:
        """Return a unit vector, uniform."""
        v = rng.normal(size=self.n)
        return {self.name: v / np.sqrt(v @ v)}


@functools.cache
def product(n: int, first: int, second: int, less: float = 0.0) -> Recorded:
    """Return the observable (u, v) less a number, of the vectors of R^n from those rows on."""

    def inner_product(params, t, y, work):
        total = y[first] * y[second]
        for i in range(1, n):
            total += y[first + i] * y[second + i]
        return total - less

    return observable(inner_product)
