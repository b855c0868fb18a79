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

Coefficients decay geometrically: the trapezoidal rule gives the periods to more than 32 digits with
a few dozen points, if the branch points are apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import geomint as gi

from ..manifold import Array
from .branch_points import Oval, Separation, mp

__all__ = ["SeparatedEnergy", "Torus", "torus_of"]

MOST_POINTS = 16384  # of the trapezoidal rule; more are needed only next to a separatrix
AGREEMENT = mp.mpf("1e-18")  # of N and N/2 points: the error is squared when N is doubled
TERMS = 1e-17  # Fourier coefficients below this, in radians, are left out: FFT's noise is 1e-18


@dataclass(frozen=True)
class SeparatedEnergy:
    """A Hamiltonian that is separated in spheroconical coordinates: H = ½ (x F(0) + y (p̃, Ap̃)).

    (p̃, Ap̃) is the limit of λ²F. Sphere: x = D, y = −1; Veselova: x = 0, y = D².

    Parameters
    ----------
    at_zero, at_infinity : float or mpf
        x and y.
    """

    at_zero: Any
    at_infinity: Any

    def in_units(self, unit: float, unit_p: float) -> SeparatedEnergy:
        """Return the energy whose flow is the same in time where a and p̃ are measured in units."""
        a, p = mp.mpf(unit), mp.mpf(unit_p)
        return SeparatedEnergy(mp.mpf(self.at_zero) * p / a, mp.mpf(self.at_infinity) * p * a)

    def slopes(self, alpha: Any) -> list[Any]:
        """Return ∂H/∂c_j, j = 0 … q−2."""
        weights = [mp.mpf(0)] * (len(alpha) - 1)
        if weights:
            weights[0] += mp.mpf(self.at_zero) / (2 * mp.fprod(-x for x in alpha))
            weights[-1] += mp.mpf(self.at_infinity) / 2
        return weights

    def turning(self, alpha: Any, ell: Any) -> Any:
        """Return ∂H/∂ℓ of a pair."""
        return ell * (mp.mpf(self.at_zero) / alpha + mp.mpf(self.at_infinity) * alpha)


@dataclass(frozen=True)
class Torus:
    """A torus of d = q − 1 angles θ and some pairs' angles ψ: numbers for `functions`.

    Parameters
    ----------
    middle, radius : array, shape (d,)
        m and d of every oval.
    others : array, shape (d, 2d−1)
        The branch points of Q.
    lead : float
    shifts : tuple of array, shape (d + pairs, terms)
        For every θ_k the coefficients of sin mθ_k, m = 1, 2, …
    turns, turns_low : array, shape (d + pairs,)
        Frequencies over 4π in the flow's time τ, in two parts: turns of 4π, by which signs return.
    """

    middle: Array
    radius: Array
    others: Array
    lead: float
    shifts: tuple[Array, ...]
    turns: Array
    turns_low: Array

    @property
    def frequencies(self) -> Array:
        """ω and Ω, shape (d + pairs,)."""
        return np.asarray(4.0 * np.pi * self.turns)


def lagrange(nodes: Any, x: Any) -> list[Any]:
    """Return ℓ_j(x), Lagrange's polynomials on the nodes."""
    rows = []
    for j, node in enumerate(nodes):
        value = mp.mpf(1)
        for s, other in enumerate(nodes):
            if s != j:
                value = value * ((x - other) / (node - other))
        rows.append(value)
    return rows


def torus_of(separation: Separation, energy: SeparatedEnergy) -> Torus:
    """Return the torus of a motion, for the flow of an energy.

    Raises
    ------
    geomint.DomainError
        If the periods do not converge: the motion is next to a separatrix.
    """
    ovals, size = separation.ovals, len(separation.ovals)
    nodes = [(o.lower + o.upper) / 2 for o in ovals]
    pairs = [g for g, ell in enumerate(separation.ell) if ell]
    means, samples = [], []
    for oval in ovals:
        mean, values = _means(oval, separation, nodes, pairs)
        means.append(mean)
        samples.append(values)
    turns = _turns(separation, energy, nodes, pairs, means)
    high = [float(x) for x in turns]
    inverse = _inverse(means, size)
    shifts = [_shift(values, inverse, means, k) for k, values in enumerate(samples)]
    return Torus(
        np.array([float(x) for x in nodes]),
        np.array([float((o.upper - o.lower) / 2) for o in ovals]),
        np.array([[float(b) for b in o.others] for o in ovals]),
        float(separation.lead),
        tuple(_heard(s) for s in shifts),
        np.array(high),
        np.array([float(x - y) for x, y in zip(turns, high, strict=True)]),
    )


