"""Constants of separation, branch points and ovals of a motion, in extended precision.

In spheroconical coordinates every motion of the Hamiltonised sphere, of Veselova's and of what
commutes with them lies on

    −4 λ_k P(λ_k) μ_k² = R(λ_k),   P(λ) = Π(λ − a_i),   R of degree n − 2,

see `chaplygin.spheroconical`. λ_k runs to and fro in an *oval*: the interval between two
neighbouring *branch points*, which are 0, the a_i and the roots e_j of R, that contains it and where
−λPR > 0. The coefficients of R follow from the state without a division, and all of this is done with
`DIGITS` digits: the phase of a motion is then known to a rounding error of double precision.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

import geomint as gi

from ..manifold import Array
from ..spheroconical import Spheroconical

__all__ = ["DIGITS", "Oval", "Separation", "mp", "separation_of"]

DIGITS = 40
mp: Any = mpmath.mp.clone()  # type: ignore[no-untyped-call]
mp.dps = DIGITS
SPREAD = mp.mpf("1e-14")  # apart even where double precision gives two equal roots
ITERATIONS = 200
MERGED = 1e-10  # distances of branch points below this part of their size: no torus in double


@dataclass(frozen=True)
class Oval:
    """The interval [lower, upper] of one λ, and what the square root over it is made of.

    With (λ − lower)(upper − λ) taken out, −λPR is Q(λ) = r_(n−2) Π (λ − b) over the other branch
    points b, positive on the oval.

    Parameters
    ----------
    lower, upper : mpf
    others : tuple of mpf
    low_axis, high_axis : int or None
        The i with a_i = lower, or upper: there γ_i = 0, and changes its sign.
    """

    lower: Any
    upper: Any
    others: tuple[Any, ...]
    low_axis: int | None
    high_axis: int | None


@dataclass(frozen=True)
class Separation:
    """A motion's constants r_0 … r_(n−2), its ovals, and how near to degenerate it is.

    Parameters
    ----------
    r : tuple of mpf
    ovals : tuple of Oval
        One for each λ_k, in ascending order.
    condition : float
        The largest size of a branch point over the distance to the next one: about what relative
        errors of the state are magnified by in frequencies.
    """

    r: tuple[Any, ...]
    ovals: tuple[Oval, ...]
    condition: float


def separation_of(a: Array, gamma: Array, p_tilde: Array) -> Separation:
    """Return the separation of the motion through a state.

    Parameters
    ----------
    a : array, shape (n,)
        All different.
    gamma, p_tilde : array, shape (n,)

    Raises
    ------
    geomint.DomainError
        For p̃ = 0, and where two branch points are so near to one another that the motion is all but
        a separatrix or a steady one: with the condition number.
    """
    n = len(a)
    if not np.any(p_tilde):
        raise gi.DomainError(
            "p_tilde", p_tilde, "a momentum that is not zero: the state is at rest"
        )
    r = _coefficients(a, gamma, p_tilde)
    roots = _roots(r)
    axes = [(mp.mpf(float(x)), i) for i, x in enumerate(a)]
    points = sorted(
        [(mp.mpf(0), None), *axes, *((e, None) for e in roots)], key=lambda pair: pair[0]
    )
    values = [value for value, _ in points]
    gaps = [float((y - x) / abs(y)) for x, y in itertools.pairwise(values) if y > 0]
    closest = min(gaps)
    if closest < MERGED:
        expected = (
            f"a motion whose branch points are apart; two are nearer than {MERGED:g} of their size: "
            f"condition number {1.0 / max(closest, 1e-300):.3g}"
        )
        raise gi.DomainError("state", np.concatenate([gamma, p_tilde]), expected)
    lam, _ = Spheroconical(a).coordinates(gamma)
    ovals = tuple(_oval(points, r[-1], float(x)) for x in lam)
    assert len(ovals) == n - 1
    return Separation(tuple(r), ovals, 1.0 / closest)


def _coefficients(a: Array, gamma: Array, p_tilde: Array) -> list[Any]:
    """Return r_0, …, r_(n−2) of the state, projected to T*S^(n−1) exactly."""
    n = len(a)
    axes = [mp.mpf(float(x)) for x in a]
    g, p = ([mp.mpf(float(x)) for x in v] for v in (gamma, p_tilde))
    size = mp.sqrt(sum(x * x for x in g))
    g = [x / size for x in g]
    along = sum(x * y for x, y in zip(g, p, strict=True))
    p = [y - along * x for x, y in zip(g, p, strict=True)]
    pp = sum(y * y for y in p)
    total = [mp.mpf(0)] * (n + 1)
    for i in range(n):
        for k, c in enumerate(_product(axes, {i})):
            total[k] -= pp * g[i] * g[i] * c
        for j in range(i + 1, n):
            minor = (g[i] * p[j] - g[j] * p[i]) ** 2
            for k, c in enumerate(_product(axes, {i, j})):
                total[k + 1] += minor * c
    return total[: n - 1]


def _product(roots: list[Any], without: set[int]) -> list[Any]:
    """Return the coefficients of Π (λ − root), ascending."""
    result = [mp.mpf(1)]
    for i, root in enumerate(roots):
        if i not in without:
            longer = [mp.mpf(0), *result]
            result = [x - root * y for x, y in zip(longer, [*result, mp.mpf(0)], strict=True)]
    return result


def _roots(r: list[Any]) -> list[Any]:
    """Return the real roots of R, whose leading coefficient (p̃, Ap̃) is positive.

    Weierstrass' iteration for all at once, from what double precision gives.
    """
    if len(r) == 1:
        return []
    monic = [c / r[-1] for c in r]
    start = np.roots(np.array([float(c) for c in monic[::-1]]))
    found = [mp.mpc(complex(e)) * (1 + mp.mpf(i) * SPREAD) for i, e in enumerate(start)]
    for _ in range(ITERATIONS):
        change = mp.mpf(0)
        for i, e in enumerate(found):
            step = mp.mpc(0)
            for c in reversed(monic):
                step = step * e + c
            for s, other in enumerate(found):
                if s != i:
                    step /= e - other
            found[i] = e - step
            change = max(change, abs(step) / abs(e))
        if change < mp.mpf(10) ** (4 - DIGITS):
            break
    worst = max(abs(mp.im(e)) / abs(e) for e in found)
    if worst > mp.mpf(10) ** (-DIGITS // 2):
        expected = "a motion with real roots of R: two of them merge, condition number "
        raise gi.DomainError("state", [float(x) for x in r], f"{expected}{float(1 / worst):.3g}")
    return [mp.re(e) for e in found]


def _oval(points: list[tuple[Any, int | None]], lead: Any, lam: float) -> Oval:
    """Return the interval of neighbouring branch points around λ on which −λPR > 0."""
    values = [value for value, _ in points]
    best: tuple[float, int] | None = None
    for k in range(1, len(points) - 1):  # from 0 to the least a_i there is no λ
        lower, upper = values[k], values[k + 1]
        above = len(points) - 2 - k  # branch points above the interval
        if (-1) ** above * lead <= 0:  # Q > 0 there
            continue
        outside = max(float(lower) - lam, lam - float(upper), 0.0)
        if best is None or outside < best[0]:
            best = (outside, k)
    assert best is not None
    k = best[1]
    others = tuple(value for i, value in enumerate(values) if i not in (k, k + 1))
    return Oval(values[k], values[k + 1], others, points[k][1], points[k + 1][1])
