"""Integrals that the Chaplygin sphere and the Veselova problem share on T*S^(n−1).

With the same a and D both flows in τ commute, and so have the same integrals.

* ``r1`` … ``r(n−3)``: r_k is the coefficient of λ^k in the polynomial R of degree n − 2 for which the
  spheroconical coordinates have −4λ_k P(λ_k) μ_k² = R(λ_k), P(λ) = Π(λ − a_i):

      R(λ) = Σ_{i<j} (γ_i p̃_j − γ_j p̃_i)² λP(λ)/((λ − a_i)(λ − a_j)) − (p̃, p̃) Σ_i γ_i² P(λ)/(λ − a_i).

  r_0 = (−1)ⁿ K Πa/D² and r_(n−2) = (p̃, Ap̃) = 2𝓗/D² are K and the Veselova energy; the energy of the
  sphere is K/(2D) − r_(n−2)/2. They are n − 1 together, as many as the sphere has dimensions. From
  n = 101 there are only K and the energy: the tables of the others would be larger than is useful.
* ``f-i-j`` where a_i = a_j: the linear integral γ_i p̃_j − γ_j p̃_i, the momentum of a rotation of equal
  axes. Of more than three equal parameters there are only the f of neighbours, whose brackets are
  the others, and ``casimir-i``, the sum of the squares of all f of the group that i begins.

In time t, p̃ = p/(D√U).
"""

import functools
from collections import namedtuple
from typing import Any

import geomint as gi
from geomint import section, sqrt

from .commuting_integrals import coefficient_tables, table, tabulated, weighted_minors
from .manifold import Array, Named

Special = namedtuple("Special", "D b a splitting tables")

ALL_SHOWN = 3  # equal parameters up to which every pair has its integral


def equal_groups(a: Array) -> list[list[int]]:
    """Return the groups of two or more indices whose a_i are equal, bit for bit."""
    groups: dict[float, list[int]] = {}
    for i, value in enumerate(a):
        groups.setdefault(float(value), []).append(i)
    return [group for group in groups.values() if len(group) > 1]


@gi.helper
def special_rows(n, splitting):
    """Return the layout of the parameters: D, 1/a_i, a_i, those of a splitting, tables of integrals."""
    return Special(D=1, b=n, a=n, splitting=splitting, tables=gi.REST)


@gi.helper
def factors(params, n):
    """Return the blocks of D, 1/a_i and a_i, which stand first, whatever follows."""
    rows = special_rows(n, 0)
    return section(params, rows, "D"), section(params, rows, "b"), section(params, rows, "a")


def special_parameters(
    a: Array, D: float, physical: bool, splitting: Any = ()
) -> tuple[Array, Named]:
    """Return the parameters of a problem on T*S^(n−1), and the integrals that it shares by name.

    Parameters
    ----------
    a : array, shape (n,)
    D : float
    physical : bool
        States are (γ, p), in time t; else (γ, p̃).
    splitting : array_like
        The parameters of a splitting.
    """
    n, own = len(a), len(splitting)
    degrees = tabulated(n, range(1, n - 2))
    found = {
        f"r{k}": separation_integral(n, own, index, physical) for index, k in enumerate(degrees)
    }
    for group in equal_groups(a):
        few = len(group) <= ALL_SHOWN
        found |= {
            f"f-{i + 1}-{j + 1}": linear_integral(n, i, j, physical)
            for x, i in enumerate(group)
            for j in (group[x + 1 :] if few else group[x + 1 : x + 2])
        }
        if not few:
            found[f"casimir-{group[0] + 1}"] = casimir(n, tuple(group), physical)
    tables = coefficient_tables(a, degrees, 1)
    rows = special_rows(n, own)
    return gi.packed(rows, D=D, b=1.0 / a, a=a, splitting=splitting, tables=tables).data, found


@gi.helper
def inner(n, x, z):
    """Return (x, z) over the first n rows."""
    total = x[0] * z[0]
    for i in range(1, n):
        total += x[i] * z[i]
    return total


@gi.helper
def weighted(n, b, x, z):
    """Return Σ b_i x_i z_i over the first n rows, such as U = (γ, A⁻¹γ)."""
    total = b[0] * x[0] * z[0]
    for i in range(1, n):
        total += b[i] * x[i] * z[i]
    return total


@gi.helper
def physical_scale(n, params, y):
    """Return D√U = p/p̃."""
    D, b, _ = factors(params, n)
    return D[0] * sqrt(weighted(n, b, y, y))


@functools.cache
def separation_integral(n: int, splitting: int, k: int, physical: bool) -> Any:
    """Return r = Σ c_ij m_ij² − (p̃, p̃) Σ d_i γ_i² with the weights of the k-th table.

    Parameters
    ----------
    n, splitting : int
        See `special_rows`.
    k : int
    physical : bool
        The momentum of the state is p = D√U p̃; else it is p̃.
    """

    def separation_coefficient(params, t, y, work):
        """Return a coefficient of the polynomial with s_i = −(p̃, p̃) γ_i²."""
        D, b, _ = factors(params, n)
        d, c = table(n, section(params, special_rows(n, splitting), "tables"), k)
        total = weighted_minors(n, c, y)
        pp, dgg, u = 0.0 * y[0], 0.0 * y[0], 0.0 * y[0]
        for i in range(n):
            gg = y[i] * y[i]
            pp += y[n + i] * y[n + i]
            dgg += d[i] * gg
            u += b[i] * gg
        total -= pp * dgg
        if physical:
            total /= D[0] * D[0] * u
        return total

    return gi.observable(separation_coefficient)


@functools.cache
def linear_integral(n: int, i: int, j: int, physical: bool) -> Any:
    """Return f_ij = γ_i p̃_j − γ_j p̃_i."""

    def linear(params, t, y, work):
        value = y[i] * y[n + j] - y[j] * y[n + i]
        if physical:
            value /= physical_scale(n, params, y)
        return value

    return gi.observable(linear)


@functools.cache
def casimir(n: int, group: tuple[int, ...], physical: bool) -> Any:
    """Return Σ f_ij² over a group of equal parameters, as (γ, γ)(p̃, p̃) − (γ, p̃)² of their rows."""

    def casimir_of_equals(params, t, y, work):
        gg, gp, pp = 0.0 * y[0], 0.0 * y[0], 0.0 * y[0]
        for i in group:
            gg += y[i] * y[i]
            gp += y[i] * y[n + i]
            pp += y[n + i] * y[n + i]
        value = gg * pp - gp * gp
        if physical:
            scale = physical_scale(n, params, y)
            value /= scale * scale
        return value

    return gi.observable(casimir_of_equals)
