"""The frequencies of a torus from its period matrix: linear algebra without rounding.

With the means M of the differentials in the units of `periods`, and an energy ½ (x F(0) + y (p̃, Ap̃)),

    Σ_k M_jk ω_k = ½ (x Π_{s≠j} m_s/Π_g α_g + y),   Ω_g = ℓ_g (x/α_g + y α_g − 2α_g Σ_k M_gk ω_k):

of the ∂H/∂c_i only the first and the last are not 0. Double-doubles are whole numbers over a power of
two, and there are few of them.
"""

import math
from dataclasses import dataclass

import numpy as np

from ..manifold import Array
from .branch_points import Separation
from .periods import Periods
from .separated_energy import SeparatedEnergy
from .whole_numbers import double_double, eliminated, whole_of, whole_over

INVERSE_4PI = 0x145F306DC9C882A53F84EAFA3EA69BB81B6C52B327887208, 192  # 1/4π over 2^192


@dataclass(frozen=True)
class Rates:
    """Frequencies of the flow of an energy on a torus.

    Parameters
    ----------
    inverse : array, shape (d, d)
        M⁻¹, of its first d rows: what becomes angles of the integrals of the differentials.
    turns, turns_low : array, shape (d + pairs,)
        ω and Ω over 4π, in two parts.
    """

    inverse: Array
    turns: Array
    turns_low: Array


def rates_of(separation: Separation, energy: SeparatedEnergy, periods: Periods) -> Rates:
    """Return the frequencies of the flow of an energy on a torus; NaN where they are no numbers."""
    size, pairs = len(separation.ovals), np.flatnonzero(separation.paired).tolist()
    if not (math.isfinite(energy.at_zero) and math.isfinite(energy.at_infinity)):
        return _nothing(size, len(pairs))
    means, bits = whole_of(periods.means)
    alpha, of_alpha = whole_over(separation.alpha.tolist())
    (x, y), of_energy = whole_over((energy.at_zero, energy.at_infinity))
    right, below = _right(separation, x, y, math.prod(alpha), of_alpha * len(alpha))
    matrix = [
        [*(mean[j] for mean in means), r, *(int(j == k) for k in range(size))]
        for j, r in enumerate(right)
    ]
    common = eliminated(matrix)
    if common == 0:
        return _nothing(size, len(pairs))
    omega = [row[size] for row in matrix]  # times 2^bits/over
    over = common * below << of_energy
    turns = [_turns(w << bits, over) for w in omega]
    ell, of_ell = whole_of(separation.ell)
    for i, g in enumerate(pairs, start=size):
        square = alpha[g] * alpha[g]
        changed = 2 * square * sum(mean[i] * w for mean, w in zip(means, omega, strict=True))
        above = ((x << 2 * of_alpha) + y * square) * common * below - changed
        turns.append(_turns(ell[g] * above, over * alpha[g] << of_alpha + of_ell))
    high, low = np.array(turns).reshape(-1, 2).T
    return Rates(
        np.array([[(x << bits) / common for x in row[size + 1 :]] for row in matrix]).reshape(
            size, size
        ),
        np.ldexp(high, energy.exponent),
        np.ldexp(low, energy.exponent),
    )


def _right(
    separation: Separation, x: int, y: int, product: int, of_product: int
) -> tuple[list[int], int]:
    """Return x Π_{s≠j} m_s/(2Π_g α_g) + y/2 for every j, with its denominator."""
    middles, bits = whole_of(separation.middles)
    bits *= max(len(middles) - 1, 0)
    right = []
    for j in range(len(middles)):
        others = math.prod(middles[:j] + middles[j + 1 :])
        right.append((x * others << of_product) + (y * product << bits))
    return right, product << bits + 1


def _turns(above: int, below: int) -> tuple[float, float]:
    """Return a frequency over 4π."""
    inverse, bits = INVERSE_4PI
    return double_double(above * inverse, below << bits)


def _nothing(size: int, pairs: int) -> Rates:
    turns = np.full(size + pairs, np.nan)
    return Rates(np.full((size, size), np.nan), turns, turns)
