r"""The trend of a series: whether there is one, how large it may be, and how it is curved.

The series m_i, i < N, is taken apart into cosines, c_k = √(2/N) Σ m_i cos(πk(i + ½)/N),
k = 1 … K = min(48, N/2): independent with equal variances for a bounded noise, with variances as
1/k² for a random walk. So a noise has the variances a + w/k², and a trend is a regression on few
shapes beside it: of the greatest likelihood over a grid of w/a. Standard errors are the largest
among those w/a that are likelier than e^−1.5 times the likeliest.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..arguments import Array

COSINES = 48
LIKELY = 1.5  # less in the logarithm: with it errors are honest for all mixtures, by experiment
# Ratios w/a of a walk's variances to a floor: none, or a grid by factors of 1.8.
_RATIOS = np.concatenate(([0.0], np.logspace(-1.0, 6.0, 29)))
_TINY = 1e-300


class Trend(NamedTuple):
    """The trend of a series over its length.

    Attributes
    ----------
    rise, error : float
        Of the line by least squares, and its standard error.
    halves, covariance : array, shapes (2,), (2, 2)
        What a parabola rises over the first and the second half, and how well that is known.
    white : float
        Twice the logarithm of the likelihood of white noise alone (differences count).
    by_walk, by_line, by_parabola : float
        The gains in this measure: by w > 0, then by a line or a parabola beside.
    """

    rise: float
    error: float
    halves: Array
    covariance: Array
    white: float
    by_walk: float
    by_line: float
    by_parabola: float


def find_trend(x: Array, series: Array) -> Trend:
    """Return the trend of a series at equally spaced times `x` from 0 to 1."""
    columns, k = cosines(np.stack([series, x, x * x - x], axis=1))
    values, shapes = columns[:, 0], columns[:, 1:]
    none, line, parabola = (_Fits(values, shapes[:, :m], k) for m in (0, 1, 2))
    in_halves = np.array([[0.5, -0.25], [0.5, 0.25]])  # of x and x² − x
    weights = shapes[:, 0] / (shapes[:, 0] @ shapes[:, 0])
    return Trend(
        rise=float(weights @ values),
        error=float(np.sqrt(line.largest_variance(weights))),
        halves=in_halves @ parabola.coefficients[parabola.best],
        covariance=in_halves @ parabola.covariance() @ in_halves.T,
        white=2.0 * none.white,
        by_walk=2.0 * (none.likelihood - none.white),
        by_line=2.0 * (line.likelihood - none.likelihood),
        by_parabola=2.0 * (parabola.likelihood - none.likelihood),
    )


def cosines(columns: Array) -> tuple[Array, Array]:
    """Return the coefficients c_k of each column, and k.

    k is 2N/π sin(πk/2N), with which the variances of a random walk are exactly as 1/k².
    """
    waves, k = _waves(len(columns))
    return waves @ (columns - columns.mean(axis=0)), k


@lru_cache(maxsize=4)  # all quantities of a run have as many windows
def _waves(n: int) -> tuple[Array, Array]:
    numbers = np.arange(1, min(COSINES, n // 2) + 1)
    waves = np.cos(np.pi / n * np.outer(numbers, np.arange(n) + 0.5)) * np.sqrt(2.0 / n)
    return waves, 2.0 * n / np.pi * np.sin(0.5 * np.pi * numbers / n)


class _Fits:
    """Multiples of shapes plus noise of variances a + w/k², for each w/a."""

    def __init__(self, values: Array, shapes: Array, k: Array) -> None:
        count, m = len(values), shapes.shape[1]
        relative = 1.0 + _RATIOS[:, None] / k**2
        weights = 1.0 / relative
        self._gram = np.einsum("rk,ki,kj->rij", weights, shapes, shapes)
        right = np.einsum("rk,ki,k->ri", weights, shapes, values)
        self.coefficients = np.linalg.solve(self._gram, right[:, :, None])[:, :, 0]
        rest = values - self.coefficients @ shapes.T
        floors = np.maximum((rest**2 * weights).sum(axis=1) / count, _TINY)
        likelihoods = -0.5 * (np.log(relative).sum(axis=1) + count * np.log(floors))
        self.best = int(np.argmax(likelihoods))
        self.likelihood = float(likelihoods[self.best])
        self.white = float(likelihoods[0])
        self._likely = np.flatnonzero(likelihoods >= self.likelihood - LIKELY)
        self._floors = floors * (count / (count - m))
        self._variances = self._floors[:, None] * relative

    def largest_variance(self, weights: Array) -> float:
        """Return the largest variance of a weighted sum among the likely noises."""
        return float((self._variances[self._likely] @ weights**2).max())

    def covariance(self) -> Array:
        """Return the covariance of the coefficients, the largest among the likely noises."""
        every = self._floors[:, None, None] * np.linalg.inv(self._gram)
        traces = np.trace(every, axis1=1, axis2=2)
        return every[self._likely[np.argmax(traces[self._likely])]]
