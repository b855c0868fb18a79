"""Constants of separation, branch points and ovals of a motion, exactly.

Let α_g be the different a_i, P(λ) = Π(λ − α_g), and ℓ_g the angular momenta of those that stand for
several equal a_i (`symmetry`). In the spheroconical coordinates of the reduced axes every motion of the
Hamiltonised sphere, of Veselova's and of what commutes with them lies on

    −4 λ_k μ_k² = F(λ_k),   F(λ) = Σ_g α_g ℓ_g²/(λ − α_g)² + R(λ)/P(λ),   deg R = q − 2,

whose coefficients c_0 … c_(q−2) of R are the constants of separation; see `chaplygin.spheroconical` for
different a_i. λ_k runs to and fro in an *oval*. The *branch points* are 0, the α_g with ℓ_g = 0 and the
roots of T = F P Π' (λ − α_g), Π' over those with ℓ_g ≠ 0: all of them are real, and in ascending order
the first oval is between the first two that are not 0, the next one between the next two, and so on.

The coefficients of T follow from the state without a division, so they are whole numbers over a common
one, and nothing is rounded before the roots are. What is wanted of two nearly equal a_i, or of a narrow
oval, is their *distance*. A rounding of T at a root moves it 1/Π |e − e_s| times as far, over the other
roots: how many bits it takes for distances of 32 digits is computed, and seen to be there.
"""

import itertools
from dataclasses import dataclass

import numpy as np

import geomint as gi

from ..manifold import Array
from .real_roots import real_roots
from .symmetry import ReducedAxes
from .whole_numbers import BITS, DoubleDouble, double_double, root_of_quotient, whole_over


@dataclass(frozen=True)
class Constants:
    """Constants of separation.

    Parameters
    ----------
    alpha : list of int
        2^bits α_g.
    bits : int
    polynomial : list of int
        The coefficients, ascending, of `below` 2^(bits (deg T + 1)) T as a polynomial in 2^bits λ.
    squares : list of int
        `below` ℓ_g², 0 where α_g stands for one axis.
    below : int
    """

    alpha: list[int]
    bits: int
    polynomial: list[int]
    squares: list[int]
    below: int

    def monic(self, bits: int) -> list[int]:
        """Return T over its leading coefficient, a polynomial in λ, in fixed-point numbers."""
        lead, degree = self.polynomial[-1], len(self.polynomial) - 1
        return [
            (c << bits) // (lead << self.bits * (degree - k)) for k, c in enumerate(self.polynomial)
        ]


def constants_of(axes: ReducedAxes, gamma: Array, p_tilde: Array) -> Constants:
    """Return the constants of a state, projected to T*S^(n−1).

    With whole numbers γ, p̃, G = (γ, γ) and P = Gp̃ − (γ, p̃)γ the unit vector is γ/√G, and its momentum
    P/G; products of two of each have the denominator G³.
    """
    (g, _), (p, unit) = whole_over(gamma.tolist()), whole_over(p_tilde.tolist())
    square = sum(x * x for x in g)
    along = sum(x * y for x, y in zip(g, p, strict=True))
    p = [square * y - along * x for x, y in zip(g, p, strict=True)]
    products = [
        tuple(
            sum(x * y for x, y, i in zip(u, v, inside, strict=True) if i)
            for u, v in ((g, g), (g, p), (p, p))
        )
        for inside in axes.members.tolist()
    ]
    alpha, bits = whole_over(axes.alpha.tolist())
    paired = axes.paired.tolist()
    squares = [
        a * c - b * b if pair else 0 for (a, b, c), pair in zip(products, paired, strict=True)
    ]
    return Constants(
        alpha, bits, _polynomial(alpha, paired, products, squares), squares, square**3 << 2 * unit
    )


