"""Frequencies over families of motions: rotation numbers, resonances, actions, critical values.

* The *action variables* J_k = (1/2π) ∮ μ_k dλ_k over one turn of θ_k are functions of the r_j, and
  ω_k = ∂H/∂J_k. On the oval μ dλ = (λ − lower)(upper − λ) √Q/(2λP) dθ; P cancels an end at an a_i.
* *Rotation numbers* are ω_k/ω_1: they do not depend on time, and are the same in t and τ.
* A *resonance* is m·ω = 0 with whole m: the motion fills a torus of one dimension less.
* The *critical values* are where branch points merge. For n = 3 the one root of R is −r_0/r_1, and it
  meets a_i where H = K (1 − a_ja_k/D)/(2D): three lines in the plane of (K, H), the steady turns.
"""

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

import geomint as gi
from geomint.arguments import as_array, positive, whole

from ..inertia import positive_number
from ..manifold import Array
from .flow import ExactFlow
from .torus import distances

MANY = 10**7  # combinations of whole numbers that are tried
POINTS = 512  # of the trapezoidal rule for actions


@dataclass(frozen=True)
class FrequencyMap:
    """Frequencies of a family of motions.

    Parameters
    ----------
    frequencies : array, shape (N, n−1)
        In τ; rows of motions without a torus are NaN, and `refused` says why. A torus of fewer
        angles than others leaves NaN at the end of its row.
    conditions : array, shape (N,)
    refused : dict of int to str
        By the index of the state.
    """

    frequencies: Array
    conditions: Array
    refused: dict[int, str]

    @property
    def rotation_numbers(self) -> Array:
        """ω_k/ω_1, k = 2 … n−1, shape (N, n−2)."""
        return self.frequencies[:, 1:] / self.frequencies[:, :1]


def frequency_map(problem: gi.Problem, states: Iterable[Any]) -> FrequencyMap:
    """Return the frequencies of the motions of a problem through several states.

    Parameters
    ----------
    problem : Problem
        One with an exact flow on tori.
    states : iterable of array_like

    Raises
    ------
    geomint.FormError
        If the problem has no exact flow.
    """
    rows = []
    conditions = []
    refused = {}
    if not isinstance(problem, gi.Problem):
        raise gi.DomainError("problem", problem, "a geomint.Problem")
    try:
        given = list(states)
    except Exception:  # whatever a foreign object raises there
        raise gi.DomainError("states", states, "states of the problem, one after another") from None
    for index, y in enumerate(given):
        try:
            exact = problem.exact(y)
        except gi.DomainError as error:
            refused[index] = str(error)
            rows.append(())
            conditions.append(np.inf)
            continue
        rows.append(exact.frequencies)
        conditions.append(exact.condition)
    filled = np.full((len(rows), max([1, *map(len, rows)])), np.nan)
    for values, row in zip(filled, rows, strict=True):
        values[: len(row)] = row
    return FrequencyMap(filled, np.array(conditions), refused)


def resonances(omega: Any, order: int, tolerance: float = 1e-9) -> list[tuple[int, ...]]:
    """Return all whole m ≠ 0 with |m_k| ≤ order and |m·ω| ≤ tolerance · |m| |ω|, the shortest first.

    One of ±m is given, and only those whose entries have no common divisor.

    Raises
    ------
    geomint.DomainError
        For frequencies that are not finite numbers in a row, and an order that is not a whole one.
    """
    rates, order = as_array("omega", omega), whole("order", order, 1)
    tolerance = positive("tolerance", tolerance)
    if rates.ndim != 1 or not np.isfinite(rates).all() or not rates.any():
        raise gi.DomainError("omega", omega, "finite frequencies in a row, not all of them 0")
    if (2 * order + 1) ** len(rates) > MANY:
        raise gi.DomainError("order", order, f"one with (2 order + 1)^{len(rates)} up to {MANY:g}")
    rates = rates / np.max(np.abs(rates))
    found = []
    for m in itertools.product(range(-order, order + 1), repeat=len(rates)):
        leading = next((x for x in m if x), 0)
        if leading <= 0 or np.gcd.reduce(m) != 1:
            continue
        if abs(m @ rates) <= tolerance * np.linalg.norm(m) * np.linalg.norm(rates):
            found.append(m)
    return sorted(found, key=lambda m: (sum(abs(x) for x in m), m))


