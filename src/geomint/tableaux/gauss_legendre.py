r"""Gauss collocation methods, with coefficients that stay symplectic and symmetric in float64.

The stages are written with the increments :math:`L_j = h b_j f(Y_j)`,

.. math:: Y_i = y_0 + \sum_j \mu_{ij} L_j, \qquad \mu_{ij} = a_{ij} / b_j,

since the method is symplectic if and only if :math:`\mu_{ij} + \mu_{ji} = 1`: a condition without
products, which rounded coefficients can meet exactly (M. Antoñana, J. Makazaga, A. Murua, Numer.
Algorithms 76 (2017) 861). With Legendre polynomials at :math:`x_i = 2 c_i - 1` (E. Hairer,
G. Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., Section IV.5)

.. math::

    \mu_{ij} = \tfrac12 + E_{ij}, \qquad
    E_{ij} = \tfrac12 x_i + \tfrac12 \sum_{k=1}^{s-1} P_k(x_j) [P_{k+1}(x_i) - P_{k-1}(x_i)],

and E is skew. It is computed in 60 digits, as is everything derived from it.
"""

from collections.abc import Sequence
from decimal import ROUND_HALF_EVEN, Context, Decimal, localcontext
from functools import cache
from math import cos, pi

from ..errors import DomainError
from ._collocation import DIGITS, HALF, legendre
from ._gauss_tableau import GaussTableau

MAX_GAUSS_STAGES = 16
"""Largest number of stages."""

_NODE_DIGITS = Context(prec=50, rounding=ROUND_HALF_EVEN)


@cache
def gauss_legendre(stages: int) -> GaussTableau:
    """Return the Gauss method with the given number of stages.

    Parameters
    ----------
    stages : int
        From 1 to `MAX_GAUSS_STAGES`.

    Returns
    -------
    GaussTableau
        Always the same object for the same number.
    """
    if stages not in range(1, MAX_GAUSS_STAGES + 1):
        raise DomainError("stages", stages, f"1 to {MAX_GAUSS_STAGES} stages of Gauss methods")
    with localcontext(DIGITS):
        below = [_node(i, stages) for i in range(stages // 2)]
        middle = [HALF] if stages % 2 else []
        c = (*below, *middle, *(1 - x for x in reversed(below)))
        x = [2 * c_i - 1 for c_i in c]
        P = [legendre(x_i, stages) for x_i in x]
        b = tuple((1 - x_i * x_i) / (stages * P_i[-2]) ** 2 for x_i, P_i in zip(x, P, strict=True))
        G = [[_half_integral(x_i, P_i, P_j) for P_j in P] for x_i, P_i in zip(x, P, strict=True)]
        # Half the difference of G and its transpose is G up to the last digits, and exactly skew.
        E = tuple(tuple((G[i][j] - G[j][i]) / 2 for j in range(stages)) for i in range(stages))
    return GaussTableau(stages, c, b, E)


def _node(i: int, stages: int) -> Decimal:
    """Return the i-th node (1 + x)/2, P_s(x) = 0, to 50 digits."""
    x = Decimal(-cos(pi * (i + 0.75) / (stages + 0.5)))  # three digits or more, by asymptotics
    for _ in range(5):  # of Newton's method: every one doubles the digits
        P = legendre(x, stages)
        x -= P[-1] * (1 - x * x) / (stages * (P[-2] - x * P[-1]))
    return _NODE_DIGITS.plus((1 + x) / 2)


def _half_integral(x: Decimal, P: Sequence[Decimal], Q: Sequence[Decimal]) -> Decimal:
    """Return E_ij from ``x = x_i``, ``P = P_k(x_i)`` and ``Q = P_k(x_j)``."""
    return (x + sum(Q[k] * (P[k + 1] - P[k - 1]) for k in range(1, len(P) - 1))) / 2
