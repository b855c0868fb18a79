"""What every ball keeps, as functions of (k, γ, g), wherever these stand in the state.

All of k is constant in space. So K = ⟨k, k⟩ and tr k⁴ are constant, and the length of the part of k
that fixes γ, the SO(n−1)-momentum; for n = 2 that is nothing, for n = 3 one number.
"""

import functools
from typing import Any, NamedTuple

import geomint as gi
from geomint import part, section, sqrt
from geomint.problems.spaces.skew import unpack_skew
from geomint.problems.spaces.sphere import product

from .angular_velocity import about_vertical


class BallIntegrals(NamedTuple):
    """Integrals by name, and the momentum in space."""

    invariants: dict[str, Any]
    spatial_momentum: Any


@functools.cache
def ball_integrals(n: int, rows: Any, vertical: int, frame: int) -> BallIntegrals:
    """Return the functions of states with k first, γ from row `vertical` and g from row `frame` on.

    `rows` is the layout of the parameters, of which the spatial momentum reads k_0.
    """
    size = n * (n - 1) // 2

    def ball_trace_k4(params, t, y, work):
        """Tr k⁴ = |k²|², an invariant of the spectrum of k; tr k² is −2K."""
        k = part(work, 0, n * n)
        unpack_skew(n, part(y, 0, size), k)
        total = 0.0 * y[0]
        for i in range(n):
            for j in range(n):
                entry = k[i * n] * k[j * n]
                for c in range(1, n):
                    entry += k[i * n + c] * k[j * n + c]
                total += entry * entry
        return total

    def ball_momentum(params, t, y, work):
        """|pr_so(n−1) Ad_g k|² = |k − (kγ)∧γ|², constant by eq. (cl); (k⃗, γ⃗)² at n = 3."""
        return about_vertical(n, part(y, 0, size), part(y, vertical, n), work)

    def ball_spatial_momentum(params, t, y, work):
        """|Ad_g k − k_0| in the norm of ⟨X, X⟩."""
        k, gk = part(work, 0, n * n), part(work, n * n, n * n)
        g = part(y, frame, n * n)
        unpack_skew(n, part(y, 0, size), k)
        for i in range(n):
            for j in range(n):
                entry = g[i * n] * k[j]
                for c in range(1, n):
                    entry += g[i * n + c] * k[c * n + j]
                gk[i * n + j] = entry
        total, at, k0 = 0.0 * y[0], 0, section(params, rows, "k0")
        for i in range(n):
            for j in range(i + 1, n):
                entry = 0.0 * y[0] - k0[at]
                for c in range(n):
                    entry += gk[i * n + c] * g[j * n + c]
                total += entry * entry
                at += 1
        return sqrt(total)

    invariants = {"K": product(size, 0, 0)}  # ⟨k, k⟩, eq. (IK)
    if n > 2:
        invariants["momentum"] = gi.observable(ball_momentum)
    if n > 3:
        invariants["trace-k4"] = gi.observable(ball_trace_k4)
    return BallIntegrals(invariants, gi.observable(ball_spatial_momentum))
