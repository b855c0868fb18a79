"""SO(3) acting on 3-vectors: the algebra is R³ with the cross product.

The hat map is ``x̂ v = x × v``; exp(x̂) turns by |x| about x. Layout: ``[number of vectors]``.
"""

from __future__ import annotations

from typing import Any

from .arithmetic import select, sin, sqrt
from .recorded import helper

__all__ = ["so3_act", "so3_bracket"]

# Below this |x|² the series are exact to rounding (next terms x⁸/8!·90 and less).
SMALL = 1e-3


@helper
def rotation_coefficients(s: Any) -> Any:
    """Return ``sin θ/θ`` and ``(1 − cos θ)/θ²`` for θ² = s, for small angles by series.

    The second is ½ (sin(θ/2)/(θ/2))²: no cancellation at any angle.
    """
    theta = sqrt(select(s < SMALL, 1.0 + 0.0 * s, s))
    half = 0.5 * theta
    ratio = sin(half) / half
    a_large = sin(theta) / theta
    b_large = 0.5 * ratio * ratio
    a_small = 1.0 - s * (1.0 - s * (1.0 - s * (1.0 - s / 72.0) / 42.0) / 20.0) / 6.0
    b_small = 0.5 * (1.0 - s * (1.0 - s * (1.0 - s * (1.0 - s / 90.0) / 56.0) / 30.0) / 12.0)
    return select(s < SMALL, a_small, a_large), select(s < SMALL, b_small, b_large)


@helper
def so3_act(layout: Any, xi: Any, y: Any, out: Any, work: Any) -> None:
    """Write ``(exp(ξ̂) − 1) v = a ξ×v + b ξ×(ξ×v)`` for each vector v of the state."""
    x0, x1, x2 = xi[0], xi[1], xi[2]
    a, b = rotation_coefficients(x0 * x0 + x1 * x1 + x2 * x2)
    for i in range(0, len(y), 3):
        v0, v1, v2 = y[i], y[i + 1], y[i + 2]
        c0 = x1 * v2 - x2 * v1
        c1 = x2 * v0 - x0 * v2
        c2 = x0 * v1 - x1 * v0
        out[i] = a * c0 + b * (x1 * c2 - x2 * c1)
        out[i + 1] = a * c1 + b * (x2 * c0 - x0 * c2)
        out[i + 2] = a * c2 + b * (x0 * c1 - x1 * c0)


@helper
def so3_bracket(layout: Any, x: Any, y: Any, out: Any, work: Any) -> None:
    """Write x × y."""
    x0, x1, x2, y0, y1, y2 = x[0], x[1], x[2], y[0], y[1], y[2]
    out[0] = x1 * y2 - x2 * y1
    out[1] = x2 * y0 - x0 * y2
    out[2] = x0 * y1 - x1 * y0
