"""Tangents and normals of the manifold {c(y) = 0}, and the density of its measure, state by state.

A frame is one number, ``log μ − ½ log det(C Cᵀ)`` with C = Dc, and the reflections that split normals
and tangents (`geomint.kernels.measure.reflections`). All is in units of the pieces of the state.
"""

from __future__ import annotations

from typing import Any

from ..compiling.recorded import helper
from ..numbers.arithmetic import lane, maximum, total
from ..numbers.blocks import as_lanes, part
from .memory import EPSILON, UNIT, Lanes, Memory, Work, pieces_of
from .reflections import log_det_near_identity, reflect, reflect_back, reflections

__all__ = ["enlarge_scales", "make_frame", "normals_turned"]

CONDITIONS_SMALLEST = 2.0**-12  # spacing of the differences of conditions
CONDITIONS_ROUNDINGS = 256.0  # seventh differences above this are not rounding


@helper
def enlarge_scales(layout: Any, y: Any, scales: Any) -> bool:
    """Double the scale of each piece until no number of y exceeds it; return whether one did."""
    n = len(scales)
    pieces = pieces_of(layout)
    grown = False
    r = 0
    while r < n:
        end = r
        largest = 0.0
        while end < n and pieces[end] == pieces[r]:
            largest = maximum(abs(y[end]), largest)
            end += 1
        while scales[r] < largest and scales[r] < 1e300:
            for i in range(r, end):
                scales[i] = 2.0 * scales[i]
            grown = True
        r = end
    return grown


@helper
def condition_gradients(
    manifold: Any,
    params: Any,
    numbers: Any,
    t: float,
    y: Any,
    scales: Any,
    spacing: float,
    lanes: Lanes,
    own: Work,
) -> float:
    """Write the scaled gradients of the conditions, row after row.

    Returns the largest seventh difference in roundings of the numbers of its row.
    """
    nodes, values, sizes, C = lanes.nodes, lanes.values, own.values, own.gradients
    n = len(scales)
    m = len(values)
    zero = 0.0 * numbers[0]
    for a in range(2 * m):
        sizes[a] = 0.0
    for i in range(n):
        nodes[i] = zero + y[i]
    for i in range(n):
        nodes[i] = y[i] + numbers[0] * (spacing * scales[i])
        manifold(params, zero + t, nodes, values, lanes.scratch)
        nodes[i] = zero + y[i]
        for a in range(m):
            difference = values[a] - lane(values[a], 0)
            C[a * n + i] = total(numbers[1] * difference) / (UNIT * spacing)
            sizes[2 * a] = maximum(abs(C[a * n + i]), sizes[2 * a])
            seventh = abs(total(numbers[2] * difference))
            sizes[2 * a + 1] = maximum(seventh, sizes[2 * a + 1])
    worst = 0.0
    for a in range(m):
        worst = maximum(sizes[2 * a + 1] / (EPSILON * sizes[2 * a]), worst)
    return worst


@helper
def make_frame(
    density: Any,
    manifold: Any,
    params: Any,
    layout: Any,
    t: float,
    y: Any,
    kept: Memory,
    frame: Any,
    lanes: Lanes,
    own: Work,
    first: bool,
) -> None:
    """Write the reflections that split normals and tangents at y, and ``log μ − ½ log det(CCᵀ)``.

    Up to the scales of the conditions, which the first frame of a run decides. The spacing of the
    differences of c is the largest at which they have no error but rounding: for polynomials of
    degree up to 6 the first.
    """
    scales, condition_scales = kept.scales, kept.condition_scales
    n, m = len(scales), len(condition_scales)
    volume = 0.0
    if m > 0:
        sizes, C = own.values, own.gradients
        numbers = as_lanes(layout, 0, 3)
        spacing = kept.condition_spacing[0]
        worst = 2.0 * CONDITIONS_ROUNDINGS
        while worst > CONDITIONS_ROUNDINGS and spacing > CONDITIONS_SMALLEST:
            worst = condition_gradients(
                manifold, params, numbers, t, y, scales, spacing, lanes, own
            )
            if worst > CONDITIONS_ROUNDINGS:
                spacing = 0.5 * spacing
        kept.condition_spacing[0] = spacing
        for a in range(m):
            while first and condition_scales[a] < sizes[2 * a] < 1e300:
                condition_scales[a] = 2.0 * condition_scales[a]
            for i in range(n):
                C[a * n + i] = C[a * n + i] / condition_scales[a]
        volume -= reflections(n, m, C, part(frame, 1, m * n))
    frame[0] = volume + density(params, t, part(y, 0, n), own.scratch)


@helper
def normals_turned(n: int, m: int, old: Any, new: Any, x: Any, Z: Any, G: Any) -> float:
    """Return ``log|det(N₁ᵀ N₀)|`` of the normals of two frames, as ``½ log det(1 − ZᵀZ)``."""
    d = n - m
    for a in range(m):
        for i in range(n):
            x[i] = 1.0 if i == a else 0.0
        reflect_back(m, old, x)
        reflect(m, new, x)
        for i in range(d):
            Z[a * d + i] = x[m + i]
    for a in range(m):
        for b in range(m):
            product = 0.0
            for i in range(d):
                product += Z[a * d + i] * Z[b * d + i]
            G[a * m + b] = -product
    return 0.5 * log_det_near_identity(m, G)
