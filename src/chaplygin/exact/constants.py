"""Constants of separation of a motion, exactly: whole numbers over a common one.

The equations are in `branch_points`; the coefficients of T follow from the state without a division.
"""

from dataclasses import dataclass

from ..manifold import Array
from .symmetry import ReducedAxes
from .whole_numbers import whole_over


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
        tuple(_product_within(inside, u, v) for u, v in ((g, g), (g, p), (p, p)))
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


def _product_within(inside: list[bool], u: list[int], v: list[int]) -> int:
    return sum(x * y for x, y, i in zip(u, v, inside, strict=True) if i)


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
