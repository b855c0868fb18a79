"""Compiled: the period matrix of a torus and its frequencies, in double-doubles.

Means over one turn of the differentials on an oval by the trapezoidal rule, of which half a turn is
enough: they are even in θ. How many points it takes follows from the gap to the nearest singular point,
before any is computed. `torus` has the formulas.
"""

from __future__ import annotations

import functools
import math
from collections import namedtuple
from dataclasses import dataclass
from typing import Any

import numpy as np

import geomint as gi
from geomint import part, section

from ..manifold import Array
from .branch_points import Separation
from .double_double import added, divided, inverse_root, load, negative, store, times
from .separated_energy import SeparatedEnergy
from .whole_numbers import double_double

__all__ = ["Periods", "periods_of"]

FEWEST_POINTS, MOST_POINTS = 16, 16384  # of the trapezoidal rule
DECAY = 79.0  # e^−DECAY: to what the periods are computed
TABLE_BITS = 256
INVERSE_4PI = 0.07957747154594767, -4.9196691687956215e-18


@dataclass(frozen=True)
class Periods:
    """Means, frequencies, and the differentials along the ovals.

    Parameters
    ----------
    strips : array, shape (d,)
        η: cosh η = 1 + gap/d for the singular point next to an oval.
    means : array, shape (d, d + pairs)
        Of the differentials of λ_k over one turn.
    inverse : array, shape (d, d)
        2πΠ⁻¹.
    turns, turns_low : array, shape (d + pairs,)
        ω and Ω over 4π, in two parts.
    samples : list of array, shape (d + pairs, N/2 + 1)
        The differentials of every λ_k at θ = 2πi/N.
    """

    strips: Array
    means: Array
    inverse: Array
    turns: Array
    turns_low: Array
    samples: list[Array]


# Sizes: ovals d, axes q, pairs, points of all tables; then double-doubles, but for α and whole numbers.
Parts = namedtuple(
    "Parts",
    "ovals axes pairs points counts alpha pair energy lead ell "
    "widths branch_gaps axis_gaps oval_gaps tables",
)
HEAD = Parts._make([*[1] * 4, *[0] * 10, gi.REST])
GIVEN = "alpha", "lead", "ell", "widths", "branch_gaps", "axis_gaps", "oval_gaps"


@gi.helper
def parts_of(ovals: int, axes: int, pairs: int, points: int) -> Any:
    """Return the layout of the parameters."""
    gaps = 2 * ovals, 2 * ovals * (2 * ovals - 1), 2 * ovals * axes, 2 * ovals * ovals
    return Parts(*HEAD[:4], ovals, axes, pairs, 2, 2, 2 * axes, *gaps, 2 * points)


