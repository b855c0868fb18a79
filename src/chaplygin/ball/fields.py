"""Field, generator, energy and density of the ball in (k, γ) or (k, γ, g), for any kind of inertia.

See `momentum` for the equations; ω is one of the functions of `angular_velocity`. The functions are
made for each n, because loops of constant length unroll: 1.5 to 3 times faster than with n from
the parameters (n = 8 to 3).

What every ball keeps is here as functions of (k, γ, g), wherever these stand in the state. All of k
is constant in space. So K = ⟨k, k⟩ and tr k⁴ are constant, and the length of the part of k that
fixes γ, the SO(n−1)-momentum; for n = 2 that is nothing, for n = 3 one number.
"""

import functools
from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np

import geomint as gi
from geomint import part, section, sqrt
from geomint.problems.spaces.skew import unpack_skew
from geomint.problems.spaces.sphere import product

from ..inertia import Inertia
from ..integrable import inner
from ..manifold import Array, Named, skew_components, triangle_rows
from ..operators import after, operator_entries
from .angular_velocity import (
    about_vertical,
    apply_to_gamma,
    log_density_after,
    omega_for,
    omega_work,
)

Ball = namedtuple("Ball", "omega rho m inertia k0")


class BallForms(NamedTuple):
    """What depends on the angular velocity."""

    field: Any
    generator: Any
    energy: Any
    log_density: Any


def ball_parameters(
    inertia: Inertia, D: float, k0: Any = None, m: Any = (), rho: Any = ()
) -> tuple[Any, Ball, Array]:
    """Return the function that writes ω, the layout of a ball's parameters, and these.

    They are those of ω; where m and ρ are given, ρ, m and I, as n(n−1)/2 diagonal entries or as a
    matrix row after row; where k_0 is given, its flat triangle.
    """
    omega, own = omega_for(inertia, D)
    parts = {"omega": own, "rho": rho, "m": m, "inertia": (), "k0": ()}
    if np.size(rho):
        _, parts["inertia"] = operator_entries(inertia)
    if k0 is not None:
        parts["k0"] = skew_components("k0", k0, inertia.n)
    rows = Ball(**{name: np.size(numbers) for name, numbers in parts.items()})
    return omega, rows, gi.packed(rows, **parts).data


def ball_work(omega: Any, n: int) -> int:
    """Rows of scratch that the functions of this module need."""
    return triangle_rows(n) + max(2 * n * n, omega_work(omega, n))


@gi.helper
def turn(n, omega, y, out, work):
    """Write ([k, ω], −ωγ, gω) for the flat triangle of ω."""
    size = n * (n - 1) // 2
    w, k = part(work, 0, n * n), part(work, n * n, n * n)
    unpack_skew(n, omega, w)
    unpack_skew(n, part(y, 0, size), k)
    at = 0
    for i in range(n):
        for j in range(i + 1, n):
            total = w[i * n] * k[j * n] - k[i * n] * w[j * n]
            for c in range(1, n):
                total += w[i * n + c] * k[j * n + c] - k[i * n + c] * w[j * n + c]
            out[at] = total
            at += 1
    for row in range(size, len(y), n):  # γ and the rows of g are vectors that turn alike
        for i in range(n):
            total = -(w[i * n] * y[row])
            for j in range(1, n):
                total -= w[i * n + j] * y[row + j]
            out[row + i] = total


@gi.helper
def turn_vectors(n, omega, y, out, work):
    """Write −ωv for every vector v of the state, for the flat triangle of ω."""
    for row in range(0, len(y), n):
        apply_to_gamma(n, omega, part(y, row, n), part(out, row, n))
        opposite(n, part(out, row, n), part(out, row, n))


@gi.helper
def opposite(rows, x, out):
    """Write −x, of as many rows."""
    for i in range(rows):
        out[i] = -x[i]


def turning_forms(n: int, turning: Any, velocity: Any, density: Any) -> BallForms:
    """Return the functions of a state whose vectors, and a k before them, turn with −ω.

    Parameters
    ----------
    n : int
    turning : recorded ``f(n, omega, y, out, work)``
        `turn` or `turn_vectors`.
    velocity : recorded ``f(params, y, work) -> (k, omega, rest)``
        Returns the flat triangles of momentum and angular velocity, and what is left of the scratch.
    density : recorded ``f(params, y, rest)``
        Returns log ϱ, from what `velocity` has left in the scratch.
    """
    size = triangle_rows(n)

    def turning_field(params, t, y, out, work):
        """v̇ = −ωv, and k̇ = [k, ω]."""
        _, w, rest = velocity(params, y, work)
        turning(n, w, y, out, rest)

    def turning_generator(params, t, y, out, work):
        """ξ = −ω."""
        _, w, _ = velocity(params, y, work)
        opposite(size, w, out)

    def turning_energy(params, t, y, work):
        """½⟨k, ω⟩, the kinetic energy."""
        k, w, _ = velocity(params, y, work)
        return 0.5 * inner(size, k, w)

    def turning_log_density(params, t, y, work):
        """Return log ϱ."""
        _, _, rest = velocity(params, y, work)
        return density(params, y, rest)

    return BallForms(
        gi.field(turning_field),
        gi.field(turning_generator),
        gi.observable(turning_energy),
        gi.observable(turning_log_density),
    )


@functools.cache
def ball_forms(omega: Any, n: int, rows: Ball, vertical: int) -> BallForms:
    """Return the functions of the ball in R^n whose ω is given by `omega`; see `ball_parameters`.

    The state begins with k; γ stands in the rows from `vertical` on. Eqs. (ch-red), (PE), (ch-red2),
    and (mu*).
    """
    size = triangle_rows(n)
    log_density = log_density_after(omega)

    def ball_velocity(params, y, work):
        k, w, rest = part(y, 0, size), part(work, 0, size), after(work, size)
        omega(n, section(params, rows, "omega"), k, part(y, vertical, n), w, rest)
        return k, w, rest

    def ball_density(params, y, rest):
        return log_density(n, section(params, rows, "omega"), part(y, vertical, n), rest)

    return turning_forms(n, turn, gi.helper(ball_velocity), gi.helper(ball_density))


class BallIntegrals(NamedTuple):
    """Integrals by name, and the momentum in space."""

    invariants: Named
    spatial_momentum: Any


@functools.cache
def ball_integrals(n: int, rows: Any, vertical: int, frame: int) -> BallIntegrals:
    """Return the functions of states with k first, γ from row `vertical` and g from row `frame` on.

    `rows` is the layout of the parameters, of which the spatial momentum reads k_0.
    """
    size = triangle_rows(n)

    def ball_trace_k4(params, t, y, work):
        """Tr k⁴ = |k²|², an invariant of the spectrum of k; tr k² is −2K."""
        k = part(work, 0, n * n)
        unpack_skew(n, part(y, 0, size), k)
        total = 0.0 * y[0]
        for i in range(n):
            for j in range(n):
                entry = inner(n, part(k, i * n, n), part(k, j * n, n))
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
