"""The invariant torus: periods, linear angles, and the angles θ in which states are simple.

On the oval of λ_k let λ = m − d cos θ. With μ = d sin θ √Q/(2λP) the differentials of the variables
conjugate to r_j are smooth and periodic,

    ∂μ/∂r_j dλ = −¼ λ^j/√Q dθ,   β_j = Σ_k ∫ ∂μ_k/∂r_j dλ_k,   dβ_j/dτ = ∂H/∂r_j,

H a linear combination of the r_j. For powers of λ take Lagrange's polynomials ℓ_j on the middles of the
ovals, which only mixes the β_j: with them the period matrix, the means Π_jk over one turn of θ_k, is
nearly diagonal, and nothing cancels in high dimensions. The angles φ = 2π Π⁻¹β are linear in time
and advance by 2π where θ does, so that

    φ = θ + 2π Π⁻¹ Σ_k s_k(θ_k),   dφ/dτ = ω = 2π Π⁻¹ ∂H/∂r,

with sine series s. Their coefficients decay geometrically: the trapezoidal rule gives the periods to
`DIGITS` digits with a few dozen points, if the branch points are apart. A Newton iteration in all θ at
once inverts the map.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import geomint as gi

from ..manifold import Array
from .branch_points import DIGITS, Oval, Separation, mp

__all__ = ["Torus", "torus_of"]

MOST_POINTS = 4096  # of the trapezoidal rule; more are needed only next to a separatrix
NEWTON = 60  # iterations; where the map is far from linear the first steps are cut
LONGEST = 1.0  # largest change of an angle in a Newton step
TERMS = 1e-18  # Fourier coefficients below this part of the largest are left out


@dataclass(frozen=True)
class Torus:
    """A torus with its angles, vectorised over many points.

    Parameters
    ----------
    middle, radius : array, shape (n−1,)
        m and d of every oval.
    others : array, shape (n−1, 2n−3)
        The branch points of Q.
    lead : float
        r_(n−2).
    inverse : array, shape (n−1, n−1)
        2π Π⁻¹.
    sines : array, shape (n−1, n−1, M)
        Coefficients of sin mθ_k, m = 1 … M, in −¼∫ℓ_j/√Q less its mean.
    turns, turns_low : array, shape (n−1,)
        Frequencies ω/4π in the flow's time τ, in two parts: turns of 4π, by which signs return.
    """

    middle: Array
    radius: Array
    others: Array
    lead: float
    inverse: Array
    sines: Array
    turns: Array
    turns_low: Array

    @property
    def frequencies(self) -> Array:
        """ω = dφ/dτ, shape (n−1,)."""
        return np.asarray(4.0 * np.pi * self.turns)

    def lam(self, theta: Array) -> Array:
        """Return λ_k at θ, shape (..., n−1)."""
        return np.asarray(self.middle - self.radius * np.cos(theta))

    def root_q(self, lam: Array) -> Array:
        """Return √Q_k(λ_k), shape (..., n−1)."""
        factors = np.abs(lam[..., None] - self.others)
        return np.asarray(np.sqrt(self.lead * np.prod(factors, axis=-1)))

    def slopes(self, theta: Array) -> Array:
        """Return the matrix ∂φ/∂θ, shape (..., n−1, n−1)."""
        lam = self.lam(theta)
        values = lagrange(self.middle, lam)
        return np.asarray(self.inverse @ (-0.25 * values / self.root_q(lam)[..., None, :]))

    def angles(self, theta: Array) -> Array:
        """Return φ at θ, shape (..., n−1)."""
        orders = np.arange(1, self.sines.shape[2] + 1)
        waves = np.sin(theta[..., None] * orders)
        shifts = np.einsum("jkm,...km->...j", self.sines, waves)
        return np.asarray(theta + shifts @ self.inverse.T)

    def solve(self, phi: Array) -> Array:
        """Return θ at φ, which winds as φ does, shape (..., n−1).

        Raises
        ------
        geomint.ConvergenceError
            If Newton's iteration does not end: never seen where the torus could be made.
        """
        theta: Array = np.array(phi, dtype=np.float64)
        if not theta.size:
            return theta
        for _ in range(NEWTON):
            defect = self.angles(theta) - phi
            step = np.linalg.solve(self.slopes(theta), defect[..., None])[..., 0]
            largest = np.max(np.abs(step), axis=-1, keepdims=True)
            theta = theta - step * np.minimum(1.0, LONGEST / np.maximum(largest, 1e-300))
            if np.max(largest) <= 1e-15 * max(1.0, float(np.max(np.abs(theta)))):
                return theta
            if np.max(largest) < 1e-10:  # one more step is quadratic
                defect = self.angles(theta) - phi
                return theta - np.linalg.solve(self.slopes(theta), defect[..., None])[..., 0]
        residual = float(np.max(np.abs(self.angles(theta) - phi)))
        raise gi.ConvergenceError(0.0, 0, residual, NEWTON, "angles on the torus")


def lagrange(nodes: Any, x: Any) -> Any:
    """Return ℓ_j(x_k), Lagrange's polynomials on the nodes, shape (..., nodes, x)."""
    rows = []
    for j, node in enumerate(nodes):
        value = 1.0 + 0.0 * x
        for s, other in enumerate(nodes):
            if s != j:
                value = value * ((x - other) / (node - other))
        rows.append(value)
    return np.stack(rows, axis=-2) if isinstance(x, np.ndarray) else rows


