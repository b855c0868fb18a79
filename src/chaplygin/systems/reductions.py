"""What may be integrated in place of a representation, from one initial state: see `geomint.Reduction`.

* Without SO(n−1)-momentum k = γ∧p: the n(n+1)/2 numbers (k, γ) follow from the 2n numbers (γ, p).
* At n = 2 so(2) is commutative, k is constant, and p = −kγ: three numbers instead of four.
* With equal a_i in a group G of indices γ_G and p_G stay in the plane that they span at time 0, and a
  group in which both vanish stays so: with an orthonormal basis Q of these planes, γ = Qγ′ and
  p = Qp′ for a motion of the same kind with as many a_i as Q has columns. So from a homogeneous ball
  two of them are left.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

import geomint as gi

from ..manifold import Array, Map, length, wedge

SAME = ("energy", "K", "norm", "tangency")  # the others depend on n, or on the axes
TANGENT = ("reduced", "hamiltonized")


def tangent_reductions(
    problems: Mapping[str, gi.Problem], states: Mapping[str, Array], n: int
) -> Iterator[gi.Reduction]:
    """Yield those between (k, γ) and (γ, p), of a ball without SO(n−1)-momentum."""
    if "ball" not in problems or "reduced" not in problems:
        return
    tangent = problems["reduced"], states["reduced"]
    none = "no SO(n−1)-momentum"
    yield gi.Reduction("ball", "reduced", *tangent, momentum_lift(n), none)
    if n == 2:
        constant = "n = 2: k is constant"
        yield gi.Reduction(
            "reduced", "ball", problems["ball"], states["ball"], planar_lift, constant
        )


def equal_axes(
    a: Array,
    states: Mapping[str, Array],
    smaller: Callable[[Array], Any],
    more: Mapping[str, Map] | None = None,
) -> Iterator[gi.Reduction]:
    """Yield those by equal a_i of a motion on T*S^(n−1).

    Parameters
    ----------
    a : array, shape (n,)
    states : mapping of name to array
        Of ``reduced`` (γ, p) and ``hamiltonized`` (γ, p̃), as far as they are there.
    smaller : callable
        Other a_i ↦ what has the methods `reduced` and `hamiltonized`.
    more : mapping of name to callable, optional
        Further representations, and how their states follow from (γ, p).
    """
    n = len(a)
    found = {name: states[name] for name in TANGENT if name in states}
    if not found:
        return
    basis, left = planes(a, *next(iter(found.values())).reshape(2, n))
    if not 2 <= len(left) < n:
        return
    condition = f"equal a_i, or axes at rest: {len(left)} of {n} are left"
    other, lift = smaller(left), basis_lift(basis)
    for name, y in found.items():
        problem = getattr(other, name)()
        state = problem.canonical((y.reshape(2, n) @ basis).reshape(-1))
        label = f"{name}, n = {len(left)}"
        yield gi.Reduction(name, label, problem, state, lift, condition, SAME)
        for of, outer in (more or {}).items() if name == "reduced" else ():
            both = composed(outer, lift)
            yield gi.Reduction(of, label, problem, state, both, condition, SAME)


def planes(a: Array, gamma: Array, p: Array) -> tuple[Array, Array]:
    """Return Q, shape (n, n′), and the a_i that are left, shape (n′,)."""
    columns = []
    left = []
    for value in dict.fromkeys(a.tolist()):
        group = np.flatnonzero(a == value)
        inner = spanned(gamma[group], p[group]) if len(group) > 2 else np.eye(len(group))
        if not (gamma[group].any() or p[group].any()):
            continue
        for vector in inner:
            column = np.zeros(len(a))
            column[group] = vector
            columns.append(column)
            left.append(value)
    return np.array(columns).reshape(-1, len(a)).T, np.array(left)


def spanned(*vectors: Array) -> list[Array]:
    """Return an orthonormal basis of the space of some vectors."""
    basis: list[Array] = []
    for vector in vectors:
        size = length(vector)
        rest = vector / size if size > 0.0 else vector
        for _ in range(2):  # what is left after the first time may be made of roundings
            for e in basis:
                rest = rest - (rest @ e) * e
            size = length(rest)
            rest = rest / size if size > 0.0 else rest
        if size > 0.0:
            basis.append(rest)
    return basis


def momentum_lift(n: int) -> Map:
    """Return (γ, p) ↦ (k, γ), k = γ∧p."""

    def lift(y: Array) -> Array:
        return np.concatenate([wedge(y[:, :n].T, y[:, n:].T), y[:, :n].T]).T

    return lift


def planar_lift(y: Array) -> Array:
    """Return (γ, p) of (k, γ) at n = 2: p = −kγ."""
    k, x, z = y.T
    return np.stack([x, z, -k * z, k * x], axis=1)


def basis_lift(basis: Array) -> Map:
    """Return (γ′, p′) ↦ (Qγ′, Qp′)."""

    def lift(y: Array) -> Array:
        return (y.reshape(len(y), 2, -1) @ basis.T).reshape(len(y), -1)

    return lift


def composed(outer: Map, inner: Map) -> Any:
    """Return y ↦ outer(inner(y))."""

    def lift(y: Array) -> Array:
        return outer(inner(y))

    return lift
