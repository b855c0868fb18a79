"""Constants of separation, branch points and ovals of a motion, in extended precision.

Let α_g be the different a_i, P(λ) = Π(λ − α_g), and ℓ_g the angular momenta of those that stand for
several equal a_i (`symmetry`). In the spheroconical coordinates of the reduced axes every motion of the
Hamiltonised sphere, of Veselova's and of what commutes with them lies on

    −4 λ_k μ_k² = F(λ_k),   F(λ) = Σ_g α_g ℓ_g²/(λ − α_g)² + R(λ)/P(λ),   deg R = q − 2,

whose coefficients c_0 … c_(q−2) of R are the constants of separation; see `chaplygin.spheroconical` for
different a_i. λ_k runs to and fro in an *oval*. The *branch points* are 0, the α_g with ℓ_g = 0 and the
roots of T = F P Π' (λ − α_g), Π' over those with ℓ_g ≠ 0: all of them are real, and in ascending order
the first oval is between the first two that are not 0, the next one between the next two, and so on.

The coefficients of T follow from the state without a division, and all of this is done with `DIGITS`
digits, with more where points are near to one another: what is wanted of two nearly equal a_i, or of a
narrow oval, is their *distance*. The phase of a motion is then known to a rounding error of double
precision.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

import geomint as gi

from ..manifold import Array
from .symmetry import ReducedAxes

__all__ = ["DIGITS", "Oval", "Separation", "mp", "separation_of"]

DIGITS, MOST_DIGITS = 40, 160
SPARE = 32  # digits beyond twice those that a distance takes: roots of three and more may be near
mp: Any = mpmath.mp.clone()  # type: ignore[no-untyped-call]
mp.dps = DIGITS
APART = mp.mpf("1e-14")  # starts of the iteration, where double precision gives two equal roots
ITERATIONS = 200


@dataclass(frozen=True)
class Oval:
    """The interval [lower, upper] of one λ, and what the square root over it is made of.

    With (λ − lower)(upper − λ) taken out, −λFP² is Q(λ) = lead Π (λ − b) over the other branch
    points b, positive on the oval.

    Parameters
    ----------
    lower, upper : mpf
    others : tuple of mpf
    low_axis, high_axis : int or None
        The g with α_g = lower, or upper: there that component is 0, and changes its sign.
    """

    lower: Any
    upper: Any
    others: tuple[Any, ...]
    low_axis: int | None
    high_axis: int | None


@dataclass(frozen=True)
class Separation:
    """A motion's constants and its ovals.

    Parameters
    ----------
    alpha : tuple of mpf
    ell : tuple of mpf
        ℓ_g, 0 where α_g stands for one axis.
    polynomial : tuple of mpf
        The coefficients of T, ascending; for different a_i they are r_0 … r_(n−2) of R.
    ovals : tuple of Oval
        One for each λ_k, in ascending order.
    digits : int
        With which they are known, so that distances have `DIGITS` or nearly so.
    """

    alpha: tuple[Any, ...]
    ell: tuple[Any, ...]
    polynomial: tuple[Any, ...]
    ovals: tuple[Oval, ...]
    digits: int

    @property
    def lead(self) -> Any:
        """(p̃, Ap̃), the leading coefficient of T."""
        return self.polynomial[-1]


def separation_of(axes: ReducedAxes, gamma: Array, p_tilde: Array) -> Separation:
    """Return the separation of the motion through a state.

    Parameters
    ----------
    axes : ReducedAxes
        Of that state.
    gamma, p_tilde : array, shape (n,)

    Raises
    ------
    geomint.DomainError
        For p̃ = 0, and where two branch points are one to `MOST_DIGITS` digits: the motion is a
        separatrix or a steady one.
    """
    if not np.any(p_tilde):
        raise gi.DomainError(
            "p_tilde", p_tilde, "a momentum that is not zero: the state is at rest"
        )
    digits, closest = _digits_for(_closest(np.sort(axes.alpha).tolist())), 0.0
    while digits <= MOST_DIGITS:
        with mp.workdps(digits):
            found = _separation(axes, gamma, p_tilde, digits)
        if found is None:  # two roots cannot be told apart with so few
            digits *= 2
            continue
        separation, closest = found
        if _digits_for(closest) <= digits:
            return separation
        digits = _digits_for(closest)
    expected = (
        "a motion whose branch points are apart; two are nearer than "
        f"{max(closest, 10.0 ** (SPARE - MOST_DIGITS)):.1g} of their size, condition number inf"
    )
    raise gi.DomainError("state", np.concatenate([gamma, p_tilde]), expected)


def _separation(
    axes: ReducedAxes, gamma: Array, p_tilde: Array, digits: int
) -> tuple[Separation, float] | None:
    """Return the separation and the smallest distance of two points over their size, or None."""
    alpha = [mp.mpf(float(x)) for x in axes.alpha]
    products = _products(axes, gamma, p_tilde)
    polynomial = _polynomial(alpha, axes.paired, products)
    roots = _roots(polynomial)
    if roots is None:
        return None
    ell = [
        mp.sqrt(g * p - b * b) if pair else mp.mpf(0)
        for (g, b, p), pair in zip(products, axes.paired, strict=True)
    ]
    single = [(x, g) for g, x in enumerate(alpha) if not axes.paired[g]]
    free: list[tuple[Any, int | None]] = [(e, None) for e in roots]
    points = sorted([*single, *free], key=lambda pair: pair[0])
    pairs = [x for x, pair in zip(alpha, axes.paired, strict=True) if pair]
    ovals = tuple(_oval(points, k) for k in range(0, len(points), 2))
    assert len(ovals) == len(alpha) - 1
    closest = _closest(sorted([x for x, _ in points] + pairs))
    return Separation(tuple(alpha), tuple(ell), tuple(polynomial), ovals, digits), closest


def _closest(points: list[Any]) -> float:
    """Return the smallest distance of two points, in ascending order, over their size."""
    return min((float((y - x) / abs(y)) for x, y in itertools.pairwise(points)), default=1.0)


def _digits_for(closest: float) -> int:
    """Return how many digits points with such a distance take."""
    return max(DIGITS, SPARE + math.ceil(-2.0 * math.log10(max(closest, 1e-300))))


def _products(axes: ReducedAxes, gamma: Array, p_tilde: Array) -> list[tuple[Any, Any, Any]]:
    """Return (γ_g, γ_g), (γ_g, p̃_g), (p̃_g, p̃_g) of the state, projected to T*S^(n−1) exactly."""
    g, p = ([mp.mpf(float(x)) for x in v] for v in (gamma, p_tilde))
    size = mp.sqrt(sum(x * x for x in g))
    g = [x / size for x in g]
    along = sum(x * y for x, y in zip(g, p, strict=True))
    p = [y - along * x for x, y in zip(g, p, strict=True)]

    def product(x: list[Any], y: list[Any], inside: Array) -> Any:
        return mp.fsum(u * v for u, v, i in zip(x, y, inside, strict=True) if i)

    return [(product(g, g, i), product(g, p, i), product(p, p, i)) for i in axes.members]


def _polynomial(alpha: list[Any], paired: Array, products: list[tuple[Any, Any, Any]]) -> list[Any]:
    """Return the coefficients of T, ascending.

    F = −(p̃, p̃) Σ (γ_g, γ_g)/(λ − α_g) + λ Σ_{g<h} |minors|²/((λ − α_g)(λ − α_h)) + λ Σ ℓ_g²/(λ − α_g)².
    """
    indices = range(len(alpha))
    pairs = [g for g in indices if paired[g]]
    momentum = mp.fsum(p for _, _, p in products)
    degree = len(alpha) + len(pairs)
    total = [mp.mpf(0)] * (degree + 1)

    def add(weight: Any, shift: int, without: set[int], pairs_without: set[int]) -> None:
        roots = [alpha[g] for g in indices if g not in without]
        roots += [alpha[g] for g in pairs if g not in pairs_without]
        for k, c in enumerate(_product(roots)):
            total[k + shift] += weight * c

    for g, (g_g, g_b, g_p) in enumerate(products):
        add(-momentum * g_g, 0, {g}, set())
        if paired[g]:
            add(g_g * g_p - g_b * g_b, 1, {g}, {g})
        for h in range(g + 1, len(products)):
            h_g, h_b, h_p = products[h]
            add(g_g * h_p + g_p * h_g - 2 * g_b * h_b, 1, {g, h}, set())
    return total[: degree - 1]


def _product(roots: list[Any]) -> list[Any]:
    """Return the coefficients of Π (λ − root), ascending."""
    result = [mp.mpf(1)]
    for root in roots:
        longer = [mp.mpf(0), *result]
        result = [x - root * y for x, y in zip(longer, [*result, mp.mpf(0)], strict=True)]
    return result


def _roots(polynomial: list[Any]) -> list[Any] | None:
    """Return the real roots of T, whose leading coefficient (p̃, Ap̃) is positive.

    Weierstrass' iteration for all at once, from what double precision gives. None where two of them
    cannot be told apart with the digits that there are.
    """
    if len(polynomial) == 1:
        return []
    monic = [c / polynomial[-1] for c in polynomial]
    start = np.roots(np.array([float(c) for c in monic[::-1]]))
    found = [mp.mpc(complex(e)) * (1 + mp.mpf(i) * APART) for i, e in enumerate(start)]
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
        if change < mp.mpf(10) ** (4 - mp.dps):
            break
    worst = max(abs(mp.im(e)) / abs(e) for e in found)
    return None if worst > mp.mpf(10) ** (-mp.dps // 2) else [mp.re(e) for e in found]


def _oval(points: list[tuple[Any, int | None]], k: int) -> Oval:
    """Return the oval between the points k and k + 1, which are in ascending order."""
    (lower, low_axis), (upper, high_axis) = points[k], points[k + 1]
    others = tuple(value for i, (value, _) in enumerate(points) if i not in (k, k + 1))
    return Oval(lower, upper, (mp.mpf(0), *others), low_axis, high_axis)