def _polynomial(
    alpha: list[int], paired: list[bool], products: list[tuple[int, ...]], squares: list[int]
) -> list[int]:
    """Return the coefficients of T, ascending.

    F = −(p̃, p̃) Σ (γ_g, γ_g)/(λ − α_g) + λ Σ_{g<h} |minors|²/((λ − α_g)(λ − α_h)) + λ Σ ℓ_g²/(λ − α_g)².
    """
    indices = range(len(alpha))
    pairs = [g for g in indices if paired[g]]
    momentum = sum(p for _, _, p in products)
    total = [0] * (len(alpha) + len(pairs) + 1)

    def add(weight: int, shift: int, without: set[int], pairs_without: set[int]) -> None:
        roots = [alpha[g] for g in indices if g not in without]
        roots += [alpha[g] for g in pairs if g not in pairs_without]
        for k, c in enumerate(_product(roots)):
            total[k + shift] += weight * c

    for g, (g_g, g_b, g_p) in enumerate(products):
        add(-momentum * g_g, 0, {g}, set())
        if paired[g]:
            add(squares[g], 1, {g}, {g})
        for h in range(g + 1, len(products)):
            h_g, h_b, h_p = products[h]
            add(g_g * h_p + g_p * h_g - 2 * g_b * h_b, 1, {g, h}, set())
    return total[:-2]


def _product(roots: list[int]) -> list[int]:
    """Return the coefficients of Π (λ − root), ascending."""
    result = [1]
    for root in roots:
        result = [x - root * y for x, y in zip([0, *result], [*result, 0], strict=True)]
    return result


MOST_BITS = 1400
SPARE = 112  # bits of every distance
NEAREST = 1e-64  # points, over their size: nearer ones count as one
SEEN = 340  # bits with which such distances are seen

Point = tuple[int, int | None]  # over 2^bits, and the g if it is α_g
Ends = tuple[Point, Point]  # of an oval


@dataclass(frozen=True)
class Oval:
    """The interval [lower, upper] of one λ.

    With (λ − lower)(upper − λ) taken out, −λFP² is Q(λ) = lead Π (λ − b) over the other branch
    points b, positive on the oval.

    Parameters
    ----------
    lower, upper : float
    low_axis, high_axis : int or None
        The g with α_g = lower, or upper: there that component is 0, and changes its sign.
    """

    lower: float
    upper: float
    low_axis: int | None
    high_axis: int | None


@dataclass(frozen=True)
class Separation:
    """A motion's constants and its ovals; double-doubles have a last axis of two numbers.

    Parameters
    ----------
    alpha : array, shape (q,)
    paired : array of bool, shape (q,)
        Whether α_g stands for several equal a_i.
    ell : array, shape (q, 2)
        ℓ_g, 0 where α_g stands for one axis.
    polynomial : array, shape (deg T + 1,)
        The coefficients of T, ascending; for different a_i they are r_0 … r_(n−2) of R.
    lead : array, shape (2,)
        (p̃, Ap̃), the last of them.
    ovals : tuple of Oval
        One for each λ_k, in ascending order; d = q − 1.
    middles, widths : array, shape (d, 2)
    branch_gaps, axis_gaps : array, shape (d, 2d−1, 2), (d, q, 2)
        From the ovals to the branch points of Q, 0 first, and to the α_g: positive from points below
        to the lower end, negative from points above to the upper end; ±0 at the ends themselves.
    oval_gaps : array, shape (d, d, 2)
        From the nearer end of one oval to that of another, positive from those below.
    """

    alpha: Array
    paired: Array
    ell: Array
    polynomial: Array
    lead: Array
    ovals: tuple[Oval, ...]
    middles: Array
    widths: Array
    branch_gaps: Array
    axis_gaps: Array
    oval_gaps: Array


