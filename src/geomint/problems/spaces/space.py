"""A space of states as a value: pieces, conditions, admissible points, the group that moves them."""

from __future__ import annotations

import functools
import itertools
import operator
from collections.abc import Callable, Mapping
from typing import Any, TypeVar, cast

import numpy as np

from ...arguments import Array, Booleans, as_vector, check_name, whole
from ...errors import DomainError, FormError
from ...kernels.compiling.recorded import Recorded, field
from ...kernels.numbers.blocks import Block
from ..forms import Group, GroupAction
from ..groups import so3, so_n, translations
from .conditions import brought_back, differences, tangent_part, written
from .pieces import Pieces, check_known, joined_pieces, piece_slices
from .repair import length

__all__ = ["Space"]

Method = TypeVar("Method", bound=Callable[..., Any])

STEP = 0.125  # of central differences, over the size of the piece: exact for quadratic conditions


def _of_states(method: Method) -> Method:
    """Let a method take whatever are `rows` finite numbers; of others `DomainError` is raised."""

    @functools.wraps(method)
    def checked(self: Space, *states: Any, **named: Any) -> Any:
        if len(states) == 1 and not named:
            return method(self, as_vector("state", states[0], self.rows))
        given = {name: as_vector(name, state, self.rows) for name, state in named.items()}
        return method(self, *[as_vector("state", state, self.rows) for state in states], **given)

    return cast(Method, checked)