def _inverse(means: list[list[Any]], size: int) -> Any:
    """Return 2πΠ⁻¹."""
    periods = mp.matrix(size, size)
    for k in range(size):
        for j in range(size):
            periods[j, k] = 2 * mp.pi * means[k][j]
    return 2 * mp.pi * mp.inverse(periods) if size else periods


def _turns(
    separation: Separation,
    energy: SeparatedEnergy,
    nodes: list[Any],
    pairs: list[int],
    means: list[list[Any]],
) -> list[Any]:
    """Return ω and Ω over 4π."""
    size = len(nodes)
    rates = _mixed(nodes, energy.slopes(separation.alpha))
    inverse = _inverse(means, size)
    omega = [mp.fsum(inverse[k, j] * rates[j] for j in range(size)) for k in range(size)]
    for row, g in enumerate(pairs, start=size):
        turning = energy.turning(separation.alpha[g], separation.ell[g])
        omega.append(turning - mp.fsum(means[k][row] * omega[k] for k in range(size)))
    return [rate / (4 * mp.pi) for rate in omega]


def _mixed(nodes: list[Any], weights: list[Any]) -> list[Any]:
    """Return Σ_i x_ji ∂H/∂c_i, ℓ_j = Σ_i x_ji λ^i: the rates of what ℓ_j stands for."""
    rates = []
    for j, node in enumerate(nodes):
        coefficients = [mp.mpf(1)]
        for s, other in enumerate(nodes):
            if s != j:
                longer = [mp.mpf(0), *coefficients]
                shifted = [*coefficients, mp.mpf(0)]
                scale = node - other
                coefficients = [
                    (x - other * y) / scale for x, y in zip(longer, shifted, strict=True)
                ]
        rates.append(mp.fsum(c * w for c, w in zip(coefficients, weights, strict=True)))
    return rates


def _means(
    oval: Oval, separation: Separation, nodes: list[Any], pairs: list[int]
) -> tuple[list[Any], Array]:
    """Return the means over θ of all differentials, and samples at θ = 2πi/N, shape (rows, N)."""
    middle, radius = (oval.lower + oval.upper) / 2, (oval.upper - oval.lower) / 2
    count, previous = 16, None

    def row(i: int) -> list[Any]:
        lam = middle - radius * mp.cos(2 * mp.pi * i / count)
        value = separation.lead
        for b in oval.others:
            value *= lam - b
        value = -1 / (4 * mp.sqrt(value))
        product = 2 * mp.fprod(lam - x for x in separation.alpha)
        turning = [
            product * separation.ell[g] * separation.alpha[g] / (lam - separation.alpha[g]) ** 2
            for g in pairs
        ]
        return [value * x for x in lagrange(nodes, lam) + turning]

    rows: list[list[Any]] = []  # even in θ: half of the circle
    while count <= MOST_POINTS:
        known = dict(zip(range(0, count // 2 + 1, 2), rows, strict=True)) if rows else {}
        rows = [known[i] if i in known else row(i) for i in range(count // 2 + 1)]
        columns = list(zip(*rows, strict=True))
        means = [(2 * mp.fsum(c[1:-1]) + c[0] + c[-1]) / count for c in columns]
        allowed = AGREEMENT * max(abs(z) for z in means)
        if previous is not None and all(
            abs(x - y) < allowed for x, y in zip(means, previous, strict=True)
        ):
            half = np.array([[float(x) for x in row] for row in rows]).T
            return means, np.concatenate([half, half[:, -2:0:-1]], axis=1)
        previous, count = means, 2 * count
    expected = "a motion with branch points farther apart: the periods do not converge, condition "
    ends = [float(oval.lower), float(oval.upper)]
    raise gi.DomainError("state", ends, f"{expected}{separation.condition:.3g}")


def _shift(values: Array, inverse: Any, means: list[list[Any]], k: int) -> Array:
    """Return the coefficients of sin mθ_k in (φ, Φ) − (θ, ψ), shape (d + pairs, terms)."""
    count, size = values.shape[1], inverse.rows
    cosines = np.fft.rfft(values, axis=1).real[:, 1 : count // 2] * (2.0 / count)
    sines = cosines / np.arange(1, count // 2)
    matrix = np.array(inverse.tolist(), dtype=np.float64).reshape(size, size)
    phi = matrix @ sines[:size]
    slopes = np.array([[float(m) for m in mean[size:]] for mean in means]).reshape(size, -1)
    return np.concatenate([phi, sines[size:] - slopes.T @ phi])


def _heard(series: Array) -> Array:
    """Return the series without its last terms that are too small to matter."""
    loud = np.flatnonzero(np.max(np.abs(series), axis=0) > TERMS)
    return series[:, : int(loud[-1]) + 1 if len(loud) else 1]
