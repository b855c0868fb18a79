"""The numbers of a torus and its clock in one flat array, as compiled functions take them.

It begins with a header: sizes, then where each section starts.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi

from ..manifold import Array
from .branch_points import Separation
from .symmetry import ReducedAxes
from .torus import Torus

__all__ = ["evaluated", "packed_torus", "padded", "with_clock"]

# Sizes: ovals d, angles d + pairs, axes q, rows n of γ; then three numbers.
OVALS, ANGLES, AXES, ROWS, LEAD, SCALE, PHYSICAL = range(7)
# Where each section begins.
(
    RADIUS,
    BRANCH_GAPS,
    AXIS_GAPS,
    OVAL_GAPS,
    TERMS,
    SERIES,
    TURNS,
    TURNS_LOW,
    START,
    SIGNS,
    SPREAD,
    LOW,
    HIGH,
    PAIR,
    ELL,
    FIRST,
    SECOND,
    CLOCK,
) = range(7, 25)
HEADER = CLOCK + 1
MOST_CHECKED = 4096  # numbers


def packed_torus(
    axes: ReducedAxes,
    separation: Separation,
    torus: Torus,
    signs: Array,
    start: Array,
    scale: float,
    physical: bool,
) -> Array:
    """Return the parameters of the functions of a torus.

    Parameters
    ----------
    axes, separation, torus
        Of the motion.
    signs : array, shape (q,)
        Of the components, but for the sines and cosines of half angles.
    start : array, shape (d + pairs,)
        The linear angles at τ = 0.
    scale : float
        The unit of p̃; where states are (γ, p), times p/(p̃ Π√λ_k).
    physical : bool
        Whether states are (γ, p).
    """
    alpha, count = axes.alpha, len(axes.alpha)
    low, high, pair = np.full(count, -1.0), np.full(count, -1.0), np.full(count, -1.0)
    for k, oval in enumerate(separation.ovals):
        if oval.low_axis is not None:
            low[oval.low_axis] = k
        if oval.high_axis is not None:
            high[oval.high_axis] = k
    pair[axes.paired] = np.arange(np.count_nonzero(axes.paired))
    spread = [1.0 / np.prod(np.abs(np.delete(alpha, g) - alpha[g])) for g in range(count)]
    sections: dict[int, Any] = {
        RADIUS: torus.radius,
        BRANCH_GAPS: torus.branch_gaps,
        AXIS_GAPS: torus.axis_gaps,
        OVAL_GAPS: torus.oval_gaps,
        TERMS: [s.shape[1] for s in torus.shifts],
        SERIES: np.concatenate([np.zeros(0), *(s.T.reshape(-1) for s in torus.shifts)]),
        TURNS: torus.turns,
        TURNS_LOW: torus.turns_low,
        START: start,
        SIGNS: signs,
        SPREAD: spread,
        LOW: low,
        HIGH: high,
        PAIR: pair,
        ELL: [float(x) for x in separation.ell],
        FIRST: axes.first,
        SECOND: axes.second,
        CLOCK: [],
    }
    angles, n = len(torus.turns), axes.first.shape[1]
    header = [len(torus.middle), angles, count, n, torus.lead, scale, physical]
    at, parts = HEADER, []
    for section in range(RADIUS, HEADER):
        parts.append(np.ravel(sections[section]).astype(np.float64))
        header.append(at)
        at += len(parts[-1])
    return padded(np.concatenate([np.array(header, dtype=np.float64), *parts]))


def with_clock(params: Array, values: Array) -> Array:
    """Return the parameters with the last section, that of the clock, filled."""
    return padded(np.concatenate([params[: int(params[CLOCK])], values]))


def padded(values: Array) -> Array:
    """Return the numbers with zeros after them, 2^k in all: `evaluated` checks each length once."""
    if len(values) > MOST_CHECKED:
        return values
    size: int = 2 ** int(np.ceil(np.log2(max(len(values), 1))))
    return np.concatenate([values, np.zeros(size - len(values))])


def evaluated(function: Any, params: Array, points: Any, rows: int, work: int) -> Array:
    """Return the values of a function of a torus; see `geomint.pointwise`.

    Whether it fits is checked in plain Python, but for long series: that would take seconds.
    """
    return gi.pointwise(function, params, points, rows, work, check=len(params) <= MOST_CHECKED)
