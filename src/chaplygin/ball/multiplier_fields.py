"""The rolling ball with multipliers, whatever decides its acceleration: functions of (g, r, ω, v).

See `rolling` for the equations; a `RollingDynamics` has the acceleration.
"""

import functools
from typing import Any

import geomint as gi
from geomint import part, section, sqrt

from ..integrable import inner
from .angular_velocity import apply_to_gamma
from .fields import opposite, turn_vectors
from .rolling_dynamics import RollingDynamics, rolled


def rolling_space(n: int) -> gi.Space:
    """Return SO(n) × R^(n−1) with velocities: (g, r, ω, v)."""
    motions = gi.Rotations(n) * gi.Euclidean(n - 1, "r")
    return motions * gi.Euclidean(n * (n - 1) // 2, "omega") * gi.Euclidean(n - 1, "v")


@functools.cache
def multiplier_fields(dynamics: RollingDynamics, n: int, rows: Any) -> dict[str, Any]:
    """Return field, generator, energy, slip and where things lie; y = (g, r, ω, v)."""
    size, square = n * (n - 1) // 2, n * n
    slices = rolling_space(n).slices
    turning, moving = slices["omega"].start, slices["v"].start
    accelerate, apply_inertia = dynamics

    def locate(params, y, work):
        """Return blocks (γ, g, ω, r, scratch)."""
        gamma, g = part(y, square - n, n), part(y, 0, square)
        return gamma, g, part(y, turning, size), part(y, square, n - 1), work

    def translate(params, y, out, work):
        """Write (ṙ, ω̇, v̇)."""
        gamma, g, w = part(y, square - n, n), part(y, 0, square), part(y, turning, size)
        for i in range(n - 1):
            out[i] = y[moving + i]
        dw = part(out, n - 1, size)
        accelerate(params, gamma, w, dw, work)
        rolled(
            n, section(params, rows, "rho")[0], g, gamma, dw, part(out, n - 1 + size, n - 1), work
        )

    translation = gi.helper(translate)

    def rolling_field(params, t, y, out, work):
        """Eqs. (c1)–(c4) in the body frame."""
        w = part(y, turning, size)
        turn_vectors(n, w, part(y, 0, square), part(out, 0, square), work)
        translation(params, y, part(out, square, len(out) - square), work)

    def rolling_generator(params, t, y, out, work):
        """ξ = (−ω, ṙ, ω̇, v̇)."""
        opposite(size, part(y, turning, size), out)
        translation(params, y, part(out, size, len(out) - size), work)

    def rolling_energy(params, t, y, work):
        """½⟨Iω, ω⟩ + ½m(v, v), eq. (ch-lagr); ½⟨k, ω⟩ where the ball does not slip."""
        w, momentum = part(y, turning, size), part(work, 0, size)
        apply_inertia(section(params, rows, "inertia"), w, momentum)
        mass = section(params, rows, "m")
        total = inner(size, momentum, w)
        for i in range(moving, moving + n - 1):
            total += mass[0] * y[i] * y[i]
        return 0.5 * total

    def rolling_slip(params, t, y, work):
        """|v − ρ gωγ|, eq. (ch-constr): the speed of the point of the ball in contact."""
        g, w = part(y, 0, square), part(y, turning, size)
        v, rest = part(work, 0, n - 1), part(work, n, n)
        rolled(n, section(params, rows, "rho")[0], g, part(y, square - n, n), w, v, rest)
        total = 0.0 * y[0]
        for i in range(n - 1):
            entry = y[moving + i] - v[i]
            total += entry * entry
        return sqrt(total)

    return {
        "field": gi.field(rolling_field),
        "generator": gi.field(rolling_generator),
        "locate": gi.helper(locate),
        "energy": gi.observable(rolling_energy),
        "rolling": gi.observable(rolling_slip),
    }


@functools.cache
def rolling_conditions(n: int, rows: Any, twist_free: bool) -> Any:
    """Return the function that writes g gᵀ − 1, v − ρ gωγ and, if `twist_free`, (gωgᵀ)_pq, p < q < n.

    `rows` is the layout of the parameters; y = (g, r, ω, v).
    """
    size, square = n * (n - 1) // 2, n * n
    rotation, slipping = gi.Rotations(n).manifold_at(0), gi.Rotations(n).conditions
    slices = rolling_space(n).slices
    turning, moving = slices["omega"].start, slices["v"].start

    def conditions(params, t, y, out, work):
        rotation(params, t, y, out, work)
        g, w = part(y, 0, square), part(y, turning, size)
        v = part(out, slipping, n - 1)
        rolled(n, section(params, rows, "rho")[0], g, part(y, square - n, n), w, v, work)
        for i in range(n - 1):
            v[i] = y[moving + i] - v[i]
        if twist_free:
            entry, image = slipping + n - 1, part(work, 0, n)
            for q in range(1, n - 1):
                apply_to_gamma(n, w, part(y, q * n, n), image)
                for p in range(q):
                    out[entry] = inner(n, part(y, p * n, n), image)
                    entry += 1

    return gi.field(conditions)
