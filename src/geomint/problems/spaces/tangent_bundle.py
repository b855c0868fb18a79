"""Tangent bundles: a point and a vector there, or a momentum, which is one by the metric of R^N."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arguments import Array, Booleans, as_vector
from ...errors import DomainError
from ...kernels.compiling.recorded import Recorded
from ..forms import Hamiltonian
from .conditions import both
from .pieces import Pieces, check_known
from .repair import PARALLEL, SILENT, length, repaired, warn
from .space import Space
from .sphere import Sphere
from .stiefel import Stiefel

__all__ = ["TangentBundle", "TangentSphere", "TangentStiefel"]


@dataclass(frozen=True)
class TangentBundle(Space):
    """TQ, and T*Q: a point q of Q and a vector p of R^N tangent to it.

    Parameters
    ----------
    base : Space
        Q, of one piece.
    name : str
        Of the vector, the second piece.
    """

    base: Space
    name: str = "p"

    def __post_init__(self) -> None:
        base = self.base
        known = isinstance(base, Space) and len(base.pieces) == 1
        if not (known and (not base.conditions or base.tangencies_at(0, base.rows))):
            raise DomainError("base", self.base, "a space of one piece that has tangent vectors")
        self.check_names()

    @property
    def n(self) -> int:  # type: ignore[override]
        """That of the base."""
        return self.base.n

    @property
    def pieces(self) -> Pieces:
        """The point and the vector."""
        return (*self.base.pieces, (self.name, self.base.rows))

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Both have that of the base."""
        return {**self.base.shapes, self.name: next(iter(self.base.shapes.values()))}

    @property
    def params(self) -> Array:
        """Those of the base."""
        return self.base.params

    @property
    def conditions(self) -> int:
        """Twice those of the base."""
        return 2 * self.base.conditions

    @property
    def codes(self) -> tuple[str, ...] | None:
        """Both are turned alike; translations of a point move no vectors."""
        return self.base.codes * 2 if self.base.codes else None

    def manifold_at(self, first: int) -> Recorded | None:
        """c(q) and ½ dc(p)."""
        base, m = self.base, self.base.conditions
        point = base.manifold_at(first)
        if point is None:
            return None
        return both(point, m, base.tangency_at(first, first + base.rows), m)

    def constraints_at(self, first: int) -> dict[str, Recorded]:
        """Those of the point, and tangency."""
        base = self.base
        return {**base.constraints_at(first), **base.tangencies_at(first, first + base.rows)}

    def hamiltonian(self, gradients: Recorded, separable: bool = False) -> Hamiltonian:
        """Return the form of a Hamiltonian whose hidden constraint is that p is tangent."""
        return Hamiltonian(gradients, self.base.constraint, self.base.conditions, separable)

    def project(self, **components: Any) -> Array:
        """Return the state with the point and the tangent vector that are named."""
        check_known(self.pieces, components)
        vector = as_vector(self.name, components.get(self.name, ...), self.base.rows)
        point = self.base.point(components.get(self.pieces[0][0], ...))
        return np.concatenate([point, self.vector(point, vector)])

    def vector(self, q: Array, value: Any, name: str = "") -> Array:
        """Return the part of `value` that is tangent at q; warn if that is another one.

        `name` says in messages what it is called, if not as the piece.

        Raises
        ------
        DomainError
            If it is not as many finite numbers, or so nearly normal that no direction is left.
        """
        name = name or self.name
        given = as_vector(name, value, self.base.rows)
        defect = self.base.leaning(q, given)
        if defect <= SILENT:
            return given
        result = self.base.tangent(q, given)
        if length(result) < PARALLEL * length(given):
            raise DomainError(name, value, f"a vector that is not parallel to {self.base.normal}")
        said = self._said(name)
        warn(f"{said} is {defect:.3g}, not 0: the state uses the tangent part", name, defect)
        return result

    def admit(self, y: Array) -> Array:
        """Return a flat state, the point repaired and then the vector."""
        given, p = y[: self.base.rows], y[self.base.rows :]
        q = self.base._admitted(given)
        defect = self.base.leaning(q, p)
        if defect <= SILENT:
            return y if q is given else np.concatenate([q, p])
        said, expected = self._said(self.name), f"a vector orthogonal to {self.base.normal}"
        mended = repaired(self.name, p, defect, said, expected, lambda: self.base.tangent(q, p))
        return np.concatenate([q, mended])

    def settled(self, states: Array) -> Booleans:
        """Tell which are orthogonal, on spheres, to half of what is silent."""
        n = self.base.rows
        found = np.zeros(len(states), dtype=bool)
        if isinstance(self.base, Sphere):
            q, p = states[:, :n], states[:, n:]
            with np.errstate(all="ignore"):
                along = np.abs((q * p).sum(axis=1))
                small = along <= 0.5 * SILENT * np.sqrt((p * p).sum(axis=1))
            found = small & (along < np.inf) & self.base.settled(q)
        return found

    def _said(self, name: str) -> str:
        return f"({self.base.normal}, {name})/|{name}|"

    def random(self, rng: np.random.Generator) -> dict[str, Array]:
        """Return a random point, and the tangent part of a normal vector."""
        point = self.base.random(rng)
        (q,) = point.values()
        return {**point, self.name: self.base.tangent(q, rng.normal(size=len(q)))}


def TangentSphere(n: int, names: tuple[str, str] = ("gamma", "p")) -> TangentBundle:  # noqa: N802
    """T*S^(n−1) and TS^(n−1): a unit vector and one orthogonal to it."""
    return TangentBundle(Sphere(n, names[0]), names[1])


def TangentStiefel(n: int, r: int, names: tuple[str, str] = ("X", "P")) -> TangentBundle:  # noqa: N802
    """T*V(n, r): r orthonormal vectors X and P with XPᵀ + PXᵀ = 0."""
    return TangentBundle(Stiefel(n, r, names[0]), names[1])