class Space:
    """A set of states c(y) = 0 in flat coordinates: what systems and tests know about it, once.

    A subclass is a frozen dataclass: a value that can be compared, hashed, pickled, and printed so
    that the text makes it again. Spaces are multiplied: ``Skew(3) * Sphere(3)``. What a subclass gives
    beside its fields: `pieces`; `constraints_at`, unless all states are admissible; `admit`, `random`;
    and what else it knows better than the defaults. `geomint.testing.check_space` holds it to that.

    Attributes
    ----------
    pieces : tuple of (name, rows)
        The order of the flat state.
    conditions : int
        The length of c.
    codes : tuple of str, or None
        How SO(n) moves the points: a code for each part of the state, as `so_n` takes them; empty where
        translations move them, and None where no group does.
    params : array
        The parameters that recorded functions of the space read, from row 0 on; those of a problem
        begin with them.
    """

    n: int
    least = 2  # of n

    def __init_subclass__(cls) -> None:
        own = set(vars(cls))
        if "admit" in own and "settled" not in own:  # what a base knows is of its own `admit`
            cls.settled = Space.settled  # type: ignore[method-assign]
        for name in {"admit", "tangent", "retract", "distance"} & own:
            setattr(cls, name, _of_states(vars(cls)[name]))
        # For states whose numbers have been looked at: wherever `admit` comes from.
        cls._admitted = getattr(cls.admit, "__wrapped__", cls.admit)

    def __post_init__(self) -> None:
        object.__setattr__(self, "n", whole("n", self.n, self.least))
        self.check_names()

    @property
    def conditions(self) -> int:
        """The length of c: one for each constraint."""
        return len(self.constraints_at(0))

    @property
    def codes(self) -> tuple[str, ...] | None:
        """How SO(n) moves the points."""
        return ()

    @property
    def pieces(self) -> Pieces:
        """Names and rows, in the order of the flat state."""
        raise NotImplementedError

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """The shape of each piece by name: rows and columns where it is a matrix."""
        return {name: (rows,) for name, rows in self.pieces}

    @property
    def params(self) -> Array:
        """What recorded functions of the space read: nothing, for most."""
        return np.zeros(0)

    @property
    def factors(self) -> tuple[Space, ...]:
        """The spaces of which this one is the product; itself alone if it is none."""
        return (self,)

    @functools.cached_property
    def rows(self) -> int:
        """Length of the flat state."""
        return sum(rows for _, rows in self.pieces)

    @property
    def dimension(self) -> int:
        """How many numbers are free: rows less conditions."""
        return self.rows - self.conditions

    @property
    def slices(self) -> dict[str, slice]:
        """Where each piece lies in the flat state."""
        return piece_slices(self.pieces)

    @_of_states
    def split(self, y: Array) -> dict[str, Array]:
        """Return the pieces of a flat state by name, as copies."""
        return {name: np.array(y[rows]) for name, rows in self.slices.items()}

    def join(self, components: Mapping[str, Any]) -> Array:
        """Return the flat state of these pieces, or raise `DomainError` for others."""
        return joined_pieces(self.pieces, components)

    @_of_states
    def admit(self, y: Array) -> Array:
        """Return a flat state, repaired with a warning if need be, or raise; see `repair`."""
        return y

    _admitted = admit

    def settled(self, states: Array) -> Booleans:
        """Tell of many flat states, one a row, which `admit` surely returns as they are, to the bit.

        What is quickly told of all at once; of others `admit` tells.
        """
        found = np.zeros(len(states), dtype=bool)
        if type(self).admit is Space.admit:
            found[:] = np.isfinite(states).all(axis=1)
        return found

    def project(self, **components: Any) -> Array:
        """Return the flat state that is named, projected with a warning if need be."""
        check_known(self.pieces, components)
        if len(self.pieces) == 1:
            name = self.pieces[0][0]
            components = {**components, name: self.point(components.get(name, ...))}
        return self.admit(self.join(components))

    def point(self, value: Any) -> Array:
        """Return the only piece, as a user names it, projected with a warning if need be."""
        ((name, rows),) = self.pieces
        return as_vector(name, value, rows)

    def random(self, rng: np.random.Generator) -> dict[str, Array]:
        """Return the components of a random point: directions uniform, vectors normal."""
        return {name: rng.normal(size=rows) for name, rows in self.pieces}

    # --- recorded functions -----------------------------------------------------------------------

    def manifold_at(self, first: int) -> Recorded | None:
        """Return the recorded function that writes c of the state from row `first` on, or None.

        The constraints, one after another, unless a subclass knows better.
        """
        constraints = self.constraints_at(first)
        return written(*constraints.values()) if constraints else None

    @property
    def manifold(self) -> Recorded | None:
        """What `geomint.Measure` calls so: writes c(y)."""
        return self.manifold_at(0)

    def constraints_at(self, first: int) -> dict[str, Recorded]:
        """Return observables by name that are 0 on the space, the state from row `first`."""
        return {}

    @property
    def constraints(self) -> dict[str, Recorded]:
        """Functions by name that are 0 on the space."""
        return self.constraints_at(0)

    # What a `TangentBundle` over a space of one piece asks for.

    @property
    def normal(self) -> str:
        """What the directions normal to the space are called in messages."""
        return self.pieces[0][0]

    def tangency_at(self, first: int, second: int) -> Recorded:
        """Return the function that writes ½ dc(v), the point from row `first`, v from `second` on."""
        return written(*self.tangencies_at(first, second).values())

    def tangencies_at(self, first: int, second: int) -> dict[str, Recorded]:
        """Return observables by name that are 0 where v is tangent."""
        return {}

    @property
    def constraint(self) -> Recorded:
        """The constraint of `geomint.Hamiltonian`: c/2 and its Jacobian."""
        raise NotImplementedError

    # --- groups -----------------------------------------------------------------------------------

    @property
    def group(self) -> Group | None:
        """The group that moves points: one SO(n) for neighbours, R^m for what translations move."""
        parts = []
        for n, factors in itertools.groupby(self.factors, lambda f: f.n if f.codes else 0):
            run = list(factors)
            codes = [code for factor in run for code in factor.codes or ()]
            if any(factor.codes is None for factor in run):
                return None
            parts.append(so_n(n, *codes) if n else translations(sum(f.rows for f in run)))
        return functools.reduce(operator.mul, parts)

    def action(self, generator: Recorded) -> GroupAction:
        """Return the form ẏ = ξ·y; `generator` writes ξ as flat triangles and translations.

        Where SO(3) turns nothing but vectors it is that of R³ (`so3`), whose exponential is a closed
        formula: several times faster.
        """
        codes = [code for factor in self.factors for code in factor.codes or ()]
        if {f.n if f.codes else 0 for f in self.factors} == {3} and set(codes) == {"vector"}:
            return GroupAction(_vector_generator(generator), so3(len(codes)))
        group = self.group
        if group is None:
            raise FormError(f"{self!r} has no group that moves its points")
        return GroupAction(generator, group)

    # --- geometry, in plain Python ----------------------------------------------------------------

    @_of_states
    def defects(self, y: Array) -> Array:
        """Return c(y)."""
        out, manifold = np.zeros(self.conditions), self.manifold
        if manifold is not None:
            manifold(Block(self.params), 0.0, Block(y), Block(out), Block(np.zeros(0)))
        return out

    @_of_states
    def normals(self, y: Array) -> Array:
        """Return c_y, by central differences."""
        sizes = [length(y[s]) or 1.0 for s in self.slices.values() for _ in range(s.stop - s.start)]
        steps = STEP * np.array(sizes)
        return (differences(self.defects, y, np.diag(steps)) / steps[:, None]).T

    @_of_states
    def tangent(self, y: Array, v: Array) -> Array:
        """Return the part of a vector of R^N that is tangent to the space at y."""
        return tangent_part(self.normals(y), v)

    def leaning(self, y: Array, v: Array) -> float:
        """Return the length of the part of v that is not tangent at y, over |v|."""
        size = length(v)
        return 0.0 if size == 0.0 else length(v / size - self.tangent(y, v / size))

    @_of_states
    def retract(self, y: Array, v: Array) -> Array:
        """Return the point near y + v in the directions normal to the space, by Newton's method.

        Raises
        ------
        DomainError
            Where v is too long for it.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            z = brought_back(self.defects, self.normals, y + v)
        if z is None:
            raise DomainError(
                "v", v, "a shorter vector: no point of the space was found near y + v"
            )
        return z

    @_of_states
    def distance(self, y: Array, z: Array) -> float:
        """Return |y − z| in the flat coordinates."""
        return length(y - z)

    def __mul__(self, other: Any) -> Space:
        from .product import Product

        return Product(self, other) if isinstance(other, Space) else NotImplemented

    def check_names(self) -> None:
        """Raise `DomainError` unless the pieces have names of their own."""
        names = [name for name, _ in self.pieces]
        for name in names:
            check_name("name", name)
        if len(set(names)) < len(names):
            raise DomainError("names", names, "names unlike each other")


@functools.cache
def _vector_generator(generator: Recorded) -> Recorded:
    """Return the generator that writes a 3-vector by the hat map."""

    def vector_generator(params, t, y, out, work):
        generator(params, t, y, out, work)
        first = out[0]
        out[0] = -out[2]
        out[2] = -first

    return field(vector_generator)
