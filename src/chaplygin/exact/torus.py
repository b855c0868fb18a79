"""The invariant torus: periods, linear angles, and the angles θ in which states are simple.

On the oval of λ_k let λ = m − d cos θ. With μ = d sin θ √Q/(2λP) the differentials of the variables
conjugate to the constants c_j and ℓ_g of `branch_points` are smooth and periodic,

    ∂μ/∂c_j dλ = −¼ λ^j/√Q dθ,   ∂μ/∂ℓ_g dλ = −½ ℓ_g α_g P/((λ − α_g)² √Q) dθ,

and β_j = Σ_k ∫ ∂μ_k/∂c_j dλ_k grows with the rate ∂H/∂c_j. For powers of λ take Lagrange's polynomials
on the middles of the ovals, which only mixes the β_j: with them the period matrix, the means Π_jk over
one turn of θ_k, is nearly diagonal, and nothing cancels in high dimensions. The angles φ = 2π Π⁻¹β are
linear in time and advance by 2π where θ does, so that with sine series s

    φ = θ + 2π Π⁻¹ Σ_k s_k(θ_k),   dφ/dτ = ω = 2π Π⁻¹ ∂H/∂c.

With m_gk, the means of ∂μ_k/∂ℓ_g dλ_k/dθ_k, the polar angle ψ_g of a pair has the linear angle

    Φ_g = ψ_g + Σ_k [s_gk(θ_k) + m_gk (θ_k − φ_k)],   dΦ_g/dτ = Ω_g = ∂H/∂ℓ_g − Σ_k m_gk ω_k.

So all of them are (φ, Φ) = (θ, ψ) + Σ_k shift_k(θ_k).

Every difference of λ_k and a point b beyond an end of its oval is a sum of positive numbers,

    |λ_k − b| = gap + 2d sin²(θ_k/2), or gap + 2d cos²(θ_k/2),

b below or above: with the gap from that end to b known to rounding, it keeps all digits where a_i are
nearly equal and ovals narrow.

Coefficients decay like e^{−mη}, cosh η = 1 + gap/d for the nearest point. So the trapezoidal rule gives
the periods to 32 digits with a few dozen points (`periods`) where points are apart, and how many it
takes is known beforehand.

The frequencies follow from the period matrix by linear algebra without rounding. With the means M
of the differentials in the units of `periods`, and an energy ½ (x F(0) + y (p̃, Ap̃)),

    Σ_k M_jk ω_k = ½ (x Π_{s≠j} m_s/Π_g α_g + y),   Ω_g = ℓ_g (x/α_g + y α_g − 2α_g Σ_k M_gk ω_k):

of the ∂H/∂c_i only the first and the last are not 0. Double-doubles are whole numbers over a power of
two, and there are few of them.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..manifold import Array
from .branch_points import Separation
from .periods import Periods, periods_of
from .separated_energy import SeparatedEnergy
from .whole_numbers import DoubleDouble, double_double, eliminated, whole_of, whole_over

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


def _turns(above: int, below: int) -> DoubleDouble:
    """Return a frequency over 4π."""
    inverse, bits = INVERSE_4PI
    return double_double(above * inverse, below << bits)


def _nothing(size: int, pairs: int) -> Rates:
    turns = np.full(size + pairs, np.nan)
    return Rates(np.full((size, size), np.nan), turns, turns)


TERMS = 1e-17  # Fourier coefficients below this, in radians, are left out: FFT's noise is 1e-18


@dataclass(frozen=True)
class Torus:
    """A torus of d = q − 1 angles θ and some pairs' angles ψ: numbers for `functions`.

    Parameters
    ----------
    middle, radius : array, shape (d,)
        m and d of every oval.
    branch_gaps, axis_gaps : array, shape (d, 2d−1), (d, q)
        From the ovals to the branch points of Q, 0 first, and to the α_g: positive from points below
        to the lower end, negative from points above to the upper end; ±0 at the ends themselves.
    oval_gaps : array, shape (d, d)
        From the nearer end of one oval to that of another, positive from those below.
    lead : float
    means : array, shape (d, d + pairs)
        The means of the differentials of λ_k over one turn.
    shifts : tuple of array, shape (d + pairs, terms)
        For every θ_k the coefficients of sin mθ_k, m = 1, 2, …
    strips : array, shape (d,)
        η: half widths of the strips around real θ_k in which all this is analytic.
    turns, turns_low : array, shape (d + pairs,)
        Frequencies over 4π in the flow's time τ, in two parts: turns of 4π, by which signs return.
    """

    middle: Array
    radius: Array
    branch_gaps: Array
    axis_gaps: Array
    oval_gaps: Array
    lead: float
    means: Array
    shifts: tuple[Array, ...]
    strips: Array
    turns: Array
    turns_low: Array

    @property
    def frequencies(self) -> Array:
        """ω and Ω, shape (d + pairs,)."""
        return 4.0 * np.pi * self.turns


def distances(gaps: Array, radius: Any, sine: Any) -> Array:
    """Return λ − b from the gaps of an oval, its radius and sin²(θ/2), of shapes that broadcast."""
    return gaps + 2.0 * radius * np.where(np.signbit(gaps), sine - 1.0, sine)


def products_without_one(factors: Array) -> Array:
    """Return the products of all but one along the last axis, shape (..., q) ↦ (..., q)."""
    size = factors.shape[-1]
    kept = np.where(np.eye(size, dtype=bool), 1.0, factors[..., None, :])
    return np.prod(kept, axis=-1)


def torus_of(separation: Separation, energy: SeparatedEnergy) -> Torus:
    """Return the torus of a motion, for the flow of an energy.

    Raises
    ------
    geomint.DomainError
        If the periods take too many points: the motion is next to a separatrix.
    """
    found = periods_of(separation)
    rates = rates_of(separation, energy, found)
    scales = _scales(separation)
    return Torus(
        separation.middles[:, 0],
        0.5 * separation.widths[:, 0],
        separation.branch_gaps[..., 0],
        separation.axis_gaps[..., 0],
        separation.oval_gaps[..., 0],
        float(separation.lead[0]),
        found.means[..., 0] * scales,
        tuple(_heard(_shift(x, found, rates, scales)) for x in found.samples),
        found.strips,
        rates.turns,
        rates.turns_low,
    )


def frequencies_on(separation: Separation, energy: SeparatedEnergy) -> Array:
    """Return ω and Ω of the flow of another energy on a torus, linear in it."""
    return 4.0 * np.pi * rates_of(separation, energy, periods_of(separation)).turns


def _scales(separation: Separation) -> Array:
    """Return the units of `periods`: 1/Π_{s≠j} (m_j − m_s), then 2ℓ_gα_g, shape (d + pairs,)."""
    size, paired = len(separation.ovals), separation.paired
    radius = 0.5 * separation.widths[:, 0]
    sides = np.tri(size, k=-1) - np.tri(size, k=-1).T
    apart = separation.oval_gaps[..., 0] + sides * (radius[:, None] + radius) + np.eye(size)
    pairs = 2.0 * separation.ell[paired, 0] * separation.alpha[paired]
    return np.concatenate([1.0 / np.prod(apart, axis=1), pairs])


def _shift(values: Array, found: Periods, rates: Rates, scales: Array) -> Array:
    """Return the coefficients of sin mθ_k in (φ, Φ) − (θ, ψ), shape (d + pairs, terms)."""
    half, size = values.shape[1] - 1, len(rates.inverse)
    even = np.concatenate([values, values[:, -2:0:-1]], axis=1)
    cosines = np.fft.rfft(even, axis=1).real[:, 1:half] / half
    sines = cosines / np.arange(1, half)
    phi = rates.inverse @ sines[:size]
    pairs = sines[size:] - found.means[:, size:, 0].T @ phi
    return np.concatenate([phi, scales[size:, None] * pairs])


def _heard(series: Array) -> Array:
    """Return the series without its last terms that are too small to matter."""
    loud = np.flatnonzero(np.max(np.abs(series), axis=0) > TERMS)
    return series[:, : int(loud[-1]) + 1 if len(loud) else 1]