def torus_of(separation: Separation, weights: Any) -> Torus:
    """Return the torus of a motion, for the flow of H = Σ weights_j r_j.

    Parameters
    ----------
    separation : Separation
    weights : sequence of mpf or float
        ∂H/∂r_j, j = 0 … n−2.

    Raises
    ------
    geomint.DomainError
        If the periods do not converge: the motion is next to a separatrix.
    """
    ovals, lead = separation.ovals, separation.r[-1]
    size, nodes = len(ovals), [(o.lower + o.upper) / 2 for o in ovals]
    periods, samples = mp.zeros(size, size), []
    for k, oval in enumerate(ovals):
        means, values = _means(oval, lead, nodes, separation.condition)
        samples.append(values)
        for j in range(size):
            periods[j, k] = -means[j] * mp.pi / 2
    inverse = 2 * mp.pi * mp.inverse(periods)
    rates = inverse * mp.matrix(_mixed(nodes, weights))
    turns = [rate / (4 * mp.pi) for rate in rates]
    high = [float(x) for x in turns]
    low = [float(x - y) for x, y in zip(turns, high, strict=True)]
    return Torus(
        np.array([float(x) for x in nodes]),
        np.array([float((o.upper - o.lower) / 2) for o in ovals]),
        np.array([[float(b) for b in o.others] for o in ovals]),
        float(lead),
        np.array(inverse.tolist(), dtype=np.float64),
        _sine_series(samples),
        np.array(high),
        np.array(low),
    )


def _mixed(nodes: list[Any], weights: Any) -> list[Any]:
    """Return Σ_i c_ji ∂H/∂r_i, ℓ_j = Σ_i c_ji λ^i: the rates of what ℓ_j stands for."""
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
        rates.append(sum(c * mp.mpf(w) for c, w in zip(coefficients, weights, strict=True)))
    return rates


def _means(oval: Oval, lead: Any, nodes: list[Any], condition: float) -> tuple[list[Any], Array]:
    """Return the means of ℓ_j/√Q over θ, and samples at θ = 2πi/N, shape (n−1, N)."""
    size = len(nodes)
    middle, radius = (oval.lower + oval.upper) / 2, (oval.upper - oval.lower) / 2
    count, previous = 16, None

    def row(i: int) -> list[Any]:
        lam = middle - radius * mp.cos(2 * mp.pi * i / count)
        q = lead
        for b in oval.others:
            q *= lam - b
        value = 1 / mp.sqrt(q)
        return [value * x for x in lagrange(nodes, lam)]

    rows: list[list[Any]] = []  # even in θ: half of the circle
    while count <= MOST_POINTS:
        known = dict(zip(range(0, count // 2 + 1, 2), rows, strict=True)) if rows else {}
        rows = [known[i] if i in known else row(i) for i in range(count // 2 + 1)]
        ends = [rows[0][j] + rows[-1][j] for j in range(size)]
        sums = [2 * sum(row[j] for row in rows[1:-1]) + ends[j] for j in range(size)]
        means = [total / count for total in sums]
        if previous is not None and all(
            abs(x - y) < mp.mpf(10) ** (8 - DIGITS) * max(abs(z) for z in means)
            for x, y in zip(means, previous, strict=True)
        ):
            half = np.array([[float(x) for x in row] for row in rows]).T
            return means, np.concatenate([half, half[:, -2:0:-1]], axis=1)
        previous, count = means, 2 * count
    expected = "a motion that is not next to a separatrix: the periods do not converge, condition "
    raise gi.DomainError(
        "state", [float(oval.lower), float(oval.upper)], f"{expected}{condition:.3g}"
    )


def _sine_series(samples: list[Array]) -> Array:
    """Return the coefficients of sin mθ_k in the integral of −¼ ℓ_j/√Q less its mean, (j, k, m)."""
    series = []
    for values in samples:
        count = values.shape[1]
        cosines = np.fft.rfft(values, axis=1).real[:, 1 : count // 2] * (2.0 / count)
        series.append(-0.25 * cosines / np.arange(1, count // 2))
    largest = max(float(np.max(np.abs(s))) for s in series)
    lengths = []
    for s in series:
        heard = np.flatnonzero(np.max(np.abs(s), axis=0) > TERMS * largest)
        lengths.append(int(heard[-1]) + 1 if len(heard) else 1)
    terms = max(lengths)
    result = np.zeros((len(samples), len(samples), terms))
    for k, s in enumerate(series):
        kept = min(terms, s.shape[1])
        result[:, k, :kept] = s[:, :kept]
    return result
