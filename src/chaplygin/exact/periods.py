"""Means over one turn of the differentials on the ovals: the trapezoidal rule in double-doubles.

The differentials are even in θ, so that half a turn is enough. How many points it takes follows from
the gap to the nearest singular point, before any is computed. `torus` has the formulas.
"""

import functools
import math
from collections import namedtuple
from dataclasses import dataclass

import numpy as np

import geomint as gi
from geomint import section

from ..manifold import Array
from .branch_points import Separation
from .double_double import added, inverse_root, load, negative, times
from .whole_numbers import DoubleDouble, double_double, whole_over

FEWEST_POINTS, MOST_POINTS = 16, 16384  # of the trapezoidal rule
DECAY = 79.0  # e^−DECAY: to what the periods are computed
TABLE_BITS = 256


@dataclass(frozen=True)
class Periods:
    """Means of the differentials over one turn, and the differentials along it.

    Those of the pairs are over 2ℓ_gα_g, the others times Π_{s≠j} (m_j − m_s).

    Parameters
    ----------
    strips : array, shape (d,)
        η: cosh η = 1 + gap/d for the singular point next to an oval.
    means : array, shape (d, d + pairs, 2)
        Of those of λ_k, double-doubles.
    samples : list of array, shape (d + pairs, N/2 + 1)
        For every λ_k at θ = 2πi/N.
    """

    strips: Array
    means: Array
    samples: list[Array]


# Sizes: ovals d, axes q, pairs; the g of pairs; then double-doubles.
Parts = namedtuple("Parts", "ovals axes pairs pair lead widths branch_gaps axis_gaps oval_gaps")
HEAD = Parts._make([*[1] * 3, *[0] * 5, gi.REST])


@gi.helper
def parts_of(ovals, axes, pairs):
    """Return the layout of the parameters."""
    gaps = 2 * ovals * (2 * ovals - 1), 2 * ovals * axes, 2 * ovals * ovals
    return Parts(1, 1, 1, pairs, 2, 2 * ovals, *gaps)


def periods_of(separation: Separation) -> Periods:
    """Return the periods of a torus.

    Raises
    ------
    geomint.DomainError
        If they take too many points: the motion is next to a separatrix.
    """
    pairs, size = np.flatnonzero(separation.paired), len(separation.ovals)
    strips = _strips(separation)
    counts = [_points(strip, separation) for strip in strips.tolist()]
    tables = [_sine_squares(count) for count in counts]
    sizes = size, len(separation.alpha), len(pairs)
    params = gi.packed(
        parts_of(*sizes),
        **dict(zip(Parts._fields, sizes, strict=False)),
        pair=pairs,
        **{name: getattr(separation, name) for name in Parts._fields[4:]},
    )
    ends = np.cumsum([len(table) for table in tables])
    points = np.concatenate([np.zeros((0, 5)), *tables])
    points[:, 0] = np.searchsorted(ends, np.arange(len(points)), side="right")
    rows = size + len(pairs)
    values = gi.pointwise(differentials, params.data, points, 2 * rows)
    along = np.split(values.reshape(-1, rows, 2), ends[:-1]) if size else []
    means = np.array([_means(part) for part in along]).reshape(size, rows, 2)
    return Periods(strips, means, [part[..., 0].T for part in along])


def _means(values: Array) -> list[DoubleDouble]:
    """Return the means over θ from values over half a turn, from one end to the other."""
    found, turn = [], len(values) - 1
    for row in np.moveaxis(values, 1, 0):
        parts = [*row[1:-1].reshape(-1).tolist(), *(0.5 * row[[0, -1]]).reshape(-1).tolist()]
        high = math.fsum(parts)
        (above, rest), bits = whole_over((high, math.fsum([*parts, -high])))
        found.append(double_double(above + rest, turn << bits))
    return found


def _strips(separation: Separation) -> Array:
    gaps = [separation.branch_gaps[..., 0], separation.axis_gaps[:, separation.paired, 0]]
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
    power = 2 ** math.ceil(math.log2(needed))
    return 3 * power // 4 if needed <= 3 * power // 4 else power


@functools.lru_cache(maxsize=32)
def _sine_squares(count: int) -> Array:
    """Return 0, sin²(θ/2), cos²(θ/2) at θ = 2πi/N, i = 0 … N/2: Chebyshev's recurrence for cos θ."""
    one = 1 << TABLE_BITS
    step, cosine = (3, one >> 1) if count % 3 == 0 else (2, 0)  # cos(π/step)
    while 2 * step < count:
        step, cosine = 2 * step, math.isqrt((one + cosine) * one >> 1)
    cosines = [one, cosine]
    for _ in range(count // 2 - 1):
        cosines.append((cosine * cosines[-1] >> (TABLE_BITS - 1)) - cosines[-2])
    sines = np.array([double_double(one - x, 2 * one) for x in cosines])
    return np.concatenate([np.zeros((len(sines), 1)), sines, sines[::-1]], axis=1)


@gi.helper
def half(x):
    """Return x/2."""
    return 0.5 * x[0], 0.5 * x[1]


@gi.helper
def beyond(gap, below, above):
    """Return λ − b, b not within the oval of λ, from the gap between both; see `Separation`."""
    return added(gap, below if math.copysign(1.0, gap[0]) > 0.0 else negative(above))


@gi.field
def differentials(params, t, x, out, work):
    """(k, sin²(θ_k/2), cos²(θ_k/2)) ↦ −Π_{s≠j} (λ − m_s)/(4√Q), −P/(4(λ − α_g)²√Q)."""
    ovals, axes = int(section(params, HEAD, "ovals")[0]), int(section(params, HEAD, "axes")[0])
    pairs = int(section(params, HEAD, "pairs")[0])
    rows = parts_of(ovals, axes, pairs)
    branch, axis = section(params, rows, "branch_gaps"), section(params, rows, "axis_gaps")
    gaps, widths = section(params, rows, "oval_gaps"), section(params, rows, "widths")
    pair, k = section(params, rows, "pair"), int(x[0])
    width = load(widths, k)
    below, above = times(width, (x[1], x[2])), times(width, (x[3], x[4]))
    q = load(section(params, rows, "lead"), 0)
    for b in range(2 * ovals - 1):
        q = times(q, beyond(load(branch, k * (2 * ovals - 1) + b), below, above))
    density = half(half(inverse_root(q if q[0] > 0.0 else negative(q))))
    for j in range(ovals + pairs):
        value = negative(density)
        for s in range(ovals):
            if s != j < ovals:
                ends = half(load(widths, s))
                if s == k:
                    value = times(value, added(below, negative(ends)))
                else:
                    gap = load(gaps, k * ovals + s)
                    value = times(value, beyond(gap, added(below, ends), added(above, ends)))
        for g in range(axes):
            if j >= ovals:
                apart = beyond(load(axis, k * axes + g), below, above)
                if g == pair[j - ovals]:
                    inverse = inverse_root(times(apart, apart))
                    value = times(value, inverse if apart[0] > 0.0 else negative(inverse))
                else:
                    value = times(value, apart)
        out[2 * j], out[2 * j + 1] = value[0], value[1]
