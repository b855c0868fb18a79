"""Commuting integrals as coefficients of a polynomial: nothing is divided by a_i − a_j.

With P(z) = Π(z − a_l) and m_ij = x_i p_j − x_j p_i, all coefficients of

    Σ_i s_i P(z)/(z − a_i) + Σ_{i<j} m_ij² z^e P(z)/((z − a_i)(z − a_j))

commute for the geodesics of the ellipsoid (s_i = p_i², e = 0), for Neumann's system on the sphere
(s_i = σ x_i², e = 0) and for geodesic flows on the sphere that spheroconical coordinates separate
(s_i = −(p, p) x_i², e = 1). Where all a_i differ they are
combinations of the residues at z = a_i, which are the integrals F_i of Jacobi and Chasles; but those
have a pole where two a_i are equal. Source: J. Moser, *Geometry of quadrics and spectral theory*
(1980); for the sphere with λ = z and −4λ_k P(λ_k) μ_k² as the value at the coordinate λ_k.
"""

from collections import namedtuple
from collections.abc import Sequence
from typing import Any

import numpy as np

import geomint as gi

from .manifold import Array

Table = namedtuple("Table", "d c")

# n above which there are no tables: those of all coefficients have n³/2 numbers, 256 MB at n = 400, and
# take n⁴/2 products; at n = 100 they are 4 MB, made in a quarter of a second.
LARGEST = 100


@gi.helper
def table_rows(n):
    """Return the layout of what belongs to one coefficient: the weights of s_i and of m_ij²."""
    return Table(d=n, c=n * (n - 1) // 2)


def tabulated(n: int, degrees: range) -> range:
    """Return the degrees whose integrals a problem in dimension n offers: none from n = 101."""
    return degrees if n <= LARGEST else range(0)


def coefficient_tables(a: Array, degrees: Sequence[int], e: int) -> Array:
    """Return for each degree k the weights of s_i and of m_ij² in the coefficient of z^k, flat.

    Parameters
    ----------
    a : array, shape (n,)
    degrees : sequence of int
    e : int
        Exponent of the factor z^e of the second sum.
    """
    if not degrees:
        return np.zeros(0)
    n = len(a)
    first, second = np.triu_indices(n, 1)
    without = np.zeros((n + len(first), n), dtype=bool)
    without[np.arange(n), np.arange(n)] = True
    pairs = np.arange(n, len(without))
    without[pairs, first] = without[pairs, second] = True
    products = _products(a, without)
    singles, pairs_only = products[:n], products[n:]
    zero = np.zeros(len(first))
    parts = [(singles[:, k], pairs_only[:, k - e] if k >= e else zero) for k in degrees]
    return np.concatenate([numbers for pair in parts for numbers in pair])


def _products(roots: Array, without: Any) -> Array:
    """Return the coefficients of Π(z − root), ascending, one more than there are, row by row.

    Row r leaves out the roots l for which ``without[r, l]``. All rows grow together: one by one the
    n(n+1)/2 products of n = 100 would take seconds.
    """
    result = np.zeros((len(without), len(roots) + 1))
    result[:, 0] = 1.0
    for root, left_out in zip(roots, without.T, strict=True):
        longer = -root * result
        longer[:, 1:] += result[:, :-1]
        result = np.where(left_out[:, None], result, longer)
    return result


@gi.helper
def table(n, tables, k):
    """Return the blocks of d_i and c_ij of the k-th of several tables, counted from 0."""
    rows = table_rows(n)
    size = rows.d + rows.c
    own = gi.part(tables, k * size, size)
    return gi.section(own, rows, "d"), gi.section(own, rows, "c")


@gi.helper
def weighted_minors(n, c, y):
    """Return Σ_{i<j} c_ij m_ij² of a state (x, p)."""
    total, at = 0.0 * y[0], 0
    for i in range(n):
        for j in range(i + 1, n):
            m = y[i] * y[n + j] - y[j] * y[n + i]
            total += c[at] * (m * m)
            at += 1
    return total