def action_variables(exact: ExactFlow) -> Array:
    """Return J_k, then the ℓ of pairs (`symmetry`), of a motion; to about condition · 2⁻⁵²."""
    torus, result = exact.torus, []
    sine = np.sin(np.pi * (np.arange(POINTS) + 0.5) / POINTS)[:, None] ** 2  # sin²(θ/2)
    for k, oval in enumerate(exact.separation.ovals):
        width = 2.0 * torus.radius[k]
        branch = distances(torus.branch_gaps[k], torus.radius[k], sine)
        axis = distances(torus.axis_gaps[k], torus.radius[k], sine)
        # (λ − lower)(upper − λ)/P, the ends at an α cancelled: λ − α is λ − lower, or −(upper − λ).
        value = np.sqrt(torus.lead * np.prod(np.abs(branch), axis=1)) / (2.0 * branch[:, 0])
        for g in range(axis.shape[1]):
            if g not in (oval.low_axis, oval.high_axis):
                value /= axis[:, g]
        if oval.low_axis is None:
            value = value * width * sine[:, 0]
        value = -value if oval.high_axis is not None else value * width * (1.0 - sine[:, 0])
        result.append(float(np.mean(value)))
    turning = exact.separation.ell[exact.separation.paired, 0].tolist()
    return exact.unit_p * np.array([*result, *turning])


@np.errstate(over="ignore", invalid="ignore")
def critical_energies(a: Any, D: Any, K: Any = 1.0) -> Array:
    """Return the H at which the tori with that K degenerate, n = 3, in the order of the axes.

    The least and the largest bound the energies that there are; at the one between them lie the
    separatrices. H = K (1 − a_ja_k/D)/(2D) = K/(2(I_i + D)).

    Raises
    ------
    geomint.DomainError
        For other than three a_i.
    """
    values = gi.as_vector("a", a, 3)
    scale, level = positive_number("D", D), positive_number("K", K)
    products = np.array([values[1] * values[2], values[0] * values[2], values[0] * values[1]])
    result = level * (1.0 - products / scale) / (2.0 * scale)
    if not np.isfinite(result).all():
        raise gi.DomainError("a, D, K", (a, D, K), "numbers whose products are finite")
    return result


@np.errstate(over="ignore", invalid="ignore")
def discriminant(a: Any, D: Any, K: Any, H: Any) -> Array:
    """Return the discriminant of the branch points at n = 3, as a function of K and H.

    The branch points are the a_i and the root −r_0/r_1 of R, with r_0 = −K Πa/D² and r_1 = K/D − 2H.
    The product of their squared distances, times (Dr_1)⁶, is D⁶ Π (r_0 + a_i r_1)²: homogeneous of
    degree 6 in (K, H), and 0 at the critical values, `critical_energies`.

    Parameters
    ----------
    a : array_like, shape (3,)
    D : float
    K, H : array_like
        Of shapes that broadcast.
    """
    values = gi.as_vector("a", a, 3)
    scale = positive_number("D", D)
    level, energy = as_array("K", K), as_array("H", H)
    if np.shape(level) != np.shape(energy) and level.ndim and energy.ndim:
        try:
            level, energy = np.broadcast_arrays(level, energy)
        except ValueError:
            raise gi.DomainError("H", H, f"of a shape that fits that of K, {level.shape}") from None
    r0 = -level * np.prod(values) / (scale * scale)
    # H = −D r_0/(2Πa) − r_1/2
    r1 = -2.0 * energy - scale * r0 / np.prod(values)
    factors = [(r0 + x * r1) * scale for x in values]
    result = np.asarray(np.prod(np.array(factors), axis=0) ** 2)
    if not np.isfinite(result).all():
        raise gi.DomainError("K, H", (K, H), "finite numbers, with sixth powers that are so too")
    return result
