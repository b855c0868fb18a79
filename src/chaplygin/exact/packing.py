"""The numbers of a torus and its clock in one flat array, as compiled functions take them.

It begins with the sizes of which its layout is made: so functions are compiled once, not for each n.
"""

from collections import namedtuple
from typing import Any

import numpy as np

import geomint as gi
from geomint import section

from ..manifold import Array
from .branch_points import Separation
from .symmetry import ReducedAxes
from .torus import Torus

# Sizes: ovals d, angles d + pairs, axes q, rows n of γ, numbers of the series; three numbers; sections.
Parts = namedtuple(
    "Parts",
    "ovals angles axes rows numbers lead scale physical "
    "radius branch_gaps axis_gaps oval_gaps terms "
    "series turns turns_low start signs spread low high pair ell first second clock",
)
HEAD = Parts._make([*[1] * 8, *[0] * 17, gi.REST])  # as far as the sections
MOST_CHECKED = 4096  # numbers


@gi.helper
def torus_sizes(params):
    """Return the numbers of ovals, angles, axes, and rows of γ."""
    ovals, angles = section(params, HEAD, "ovals")[0], section(params, HEAD, "angles")[0]
    axes, rows = section(params, HEAD, "axes")[0], section(params, HEAD, "rows")[0]
    return int(ovals), int(angles), int(axes), int(rows)


@gi.helper
def torus_rows(params):
    """Return the layout of the parameters, from the sizes among them."""
    ovals, angles, axes, rows = torus_sizes(params)
    return parts_of(ovals, angles, axes, rows, int(section(params, HEAD, "numbers")[0]))


@gi.helper
def parts_of(ovals, angles, axes, rows, numbers):
    """Return the layout of the parameters."""
    of_ovals = ovals, ovals * (2 * ovals - 1), ovals * axes, ovals * ovals, ovals
    of_axes = axes, axes, axes, axes, axes, axes, axes * rows, axes * rows
    return Parts(*HEAD[:8], *of_ovals, numbers, angles, angles, angles, *of_axes, gi.REST)


def packed_torus(
    axes: ReducedAxes, separation: Separation, torus: Torus, scale: float, physical: bool
) -> Any:
    """Return the block of the parameters of a torus, at (θ, ψ) = 0; those of its clock may follow.

    Parameters
    ----------
    axes, separation, torus
        Of the motion.
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
    spread = 1.0 / np.abs(np.prod(alpha[:, None] - alpha + np.eye(count), axis=1))
    series = np.concatenate([np.zeros(0), *(s.T.reshape(-1) for s in torus.shifts)])
    sizes = len(torus.middle), len(torus.turns), count, axes.first.shape[1], len(series)
    names = ("radius", "branch_gaps", "axis_gaps", "oval_gaps", "turns", "turns_low", "lead")
    return gi.packed(
        parts_of(*sizes),
        **dict(zip(Parts._fields, sizes, strict=False)),
        **{name: getattr(torus, name) for name in names},
        scale=scale,
        physical=physical,
        terms=[s.shape[1] for s in torus.shifts],
        series=series,
        start=np.zeros(sizes[1]),
        signs=np.ones(count),
        spread=spread,
        low=low,
        high=high,
        pair=pair,
        ell=separation.ell[:, 0],
        first=axes.first,
        second=axes.second,
        clock=(),
    )


def start_at(packed: Any, **where: Array) -> None:
    """Write where the motion begins into the block of the parameters.

    Parameters
    ----------
    start : array, shape (d + pairs,), optional
        The linear angles at τ = 0.
    signs : array, shape (q,), optional
        Of the components, but for the sines and cosines of half angles.
    """
    rows = torus_rows(packed)
    for name, numbers in where.items():
        section(packed, rows, name).data[:] = numbers


def padded(values: Array) -> Array:
    """Return the numbers with zeros after them, 2^k in all: `evaluated` checks each length once."""
    if len(values) > MOST_CHECKED:
        return values
    size = 2 ** int(np.ceil(np.log2(max(len(values), 1))))
    return np.concatenate([values, np.zeros(size - len(values))])


def evaluated(function: Any, params: Array, points: Any, rows: int, work: int) -> Array:
    """Return the values of a function of a torus; see `geomint.pointwise`.

    Whether it fits is checked in plain Python, but for long series: that would take seconds.
    """
    check = len(params) <= MOST_CHECKED
    return gi.pointwise(function, padded(params), points, rows, work, check=check)
