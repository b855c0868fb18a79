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

from __future__ import annotations

import functools
from typing import Any

import geomint as gi
from geomint import sqrt

from .commuting_integrals import coefficient_tables, separation_integral, table_rows, tabulated
from .manifold import Array

__all__ = ["equal_groups", "shared_integrals"]

ALL_SHOWN = 3  # equal parameters up to which every pair has its integral


def equal_groups(a: Array) -> list[list[int]]:
    """Return the groups of two or more indices whose a_i are equal, bit for bit."""
    groups: dict[float, list[int]] = {}
    for i, value in enumerate(a):
        groups.setdefault(float(value), []).append(i)
    return [group for group in groups.values() if len(group) > 1]


def shared_integrals(a: Array, at: int, physical: bool) -> tuple[Array, dict[str, Any]]:
    """Return the parameters that the integrals read from row `at` on, and the integrals by name.

    Parameters
    ----------
    a : array, shape (n,)
    at : int
        The parameters of the problem begin with D, 1/a…; those returned come in the rows from `at`.
    physical : bool
        States are (γ, p), in time t; else (γ, p̃).
    """
    n = len(a)
    degrees, rows = tabulated(n, range(1, n - 2)), table_rows(n)
    found = {
        f"r{k}": separation_integral(n, at + index * rows, physical)
        for index, k in enumerate(degrees)
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
    return coefficient_tables(a, degrees, 1), found


@gi.helper
def physical_scale(n: int, params: Any, y: Any) -> Any:
    """Return D√U = p/p̃."""
    u = params[1] * y[0] * y[0]
    for i in range(1, n):
        u += params[1 + i] * y[i] * y[i]
    return params[0] * sqrt(u)


@functools.cache
def linear_integral(n: int, i: int, j: int, physical: bool) -> Any:
    """Return f_ij = γ_i p̃_j − γ_j p̃_i."""

    def linear(params: Any, t: Any, y: Any, work: Any) -> Any:
        value = y[i] * y[n + j] - y[j] * y[n + i]
        if physical:
            value = value / physical_scale(n, params, y)
        return value

    return gi.observable(linear)


@functools.cache
def casimir(n: int, group: tuple[int, ...], physical: bool) -> Any:
    """Return Σ f_ij² over a group of equal parameters, as (γ, γ)(p̃, p̃) − (γ, p̃)² of their rows."""

    def casimir_of_equals(params: Any, t: Any, y: Any, work: Any) -> Any:
        gg, gp, pp = 0.0 * y[0], 0.0 * y[0], 0.0 * y[0]
        for i in group:
            gg += y[i] * y[i]
            gp += y[i] * y[n + i]
            pp += y[n + i] * y[n + i]
        value = gg * pp - gp * gp
        if physical:
            scale = physical_scale(n, params, y)
            value = value / (scale * scale)
        return value

    return gi.observable(casimir_of_equals)