def periods_of(separation: Separation, energy: SeparatedEnergy) -> Periods:
    """Return the periods of a torus, for the flow of an energy.

    Raises
    ------
    geomint.DomainError
        If they take too many points: the motion is next to a separatrix.
    """
    pairs, size = np.flatnonzero(separation.paired), len(separation.ovals)
    strips = _strips(separation, pairs)
    counts = [_points(strip, separation) for strip in strips.tolist()]
    tables = [_sine_squares(count) for count in counts]
    sizes = size, len(separation.alpha), len(pairs), sum(len(table) // 2 for table in tables)
    params = gi.packed(
        parts_of(*sizes),
        **dict(zip(Parts._fields, sizes, strict=False)),
        counts=counts,
        pair=pairs,
        energy=(energy.at_zero, energy.at_infinity),
        tables=np.concatenate([np.zeros(0), *tables]),
        **{name: getattr(separation, name) for name in GIVEN},
    )
    rows = size + len(pairs)
    lengths = [rows * size, size * size, rows, rows, *(rows * (n // 2 + 1) for n in counts)]
    work = 2 * (rows * (size + 2) + size * (2 * size + 1) + 2)
    # It would take long in plain Python.
    found = gi.pointwise(periods, params.data, np.zeros(1), sum(lengths), work, check=False)
    means, inverse, turns, low, *samples = np.split(found, np.cumsum(lengths)[:-1])
    return Periods(
        strips,
        means.reshape(size, rows),
        inverse.reshape(size, size),
        np.ldexp(turns, energy.exponent),
        np.ldexp(low, energy.exponent),
        [values.reshape(-1, rows).T for values in samples],
    )


def _strips(separation: Separation, pairs: Array) -> Array:
    gaps = [separation.branch_gaps[..., 0], separation.axis_gaps[:, pairs, 0]]
    nearest = np.min(np.abs(np.concatenate(gaps, axis=1)), axis=1, initial=np.inf)
    return 2.0 * np.arcsinh(np.sqrt(nearest / separation.widths[:, 0]))


def _points(strip: float, separation: Separation) -> int:
    """Return how many points the trapezoidal rule takes: 2^k or 3·2^k."""
    needed = max(FEWEST_POINTS, DECAY / max(strip, 1e-300))
    if needed > MOST_POINTS:
        ratio = 1.0 / math.sinh(0.5 * max(strip, 1e-150)) ** 2
        expected = (
            "a motion that is not next to a separatrix: a branch point is beside an oval that is "
            f"{ratio:.3g} times as wide as their distance, condition {ratio:.3g}"
        )
        raise gi.DomainError("state", separation.polynomial, expected)
    power: int = 2 ** math.ceil(math.log2(needed))
    return 3 * power // 4 if needed <= 3 * power // 4 else power


@functools.lru_cache(maxsize=32)
def _sine_squares(count: int) -> Array:
    """Return sin²(θ/2) at θ = 2πi/N, i = 0 … N/2: Chebyshev's recurrence for cos θ, in whole numbers."""
    one = 1 << TABLE_BITS
    step, cosine = (3, one >> 1) if count % 3 == 0 else (2, 0)  # cos(π/step)
    while 2 * step < count:
        step, cosine = 2 * step, math.isqrt((one + cosine) * one >> 1)
    cosines = [one, cosine]
    for _ in range(count // 2 - 1):
        cosines.append((cosine * cosines[-1] >> (TABLE_BITS - 1)) - cosines[-2])
    result = np.array([double_double(one - x, 2 * one) for x in cosines]).reshape(-1)
    result.setflags(write=False)
    return result


@gi.helper
def half(x: Any) -> Any:
    """Return x/2."""
    return 0.5 * x[0], 0.5 * x[1]


@gi.helper
def beyond(gap: Any, below: Any, above: Any) -> Any:
    """Return λ − b, b not within the oval of λ, from the gap between both; see `Separation`."""
    return added(gap, below if math.copysign(1.0, gap[0]) > 0.0 else negative(above))


@gi.helper
def over_others(params: Any, rows: Any, j: int, value: Any) -> Any:
    """Return value/Π_{s≠j} (m_j − m_s)."""
    ovals = int(section(params, HEAD, "ovals")[0])
    widths, gaps = section(params, rows, "widths"), section(params, rows, "oval_gaps")
    for s in range(ovals):
        if s != j:
            ends = half(added(load(widths, s), load(widths, j)))
            value = divided(value, beyond(load(gaps, j * ovals + s), ends, ends))
    return value


@gi.helper
def rate_of(params: Any, rows: Any, j: int) -> Any:
    """Return Σ_i x_ji ∂H/∂c_i, ℓ_j = Σ_i x_ji λ^i: the rate of what ℓ_j stands for.

    Of the ∂H/∂c_i only the first and the last are not 0, x/(2Π(−α)) and y/2.
    """
    ovals, axes = int(section(params, HEAD, "ovals")[0]), int(section(params, HEAD, "axes")[0])
    alpha, energy = section(params, rows, "alpha"), section(params, rows, "energy")
    widths, gaps = section(params, rows, "widths"), section(params, rows, "branch_gaps")
    value = (0.5 * energy[0], 0.0)
    for g in range(axes):
        value = divided(value, (alpha[g], 0.0))
    for s in range(ovals):
        if s != j:  # the middle, from 0
            lower = load(gaps, s * (2 * ovals - 1))
            value = times(value, added(lower, half(load(widths, s))))
    return over_others(params, rows, j, added(value, (0.5 * energy[1], 0.0)))


@gi.helper
def fill_differentials(params: Any, rows: Any, k: int, at: Any, scales: Any, values: Any) -> None:
    """Write −ℓ_j/(4√Q), then −½ ℓ_gα_g P/((λ − α_g)²√Q), at sin² and cos² of θ_k/2; see `torus`."""
    ovals, axes = int(section(params, HEAD, "ovals")[0]), int(section(params, HEAD, "axes")[0])
    pairs = int(section(params, HEAD, "pairs")[0])
    branch, axis = section(params, rows, "branch_gaps"), section(params, rows, "axis_gaps")
    gaps, widths = section(params, rows, "oval_gaps"), section(params, rows, "widths")
    pair = section(params, rows, "pair")
    width = load(widths, k)
    below, above = times(width, load(at, 0)), times(width, load(at, 1))
    q = load(section(params, rows, "lead"), 0)
    for b in range(2 * ovals - 1):
        q = times(q, beyond(load(branch, k * (2 * ovals - 1) + b), below, above))
    density = half(half(inverse_root(q if q[0] > 0.0 else negative(q))))
    for j in range(ovals + pairs):
        store(values, j, times(density, load(scales, j)))
    for s in range(ovals):  # λ − m_s
        ends = half(load(widths, s))
        if s == k:
            apart = added(below, negative(ends))
        else:
            apart = beyond(load(gaps, k * ovals + s), added(below, ends), added(above, ends))
        for j in range(ovals):
            if j != s:
                store(values, j, times(load(values, j), apart))
    for g in range(axes):
        apart = beyond(load(axis, k * axes + g), below, above)
        for i in range(pairs):
            value = load(values, ovals + i)
            value = divided(value, apart) if pair[i] == g else times(value, apart)
            store(values, ovals + i, value)


@gi.helper
def fill_scales(params: Any, rows: Any, scales: Any) -> None:
    """Write what does not depend on θ in the differentials."""
    ovals, pairs = int(section(params, HEAD, "ovals")[0]), int(section(params, HEAD, "pairs")[0])
    alpha, ell, pair = (
        section(params, rows, "alpha"),
        section(params, rows, "ell"),
        section(params, rows, "pair"),
    )
    for j in range(ovals):
        store(scales, j, over_others(params, rows, j, (-1.0, 0.0)))
    for i in range(pairs):
        g = int(pair[i])
        store(scales, ovals + i, times(load(ell, g), (-2.0 * alpha[g], 0.0)))


@gi.helper
def eliminate(size: int, columns: int, matrix: Any) -> None:
    """Make the first columns of a matrix of double-doubles diagonal, with partial pivoting."""
    for c in range(size):
        best = c
        for r in range(c + 1, size):
            if abs(matrix[2 * (r * columns + c)]) > abs(matrix[2 * (best * columns + c)]):
                best = r
        for j in range(2 * columns):
            held = matrix[2 * c * columns + j]
            matrix[2 * c * columns + j] = matrix[2 * best * columns + j]
            matrix[2 * best * columns + j] = held
        for r in range(size):
            if r != c:
                factor = divided(load(matrix, r * columns + c), load(matrix, c * columns + c))
                factor = negative(factor)
                for j in range(c, columns):
                    moved = times(factor, load(matrix, c * columns + j))
                    store(matrix, r * columns + j, added(load(matrix, r * columns + j), moved))


@gi.field
def periods(params: Any, t: Any, x: Any, out: Any, work: Any) -> None:
    """Write what `periods_of` returns; nothing depends on x."""
    ovals, pairs = int(section(params, HEAD, "ovals")[0]), int(section(params, HEAD, "pairs")[0])
    axes, points = int(section(params, HEAD, "axes")[0]), int(section(params, HEAD, "points")[0])
    rows = parts_of(ovals, axes, pairs, points)
    counts, tables = section(params, rows, "counts"), section(params, rows, "tables")
    both = ovals + pairs
    columns = 2 * ovals + 1
    means, scales = part(work, 0, 2 * both * ovals), part(work, 2 * both * ovals, 2 * both)
    values = part(work, 2 * both * (ovals + 1), 2 * both)
    at = part(work, 2 * both * (ovals + 2), 4)
    matrix = part(work, 2 * both * (ovals + 2) + 4, 2 * ovals * columns)
    fill_scales(params, rows, scales)
    written, first = both * ovals + ovals * ovals + 2 * both, 0
    for k in range(ovals):
        turn = int(counts[k]) // 2
        for j in range(both):
            store(means, k * both + j, (0.0, 0.0))
        for i in range(turn + 1):
            store(at, 0, load(tables, first + i))
            store(at, 1, load(tables, first + turn - i))
            fill_differentials(params, rows, k, at, scales, values)
            share = 0.5 if i == 0 or i == turn else 1.0
            for j in range(both):
                value = load(values, j)
                out[written] = value[0]
                written += 1
                value = share * value[0], share * value[1]
                store(means, k * both + j, added(load(means, k * both + j), value))
        first += turn + 1
        for j in range(both):
            mean = divided(load(means, k * both + j), (1.0 * turn, 0.0))
            store(means, k * both + j, mean)
            out[k * both + j] = mean[0]
    for j in range(ovals):
        for k in range(ovals):
            store(matrix, j * columns + k, load(means, k * both + j))
            store(matrix, j * columns + ovals + 1 + k, (1.0 if j == k else 0.0, 0.0))
        store(matrix, j * columns + ovals, rate_of(params, rows, j))
    eliminate(ovals, columns, matrix)
    at_turns = both * ovals + ovals * ovals
    alpha, energy = section(params, rows, "alpha"), section(params, rows, "energy")
    for j in range(both):
        if j < ovals:
            rate = divided(load(matrix, j * columns + ovals), load(matrix, j * columns + j))
            store(values, j, rate)
            for k in range(ovals):
                entry = divided(load(matrix, j * columns + ovals + 1 + k), load(matrix, j * columns + j))
                out[both * ovals + j * ovals + k] = entry[0]
        else:
            g = int(section(params, rows, "pair")[j - ovals])
            rate = added(
                divided((energy[0], 0.0), (alpha[g], 0.0)), times((energy[1], 0.0), (alpha[g], 0.0))
            )
            rate = times(load(section(params, rows, "ell"), g), rate)
            for k in range(ovals):
                moved = times(load(means, k * both + j), load(values, k))
                rate = added(rate, negative(moved))
        rate = times(rate, INVERSE_4PI)
        out[at_turns + j], out[at_turns + both + j] = rate[0], rate[1]
