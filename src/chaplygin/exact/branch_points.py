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
precision. A rounding of the coefficients moves a root e by Σ|c_j e^j|/|T'(e)| times as much, which is
1/gap^m with m roots within a gap: how many digits that takes is computed, and seen to be there.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

import geomint as gi

from ..manifold import Array
from .real_roots import mp, real_roots
from .symmetry import ReducedAxes

__all__ = ["DIGITS", "Oval", "Separation", "mp", "separation_of"]

DIGITS, MOST_DIGITS = 40, 400
SPARE = 32  # digits of every distance
NEAREST = 1e-64  # points, over their size: nearer ones count as one


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
        For p̃ = 0, and where two branch points are nearer than `NEAREST`, or one to `MOST_DIGITS`
        digits: the motion is a separatrix or a steady one.
    """
    if not np.any(p_tilde):
        raise gi.DomainError(
            "p_tilde", p_tilde, "a momentum that is not zero: the state is at rest"
        )
    digits, closest = _digits_of_axes(axes.alpha.tolist()), 0.0
    while digits <= MOST_DIGITS:
        with mp.workdps(digits):
            found = _separation(axes, gamma, p_tilde, digits)
        if found is None:
            digits *= 2
            continue
        separation, closest, needed = found
        if closest < NEAREST:
            break
        if needed <= digits:
            return separation
        digits = needed
    expected = (
        "a motion whose branch points are apart, as far as "
        f"{MOST_DIGITS} digits show; two are at {closest:.1g} of their size, condition number inf"
    )
    raise gi.DomainError("state", np.concatenate([gamma, p_tilde]), expected)


def _separation(
    axes: ReducedAxes, gamma: Array, p_tilde: Array, digits: int
) -> tuple[Separation, float, int] | None:
    """Return the separation, the least distance of two points over their size, and the digits it takes.

    None if the roots cannot be separated with so few.
    """
    alpha = [mp.mpf(float(x)) for x in axes.alpha]
    products = _products(axes, gamma, p_tilde)
    polynomial, sizes = _polynomial(alpha, axes.paired, products)
    roots = real_roots(polynomial, alpha, axes.paired)
    if roots is None:
        return None
    ell = [
        mp.sqrt(g * p - b * b) if pair else mp.mpf(0)
        for (g, b, p), pair in zip(products, axes.paired, strict=True)
    ]
    single = [(x, g) for g, x in enumerate(alpha) if not axes.paired[g]]
    free: list[tuple[Any, int | None]] = [(e, None) for e in roots]
    points = sorted([*single, *free], key=lambda pair: pair[0])
    ovals = tuple(_oval(points, k) for k in range(0, len(points), 2))
    assert len(ovals) == len(alpha) - 1
    ordered = sorted([*alpha, *roots])
    closest = min((float((y - x) / abs(y)) for x, y in itertools.pairwise(ordered)), default=1.0)
    found = Separation(tuple(alpha), tuple(ell), tuple(polynomial), ovals, digits)
    return found, closest, _digits_for(roots, alpha, polynomial[-1], sizes)


def _digits_of_axes(alpha: list[float]) -> int:
    """Return how many digits it takes if the roots are as near to one another as the α_g."""
    lost = [sum(-math.log10(abs(x - y) / max(x, y)) for y in alpha if y != x) for x in alpha]
    return max(DIGITS, SPARE + math.ceil(max(lost)))


def _digits_for(roots: list[Any], alpha: list[Any], lead: Any, sizes: list[Any]) -> int:
    """Return with how many digits the distances of all roots have `SPARE`.

    `sizes` are those of the terms in the coefficients: what is rounded.
    """
    lost = mp.mpf(1)
    for i, e in enumerate(roots):
        apart = [abs(e - x) for s, x in enumerate(roots) if s != i]
        nearest = min([*apart, *(abs(e - x) for x in alpha)])
        slope = lead * mp.fprod(apart) * nearest
        if slope == 0:
            return MOST_DIGITS + 1
        lost = max(lost, mp.fsum(c * abs(e) ** k for k, c in enumerate(sizes)) / slope)
    return max(DIGITS, SPARE + math.ceil(float(mp.log10(lost))))


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


def _polynomial(
    alpha: list[Any], paired: Array, products: list[tuple[Any, Any, Any]]
) -> tuple[list[Any], list[Any]]:
    """Return the coefficients of T, ascending, and the sums of the sizes of their terms.

    F = −(p̃, p̃) Σ (γ_g, γ_g)/(λ − α_g) + λ Σ_{g<h} |minors|²/((λ − α_g)(λ − α_h)) + λ Σ ℓ_g²/(λ − α_g)².
    """
    indices = range(len(alpha))
    pairs = [g for g in indices if paired[g]]
    momentum = mp.fsum(p for _, _, p in products)
    degree = len(alpha) + len(pairs)
    total, sizes = [mp.mpf(0)] * (degree + 1), [mp.mpf(0)] * (degree + 1)

    def add(terms: list[Any], shift: int, without: set[int], pairs_without: set[int]) -> None:
        roots = [alpha[g] for g in indices if g not in without]
        roots += [alpha[g] for g in pairs if g not in pairs_without]
        weight, size = sum(terms), sum(map(abs, terms))
        for k, c in enumerate(_product(roots)):
            total[k + shift] += weight * c
            sizes[k + shift] += size * abs(c)

    for g, (g_g, g_b, g_p) in enumerate(products):
        add([-momentum * g_g], 0, {g}, set())
        if paired[g]:
            add([g_g * g_p, -g_b * g_b], 1, {g}, {g})
        for h in range(g + 1, len(products)):
            h_g, h_b, h_p = products[h]
            add([g_g * h_p, g_p * h_g, -2 * g_b * h_b], 1, {g, h}, set())
    return total[: degree - 1], sizes[: degree - 1]


def _product(roots: list[Any]) -> list[Any]:
    """Return the coefficients of Π (λ − root), ascending."""
    result = [mp.mpf(1)]
    for root in roots:
        longer = [mp.mpf(0), *result]
        result = [x - root * y for x, y in zip(longer, [*result, mp.mpf(0)], strict=True)]
    return result


def _oval(points: list[tuple[Any, int | None]], k: int) -> Oval:
    """Return the oval between the points k and k + 1, which are in ascending order."""
    (lower, low_axis), (upper, high_axis) = points[k], points[k + 1]
    others = tuple(value for i, (value, _) in enumerate(points) if i not in (k, k + 1))
    return Oval(lower, upper, (mp.mpf(0), *others), low_axis, high_axis)
