"""The forms of a problem, and the measure that its flow keeps: what `geomint.Problem` is made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..arguments import MOST_NUMBERS, Array, flat, whole
from ..errors import DomainError
from ..kernels.compiling.recorded import Recorded, observable
from ..kernels.compiling.sending import Sendable

FORMS = ("field", "action", "hamiltonian", "splitting")
_OPTIONAL_MAPS = ("cayley", "dexpinv", "dcayinv", "extent")


def check_recorded(owner: Any, *names: str, optional: tuple[str, ...] = ()) -> None:
    """Raise `DomainError` unless those attributes are recorded functions, or None where optional."""
    for name in (*names, *optional):
        f = getattr(owner, name)
        if not (isinstance(f, Recorded) or (f is None and name in optional)):
            expected = "a function recorded with geomint.field, observable or helper"
            raise DomainError(name, f, expected + (", or None" if name in optional else ""))


def check_types(owner: Any, kinds: dict[str, type]) -> None:
    """Raise `DomainError` unless those attributes are of those kinds."""
    for name, kind in kinds.items():
        if not isinstance(getattr(owner, name), kind):
            raise DomainError(name, getattr(owner, name), f"a {kind.__name__}")


@dataclass(frozen=True, eq=False)
class Group(Sendable):
    """A matrix Lie group acting on states.

    Parameters
    ----------
    name : str
        Such as ``SO(3)``.
    algebra_rows : int
        Length of an algebra element as a flat vector.
    layout : array
        Numbers that all functions read: sizes, and what the pieces of the state are.
    act : recorded ``act(layout, xi, y, out, work)``
        Writes ``exp(ξ)·y − y``: the increment, so that it can be added with compensation.
    bracket : recorded ``bracket(layout, x, y, out, work)``
        Writes ``[x, y]``.
    work : int
        Rows of scratch that the functions need.
    dexpinv : recorded ``dexpinv(layout, u, v, out, work)``, optional
        Writes ``dexp_u⁻¹ v`` in closed form, ``(d/dt) exp(u) = dexp_u(u̇) exp(u)``; without it RKMK
        methods take its series in `bracket`.
    cayley, dcayinv : recorded, optional
        The same as `act` and `dexpinv` for ``cay(ξ) = (1 − ξ/2)⁻¹(1 + ξ/2)`` instead of exp, where
        the group is quadratic: ``dcay_u⁻¹ v = (1 − u/2) v (1 + u/2)``.
    rows : int, optional
        Length of the states that it acts on: what products of groups need to know.
    extent : recorded ``extent(layout, u, work) -> number``, optional
        How far u is towards where exp is no longer a coordinate: RKMK methods that take the series
        of dexp⁻¹ refuse what is beyond 1. Without it they refuse nothing.
    inline : bool
        The functions take a few dozen operations: compile them into every method, since calls would
        cost as much again. Else methods call them, and are compiled once for all groups.

    Notes
    -----
    Where an argument lies outside of the coordinates' domain, `dexpinv`, `cayley` and `dcayinv`
    write NaN. Methods make a typed failure of it, or take a smaller step.

    Groups are multiplied: ``so3(2) * translations(1)`` acts on 6 rows and then on one.
    """

    name: str
    algebra_rows: int
    layout: Array
    act: Recorded
    bracket: Recorded
    work: int
    cayley: Recorded | None = None
    dexpinv: Recorded | None = None
    dcayinv: Recorded | None = None
    inline: bool = False
    extent: Recorded | None = None
    rows: int | None = None

    def __post_init__(self) -> None:
        check_types(self, {"name": str, "inline": bool})
        check_recorded(self, "act", "bracket", optional=_OPTIONAL_MAPS)
        object.__setattr__(self, "algebra_rows", whole("algebra_rows", self.algebra_rows, 1))
        object.__setattr__(self, "work", whole("work", self.work, 0, MOST_NUMBERS))
        object.__setattr__(self, "layout", flat("layout", self.layout))
        if self.rows is not None:
            object.__setattr__(self, "rows", whole("rows", self.rows, 0))

    def __mul__(self, other: Any) -> Group:
        from .groups import product

        return product(self, other) if isinstance(other, Group) else NotImplemented

    @property
    def functions(self) -> dict[str, Recorded]:
        """The functions that the group has, by name."""
        names = ("act", "bracket", *_OPTIONAL_MAPS)
        return {name: getattr(self, name) for name in names if getattr(self, name) is not None}


@dataclass(frozen=True, eq=False)
class GroupAction(Sendable):
    """The form ``ẏ = ξ(t, y)·y``: `generator` writes the algebra element ξ (as a field writes ẏ)."""

    generator: Recorded
    group: Group

    def __post_init__(self) -> None:
        check_recorded(self, "generator")
        check_types(self, {"group": Group})


@dataclass(frozen=True, eq=False)
class Hamiltonian(Sendable):
    """The form ``q̇ = ∂H/∂p, ṗ = −∂H/∂q − Gᵀλ, g(q) = 0`` on states ``(q, p)``.

    Parameters
    ----------
    gradients : recorded ``f(params, t, q, p, dq, dp, work)``
        Writes ∂H/∂q to `dq` and ∂H/∂p to `dp`.
    constraint : recorded ``f(params, q, g, G, work)``
        Writes the constraints to `g` and their Jacobian, row after row, to `G`.
    constraints : int
        How many constraints; less than the length of q.
    separable : bool
        H = ½ pᵀM⁻¹p + V(t, q) with a constant M: ∂H/∂p is linear in p and nothing else, ∂H/∂q does
        not depend on p.
    """

    gradients: Recorded
    constraint: Recorded
    constraints: int
    separable: bool = False

    def __post_init__(self) -> None:
        check_recorded(self, "gradients", "constraint")
        check_types(self, {"separable": bool})
        object.__setattr__(self, "constraints", whole("constraints", self.constraints, 1))


@dataclass(frozen=True, eq=False)
class Splitting(Sendable):
    """The form ``ẏ = f_0(t, y) + … + f_(m−1)(t, y)`` whose parts have known flows.

    Parameters
    ----------
    flow : recorded ``f(k, params, t, h, y, out, work)``
        Writes ``φ_k(y) − y``, the increment of the exact flow of part k (a whole number) over h. A
        part that depends on time is frozen at t, which is the middle of the method's step: with
        the flows composed symmetrically that keeps the order.
    parts : int
        How many; at least 2, no two of them the same.
    symplectic : bool
        Whether every part is Hamiltonian in the same symplectic structure: if not, a plan does not
        call the method symplectic.
    """

    flow: Recorded
    parts: int
    symplectic: bool = True

    def __post_init__(self) -> None:
        check_recorded(self, "flow")
        check_types(self, {"symplectic": bool})
        object.__setattr__(self, "parts", whole("parts", self.parts, 2))


@observable
def constant_density(params, t, y, work):
    """Return log 1."""
    return 0.0 * y[0]


@dataclass(frozen=True, eq=False)
class Measure(Sendable):
    r"""An invariant measure: a density on the manifold of states.

    The manifold is c(y) = 0 with independent c = (c_1, …, c_m); the measure is μ δ(c) dy, with dy the
    Lebesgue measure of the flat state. On T*S^(n−1), c = (\|γ\|² − 1, (γ, p)), δ(c) dγ dp is the
    symplectic volume up to a factor; on an open set of R^N (m = 0) it is dy.

    Parameters
    ----------
    log_density : recorded ``f(params, t, y, work) -> number``
        log μ, up to a constant; 0 unless given.
    manifold : recorded ``f(params, t, y, out, work)`` or None
        Writes c(y); that of the problem's space unless given.
    conditions : int
        m, the length of c; 0 without `manifold`.
    base : Problem, optional
        The problem in the first pieces of the state alone, where the last ones lie over them as a
        fibre: nothing depends on them but pieces behind them, by rates that are affine in them and do
        not stretch them, and the group of the action turns or moves them, such as the attitude g over
        (k, γ), ġ = gω. Steps that move a fibre by elements of the group keep its Haar measure, whatever
        their error, so that what they make of the whole measure is what they make of that of the base;
        it alone is then watched. Not where the state does not move over it, as after a change of
        parameters; `geomint.testing.check_problem` finds a base that is none.

    Notes
    -----
    Φ(x, g) = (φ(x), a(x)·g) has the Jacobian matrix of a block triangle, and \|det\| = \|det Dφ\|
    where g ↦ a·g keeps its measure, as left translations, rotations and translations do.
    """

    log_density: Recorded = constant_density
    manifold: Recorded | None = None
    conditions: int = 0
    base: Any = None

    def __post_init__(self) -> None:
        check_recorded(self, "log_density", optional=("manifold",))
        object.__setattr__(self, "conditions", whole("conditions", self.conditions, 0))
        if (self.conditions > 0) != (self.manifold is not None):
            expected = "the length of what `manifold` writes; 0 without it"
            raise DomainError("conditions", self.conditions, expected)
