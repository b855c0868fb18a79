"""Gauss collocation tableaux, whose float64 coefficients stay symplectic and symmetric."""

from dataclasses import dataclass
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import cached_property
from typing import Literal

import numpy as np

from ..references.literature import BUTCHER_1964
from ._collocation import DIGITS, HALF, extrapolation, halves, halves_about_half
from ._exact import Array, read_only
from ._tableau import Tableau

_TABLEAU_TOLERANCE = Fraction(1, 10**45)


@dataclass(frozen=True)
class GaussTableau:
    """The Gauss method with s stages and order 2s; make it by `gauss_legendre`.

    Parameters
    ----------
    stages : int
        Number of stages s.
    nodes : tuple of Decimal, shape (s,)
        Nodes c to 50 digits, with ``c_i + c_{s+1-i} = 1`` exactly.
    weights : tuple of Decimal, shape (s,)
        Weights b, with ``b_i = b_{s+1-i}`` exactly.
    skew : tuple of tuple of Decimal, shape (s, s)
        The matrix E, with ``E_ij = -E_ji = -E_{s+1-i,s+1-j}`` exactly.
    """

    stages: int
    nodes: tuple[Decimal, ...]
    weights: tuple[Decimal, ...]
    skew: tuple[tuple[Decimal, ...], ...]

    @property
    def order(self) -> int:
        """Classical order 2s."""
        return 2 * self.stages

    @property
    def name(self) -> str:
        """Name that states the order."""
        return f"gauss-{self.order}"

    @cached_property
    def tableau(self) -> Tableau:
        """The method as a rational tableau, symmetric and symplectic without any remainder."""
        b = tuple(Fraction(x) for x in self.weights)
        A = tuple(
            tuple(b_j * (Fraction(1, 2) + Fraction(x)) for b_j, x in zip(b, e, strict=True))
            for e in self.skew
        )
        c = tuple(Fraction(x) for x in self.nodes)
        return Tableau(
            self.name, self.order, A, b, c, (BUTCHER_1964,), tolerance=_TABLEAU_TOLERANCE
        )

    @property
    def b(self) -> Array:
        """Float64 numbers nearest to the weights; ``b_i == b_{s+1-i}`` bitwise, shape (s,)."""
        return self._splits["b"][0]

    @property
    def c(self) -> Array:
        """Nodes in float64, ``c_i + c_{s+1-i} == 1`` exactly, shape (s,).

        Nodes above 1/2 are rounded to nearest. The others are one minus these, and carry the same
        absolute error, at most 2^-54.
        """
        return self._splits["c"][0]

    @property
    def mu(self) -> Array:
        r"""Ratios :math:`a_{ij} / b_j` in float64, shape (s, s).

        ``mu[i, j] + mu[j, i] == 1`` and ``mu[i, i] == 0.5`` exactly, and
        ``mu[s-1-i, s-1-j] == mu[j, i]``. Of each pair the larger one, m, is rounded to nearest and
        the other is ``1 - m``. As 1/2 <= m <= 2 this subtraction is exact (Sterbenz), and so is the
        sum of the two, which equals 1. The absolute error of both is at most 2^-53.
        """
        return self._splits["mu"][0]

    def split(self, name: Literal["b", "c", "mu"]) -> tuple[Array, Array]:
        """Return a coefficient as an unevaluated sum of two float64 numbers.

        Parameters
        ----------
        name : {"b", "c", "mu"}
            Which coefficient.

        Returns
        -------
        hi, lo : ndarray, shape (s,) or (s, s)
            `hi` is the attribute of that name and ``hi + lo`` the coefficient with an error below
            2^-105. The low parts of ``mu[i, j]`` and ``mu[j, i]``, as those of ``c_i`` and
            ``c_{s+1-i}``, are opposite numbers, so that the sums of the pairs remain exactly 1.
        """
        return self._splits[name]

    def predictor(self, ratio: float) -> Array:
        r"""Return the matrix that extrapolates the increments of one step to the next.

        The polynomial of degree s - 1 through the derivatives :math:`f_j = L_j / (h b_j)` of the
        previous step, of length h, is evaluated at the nodes of the next, of length
        :math:`\rho h`. With the Lagrange polynomials :math:`\ell_j` of the nodes

        .. math:: L_i^+ = \sum_j P_{ij} L_j, \qquad
                  P_{ij} = \rho \, (b_i / b_j) \, \ell_j(1 + \rho c_i).

        Parameters
        ----------
        ratio : float
            Length of the next step over that of the previous one, :math:`\rho`.

        Returns
        -------
        ndarray, shape (s, s)
            P, each entry rounded once.
        """
        return extrapolation(self.nodes, self.weights, ratio)

    @cached_property
    def between(self) -> Array:
        r"""Matrices of the increments of a shorter step from the same state, shape (s, s, s).

        With those of a step of length h, :math:`L_j`, the collocation polynomial at the nodes of a
        step of length :math:`\theta h` gives

        .. math:: L_i(\theta) = \theta \sum_k \theta^k \sum_j M^{(k)}_{ij} L_j, \qquad
                  \sum_k \theta^k M^{(k)}_{ij} = (b_i / b_j) \, \ell_j(\theta c_i).
        """
        c, b = self.nodes, self.weights
        with localcontext(DIGITS):
            basis = []
            for j, c_j in enumerate(c):  # the coefficients of ℓ_j, from the lowest power on
                polynomial = [Decimal(1)]
                for c_k in (*c[:j], *c[j + 1 :]):
                    shifted, scaled = [Decimal(0), *polynomial], [*polynomial, Decimal(0)]
                    pairs = zip(shifted, scaled, strict=True)
                    polynomial = [(x - c_k * y) / (c_j - c_k) for x, y in pairs]
                basis.append(polynomial)
            matrices = [
                [
                    [float(b_i / b_j * p[k] * c_i**k) for b_j, p in zip(b, basis, strict=True)]
                    for b_i, c_i in zip(b, c, strict=True)
                ]
                for k in range(self.stages)
            ]
        return read_only(matrices)

    def inside(self, ends: Array) -> tuple[Array, Array, Array]:
        r"""Matrices of what a step has added at :math:`\theta h`, shapes (len(ends), s).

        By the collocation polynomial, :math:`\sum_j U_{kj} L_j`; and, with the increments
        :math:`L_j^-` of the step before, of the same length, by the integral of the interpolation
        through the derivatives of both, :math:`\sum_j (A_{kj} L_j + B_{kj} L_j^-)`; of more than
        eight stages only the last four of those, because rounding grows with their number.

        Returns
        -------
        A, B, U
        """
        own = _integrals(self.c, ends) / self.b
        s = self.stages
        past = s if s <= 8 else 4
        both = _integrals(np.concatenate((self.c[s - past :] - 1.0, self.c)), ends)
        B = np.zeros((len(ends), s))
        B[:, s - past :] = both[:, :past] / self.b[s - past :]
        return both[:, past:] / self.b, B, own

    @cached_property
    def _splits(self) -> dict[str, tuple[Array, Array]]:
        """High and low parts of all coefficients."""
        with localcontext(DIGITS):
            b = [halves(x) for x in self.weights]
            c = [halves_about_half(x - HALF) for x in self.nodes]
            mu = [[halves_about_half(x) for x in e] for e in self.skew]
        pairs = {"b": np.array(b), "c": np.array(c), "mu": np.array(mu)}
        return {name: (read_only(x[..., 0]), read_only(x[..., 1])) for name, x in pairs.items()}


def _integrals(nodes: Array, ends: Array) -> Array:
    """Return the integrals of the Lagrange polynomials of nodes, from 0 to each of `ends`."""
    x, weights = np.polynomial.legendre.leggauss(len(nodes))
    places = 0.5 * np.multiply.outer(ends, x + 1.0)
    columns = []
    for j, node in enumerate(nodes):
        others = np.delete(nodes, j)
        values = np.prod((places[..., None] - others) / (node - others), axis=-1)
        columns.append(0.5 * ends * (values @ weights))
    return np.stack(columns, axis=1)
