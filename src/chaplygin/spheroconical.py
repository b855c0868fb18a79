"""Spheroconical coordinates on T*S^(n−1), both ways, and the polynomial that separates them.

For different a_i the coordinates λ_1 < … < λ_(n−1) of γ, one between each two neighbouring a_i, are the
roots of Σ γ_i²/(a_i − λ) = 0, eq. (S_n), and with their canonical momenta μ_k

    γ_i² = Π_k (a_i − λ_k)/Π_{j≠i} (a_i − a_j),
    μ_k = ½ Σ_i p̃_iγ_i/(λ_k − a_i),
    p̃_i = Σ_k μ_k (γ_i/(2(λ_k − a_i)))/g_k,   g_k = ¼ Σ_i γ_i²/(λ_k − a_i)².

The signs of the γ_i are no functions of λ. On γ_i = 0 a λ is a_i, and has a turning point: there μ is
infinite. The flows of the Hamiltonised sphere, Veselova's and all that commute with them are separated:

    −4 λ_k P(λ_k) μ_k² = R(λ_k),   P(λ) = Π(λ − a_i),   R(λ) = r_0 + r_1λ + … + r_(n−2)λ^(n−2),

which is Stäckel's form; R is the polynomial of `integrable`.

Where a λ is near an a_i its distance is what matters. It is computed and kept as such, relative to ε.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

import geomint as gi

from .commuting_integrals import coefficient_tables
from .inertia import positive_vector
from .manifold import Array

ITERATIONS = 200  # of Newton's method; it takes 5 to 10
ROUNDING = 2.0**-51  # of a step over the root: the last


@dataclass(frozen=True)
class SpheroconicalPoint:
    """A point of T*S^(n−1) in spheroconical coordinates.

    Parameters
    ----------
    lam : array, shape (n−1,)
        λ_1 < … < λ_(n−1).
    mu : array, shape (n−1,)
    signs : array, shape (n,)
        Of the γ_i, in the order of a.
    gaps : array, shape (n−1, n)
        λ_k − a_i, to a relative rounding error.
    """

    lam: Array
    mu: Array
    signs: Array
    gaps: Array


class Spheroconical:
    """The spheroconical coordinates of given parameters.

    Parameters
    ----------
    a : array_like, shape (n,)
        a_i > 0, all different, in any order.

    Raises
    ------
    geomint.DomainError
        If two a_i are equal: naming them.

    Examples
    --------
    >>> import chaplygin as ch
    >>> chart = ch.Spheroconical([0.8, 1.1, 1.5])
    >>> point = chart.point([0.6, 0.48, 0.64], [0.4, 0.1, -0.45])
    >>> gamma, p_tilde = chart.state(point)
    >>> gamma
    array([0.6 , 0.48, 0.64])
    """

    def __init__(self, a: Any) -> None:
        self.a = positive_vector("a", a)
        self._order = np.argsort(self.a, kind="stable")
        ascending = self.a[self._order]
        same = np.flatnonzero(np.diff(ascending) == 0.0)
        if len(same):
            i, j = sorted(int(x) for x in self._order[same[0] : same[0] + 2])
            expected = (
                f"different numbers; a[{i}] = a[{j}] = {float(self.a[i])!r}: rotations of equal axes "
                "have linear integrals instead, see chaplygin.integrable"
            )
            raise gi.DomainError("a", self.a, expected)

    @property
    def n(self) -> int:
        """The dimension."""
        return len(self.a)

    def coordinates(self, gamma: Any) -> tuple[Array, Array]:
        """Return λ, shape (n−1,), and the gaps λ_k − a_i, shape (n−1, n), of a unit vector."""
        squares = gi.Sphere(self.n).point(gamma) ** 2
        ascending = ascending_gaps(self.a[self._order], squares[self._order])
        gaps = np.empty_like(ascending)
        gaps[:, self._order] = ascending
        nearest = np.argmin(np.abs(gaps), axis=1)
        return self.a[nearest] + gaps[np.arange(self.n - 1), nearest], gaps

    def point(self, gamma: Any, p_tilde: Any) -> SpheroconicalPoint:
        """Return the coordinates and momenta of a point of T*S^(n−1).

        Raises
        ------
        geomint.DomainError
            If a γ_i is 0: λ = a_i is a turning point, where μ is infinite.
        """
        direction = gi.Sphere(self.n).point(gamma)
        momentum = gi.TangentSphere(self.n).vector(direction, p_tilde, "p_tilde")
        lam, gaps = self.coordinates(direction)
        self._refuse_turning_points(gaps, direction)
        mu = 0.5 * np.sum(momentum * direction / gaps, axis=1)
        return SpheroconicalPoint(lam, mu, np.sign(direction), gaps)

    def state(self, point: SpheroconicalPoint) -> tuple[Array, Array]:
        """Return (γ, p̃) of a point."""
        gamma = self.gamma(point.gaps, point.signs)
        slopes = gamma / (2.0 * point.gaps)
        weights = point.mu / np.sum(slopes * slopes, axis=1)
        return gamma, weights @ slopes

    def gamma(self, gaps: Any, signs: Any) -> Array:
        """Return γ from the gaps λ_k − a_i and the signs of the γ_i."""
        n = self.n
        given = gi.as_vector("gaps", gaps, (n - 1) * n).reshape(n - 1, n)
        distances, sides = np.sort(np.abs(given), axis=0), gi.as_vector("signs", signs, n)
        squares = np.zeros(self.n)
        with np.errstate(over="ignore"):
            for i in range(self.n):
                others = np.sort(np.abs(np.delete(self.a, i) - self.a[i]))
                squares[i] = np.prod(distances[:, i] / others)  # quotients: no overflow on the way
        if not np.isfinite(squares).all():
            raise gi.DomainError("gaps", gaps, "gaps of a point of the sphere")
        return np.sign(sides) * np.sqrt(squares)

    def polynomial(self, gamma: Any, p_tilde: Any) -> Array:
        """Return r_0, …, r_(n−2), the coefficients of R, at a point; also on γ_i = 0."""
        direction = gi.Sphere(self.n).point(gamma)
        momentum = gi.TangentSphere(self.n).vector(direction, p_tilde, "p_tilde")
        tables = coefficient_tables(self.a, range(self.n - 1), 1).reshape(self.n - 1, -1)
        i, j = np.triu_indices(self.n, 1)
        minors = (direction[i] * momentum[j] - direction[j] * momentum[i]) ** 2
        singles = -(momentum @ momentum) * direction**2
        return tables @ np.concatenate([singles, minors])

    def separated(self, point: SpheroconicalPoint) -> Array:
        """Return −4λ_k P(λ_k) μ_k², which is R(λ_k) along every one of the flows, shape (n−1,)."""
        return -4.0 * point.lam * np.prod(point.gaps, axis=1) * point.mu**2

    def _refuse_turning_points(self, gaps: Array, gamma: Array) -> None:
        if np.all(gaps != 0.0) and np.all(gamma != 0.0):
            return
        i = int(np.argmin(np.min(np.abs(gaps), axis=0)))
        expected = (
            f"components that are not zero; gamma[{i}] = {float(gamma[i])!r} makes mu infinite"
        )
        raise gi.DomainError("gamma", gamma, expected)


def ascending_gaps(a: Array, squares: Array) -> Array:
    """Return λ_k − a_i, shape (n−1, n), of a unit vector with those squares; a_i ascend."""
    poles, weights = a.tolist(), squares.tolist()
    rows = []
    for k in range(len(poles) - 1):
        # The half in which the root is: that of the pole from which it is measured.
        half = 0.5 * (poles[k + 1] - poles[k])
        rising = sum(w / ((x - poles[k]) - half) for x, w in zip(poles, weights, strict=True))
        own, bound = (k, half) if rising >= 0.0 else (k + 1, -half)
        near = [x - poles[own] for x in poles]
        terms = [(x, w) for i, (x, w) in enumerate(zip(near, weights, strict=True)) if i != own]
        offset = _root(weights[own], terms, bound)
        rows.append([offset - x for x in near])
    return np.array(rows).reshape(-1, len(poles))


def _root(weight: float, terms: list[tuple[float, float]], bound: float) -> float:
    """Return the root δ between 0 and `bound` of weight = δ S(δ), S(δ) = Σ w_i/(p_i − δ), rounded.

    That is Σ γ_i²/(a_i − λ) = 0 times −δ, measured from the pole at 0: smooth as far as `bound`.
    Without weight the pole is none, and the root is 0 or one of S. Newton's method within a bracket.
    """
    sign = 1.0 if bound > 0.0 else -1.0

    def excess(delta: float) -> tuple[float, float]:
        """Return what is positive at 0 and falls towards `bound`, and its slope."""
        rest = slope = 0.0
        for pole, w in terms:
            term = w / (pole - delta)
            rest += term
            slope += term / (pole - delta)
        if weight > 0.0:
            return weight - delta * rest, -rest - delta * slope
        return -sign * rest, -sign * slope

    low, high, delta = 0.0, bound, 0.0
    value, slope = excess(low)
    if value <= 0.0:
        return 0.0
    if excess(high)[0] >= 0.0:
        return high
    for _ in range(ITERATIONS):
        after = delta - value / slope if slope else low
        if abs(after - delta) <= ROUNDING * abs(after):
            return after
        if not min(low, high) < after < max(low, high):
            after = 0.5 * (low + high)
        delta = after
        value, slope = excess(delta)
        if value > 0.0:
            low = delta
        else:
            high = delta
    return delta