def separation_of(axes: ReducedAxes, gamma: Array, p_tilde: Array) -> Separation:
    """Return the separation of the motion through a state.

    Parameters
    ----------
    axes : ReducedAxes
        Of that state, with α_g up to 1.
    gamma, p_tilde : array, shape (n,)

    Raises
    ------
    geomint.DomainError
        For p̃ = 0, and where two branch points are nearer than `NEAREST`, or one to `MOST_BITS`
        bits: the motion is a separatrix or a steady one.
    """
    if not np.any(p_tilde):
        raise gi.DomainError(
            "p_tilde", p_tilde, "a momentum that is not zero: the state is at rest"
        )
    constants = constants_of(axes, gamma, p_tilde)
    closest, bits = 0.0, BITS
    while bits <= MOST_BITS:
        alpha = [x << bits >> constants.bits for x in constants.alpha]
        roots = real_roots(constants.monic(bits), alpha, axes.paired, bits)
        if roots is None:
            bits *= 2
            continue
        closest = _closest([*alpha, *roots])
        needed = _bits_for(roots, alpha, bits)
        if closest < NEAREST and bits >= SEEN:
            break
        if needed <= bits:
            return _separation(constants, axes.paired, alpha, roots, bits)
        bits = needed
    expected = (
        "a motion whose branch points are apart, as far as "
        f"{MOST_BITS} bits show; two are at {closest:.1g} of their size, condition number inf"
    )
    raise gi.DomainError("state", np.concatenate([gamma, p_tilde]), expected)


def _separation(
    constants: Constants, paired: Array, alpha: list[int], roots: list[int], bits: int
) -> Separation:
    """Return what is known with the roots, in double-doubles."""
    axes = list(zip(alpha, range(len(alpha)), strict=True))
    single = [point for point, pair in zip(axes, paired, strict=True) if not pair]
    points = sorted([*single, *((e, None) for e in roots)], key=lambda x: x[0])
    ends = list(zip(points[::2], points[1::2], strict=True))
    one = 1 << bits

    def gap(oval: Ends, b: int) -> DoubleDouble:
        (lower, _), (upper, _) = oval
        if b == upper:
            return -0.0, 0.0
        return double_double(lower - b if b <= lower else upper - b, one)

    def between(oval: Ends, other: Ends) -> DoubleDouble:
        if other is oval:
            return 0.0, 0.0
        return gap(oval, other[1][0] if other[1][0] <= oval[0][0] else other[0][0])

    def others(oval: Ends) -> list[int]:
        return [0, *(b for b, _ in points if b not in (oval[0][0], oval[1][0]))]

    size, count = len(constants.polynomial) - 1, len(ends)
    scales = [constants.below << constants.bits * (size + 1 - k) for k in range(size + 1)]
    return Separation(
        np.array([a / (1 << constants.bits) for a in constants.alpha]),
        paired,
        np.array([root_of_quotient(x, constants.below) for x in constants.squares]),
        np.array([c / scale for c, scale in zip(constants.polynomial, scales, strict=True)]),
        np.array(double_double(constants.polynomial[-1], scales[-1])),
        tuple(Oval(x / one, y / one, g, h) for (x, g), (y, h) in ends),
        _array([double_double(x + y, 2 * one) for (x, _), (y, _) in ends], count),
        _array([double_double(y - x, one) for (x, _), (y, _) in ends], count),
        _array([gap(oval, b) for oval in ends for b in others(oval)], count, 2 * count - 1),
        _array([gap(oval, x) for oval in ends for x in alpha], count, len(alpha)),
        _array([between(oval, other) for oval in ends for other in ends], count, count),
    )


def _array(values: list[DoubleDouble], *shape: int) -> Array:
    return np.array(values).reshape(*(max(size, 0) for size in shape), 2)


def _closest(points: list[int]) -> float:
    """Return the least distance of two points over their size."""
    pairs = itertools.pairwise(sorted(points))
    return min(((y - x) / y if y else 0.0 for x, y in pairs), default=1.0)


def _bits_for(roots: list[int], alpha: list[int], bits: int) -> int:
    """Return with how many bits the distances of all points have `SPARE`, that from 0 among them."""
    gaps = [alpha[0], *(y - x for x, y in itertools.pairwise(alpha))]
    lost = bits - min(gaps).bit_length()
    for i, e in enumerate(roots):
        apart = [abs(e - x) for s, x in enumerate(roots) if s != i]
        nearest = min([abs(e), *apart, *(abs(e - x) for x in alpha)])
        moved = sum(bits - x.bit_length() + 1 for x in [*apart, nearest])
        lost = max(lost, moved + (2 * len(roots)).bit_length())  # as often T is rounded
    return max(BITS, SPARE + lost)
