r"""The pairs of Lobatto IIIA and IIIB: RATTLE with s stages, of order 2s − 2.

For :math:`\dot q = H_p, \dot p = -H_q - G^T \lambda, g(q) = 0` (L. O. Jay, SIAM J. Numer. Anal. 33
(1996) 368; [HLW], Section VII.1.4), with the increments of stages :math:`K_j = h b_j H_p(Q_j, P_j)`
and :math:`L_j = -h b_j (H_q(Q_j, P_j) + G(Q_j)^T \Lambda_j)`,

.. math:: Q_i = q_0 + \sum_j \mu_{ij} K_j, \qquad P_i = p_0 + \sum_j \nu_{ij} L_j, \qquad
          \mu_{ij} = a_{ij} / b_j, \quad \nu_{ij} = \hat a_{ij} / b_j .

The first is collocation at Lobatto's nodes, and the pair is symplectic as :math:`\nu_{ij} + \mu_{ji}
= 1`. With Legendre polynomials at :math:`x_i = 2 c_i - 1`, whose products Lobatto's quadrature
integrates exactly but for :math:`\sum_j b_j P_{s-1}(x_j)^2 = 1/(s - 1)`,

.. math::

    \mu_{ij} = \tfrac12 + E_{ij}, \qquad E_{ij} = \tfrac12 x_i
    + \tfrac12 \sum_{k=1}^{s-1} \omega_k P_k(x_j) [P_{k+1}(x_i) - P_{k-1}(x_i)], \qquad
    \omega_k = 1 \ (k < s - 1), \quad \omega_{s-1} = \frac{s - 1}{2s - 1} .

References
----------
[HLW] E. Hairer, C. Lubich, G. Wanner, *Geometric Numerical Integration*, 2nd ed., Springer, 2006.
"""

from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import cache, cached_property
from math import cos, pi

import numpy as np

from ..errors import DomainError
from ._collocation import DIGITS, HALF, extrapolation, halves_about_half, legendre
from ._exact import Array, read_only

MAX_LOBATTO_STAGES = 8
"""Largest number of stages."""

Rows = tuple[tuple[Decimal, ...], ...]


@dataclass(frozen=True)
class LobattoPair:
    """The pair of Lobatto IIIA and IIIB with s stages; make it by `lobatto_pair`.

    Parameters
    ----------
    stages : int
        Number of stages s.
    nodes, weights : tuple of Decimal, shape (s,)
        Nodes c, from 0 to 1, and weights b, to 50 digits and more.
    excess : tuple of tuple of Decimal, shape (s, s)
        The matrix E, with ``E_ij = −E_{s+1−i,s+1−j}`` exactly, first row −1/2, last row 1/2.
    """

    stages: int
    nodes: tuple[Decimal, ...]
    weights: tuple[Decimal, ...]
    excess: Rows

    @property
    def order(self) -> int:
        """Classical order 2s − 2."""
        return 2 * self.stages - 2

    @cached_property
    def b(self) -> Array:
        """Float64 numbers nearest to the weights, shape (s,)."""
        return read_only([float(x) for x in self.weights])

    @cached_property
    def c(self) -> Array:
        """Float64 numbers nearest to the nodes, shape (s,)."""
        return read_only([float(x) for x in self.nodes])

    @cached_property
    def mu(self) -> Array:
        """Ratios ``a_ij / b_j`` in float64, shape (s, s), for q."""
        return read_only([[halves_about_half(x)[0] for x in row] for row in self.excess])

    @cached_property
    def nu(self) -> Array:
        """Ratios ``â_ij / b_j`` in float64, shape (s, s), for p; ``nu[i, j] + mu[j, i] == 1``."""
        return read_only(
            [[halves_about_half(-x)[0] for x in row] for row in zip(*self.excess, strict=True)]
        )

    @cached_property
    def impulses(self) -> Array:
        r"""Matrix from what stages of q lack to impulses on p, shape (s, s).

        The inverse of :math:`\sum_j \mu_{ij} b_j \nu_{jk}`, which takes an impulse at stage k < s to a
        displacement at stage i > 1; its last row and its first column are zero.
        """
        s, b, E = self.stages, self.weights, self.excess
        with localcontext(DIGITS):
            rows = [
                [
                    sum(((HALF + E[i][j]) * b[j] * (HALF - E[k][j]) for j in range(s)), Decimal(0))
                    for k in range(s - 1)
                ]
                for i in range(1, s)
            ]
            inverse = _inverse(rows)
        result = np.zeros((s, s))
        result[:-1, 1:] = [[float(x) for x in row] for row in inverse]
        return read_only(result)

    def predictor(self, ratio: float) -> Array:
        """Return the matrix that extrapolates increments, as `GaussTableau.predictor` does."""
        return extrapolation(self.nodes, self.weights, ratio)


@cache
def lobatto_pair(stages: int) -> LobattoPair:
    """Return the pair with the given number of stages.

    Parameters
    ----------
    stages : int
        From 2, which is RATTLE itself, to `MAX_LOBATTO_STAGES`.

    Returns
    -------
    LobattoPair
        Always the same object for the same number.
    """
    if stages not in range(2, MAX_LOBATTO_STAGES + 1):
        raise DomainError("stages", stages, f"2 to {MAX_LOBATTO_STAGES} stages of the pairs")
    s = stages
    with localcontext(DIGITS):
        left = [Decimal(-1), *(_node(i, s) for i in range(1, s // 2))]
        x = [*left, *[Decimal(0)] * (s % 2), *(-z for z in reversed(left))]
        P = [legendre(z, s) for z in x]
        b = tuple(1 / (s * (s - 1) * P_i[s - 1] ** 2) for P_i in P)
        E = [[_excess(z, P_i, P_j, s) for P_j in P] for z, P_i in zip(x, P, strict=True)]
        inner = [
            tuple((E[i][j] - E[s - 1 - i][s - 1 - j]) / 2 for j in range(s))
            for i in range(1, s - 1)
        ]
        excess = ((-HALF,) * s, *inner, (HALF,) * s)
        return LobattoPair(s, tuple((1 + z) / 2 for z in x), b, excess)


def _node(i: int, stages: int) -> Decimal:
    """Return the i-th zero of P'_n, n = s − 1, from the left, the first being −1."""
    n = stages - 1
    x = Decimal(-cos(pi * i / n))
    for _ in range(8):  # of Newton's method, started from a digit or two
        P = legendre(x, n)
        slope = n * (P[n - 1] - x * P[n]) / (1 - x * x)  # P'_n
        x -= slope * (1 - x * x) / (2 * x * slope - n * (n + 1) * P[n])
    return x


def _excess(x: Decimal, P: list[Decimal], Q: list[Decimal], stages: int) -> Decimal:
    """Return E_ij from ``x = x_i``, ``P = P_k(x_i)`` and ``Q = P_k(x_j)``."""
    last = stages - 1
    terms = [Q[k] * (P[k + 1] - P[k - 1]) for k in range(1, stages)]
    return (x + sum(terms[:-1], Decimal(0)) + terms[-1] * last / (2 * last + 1)) / 2


def _inverse(matrix: list[list[Decimal]]) -> list[list[Decimal]]:
    """Return the inverse of a matrix, by elimination with exchanges."""
    n = len(matrix)
    rows = [[*row, *(Decimal(int(i == j)) for j in range(n))] for i, row in enumerate(matrix)]
    for k in range(n):
        best = max(range(k, n), key=lambda i: abs(rows[i][k]))
        rows[k], rows[best] = rows[best], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(n):
            if i != k:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [row[n:] for row in rows]
