"""Field, generator, energy and density of the ball in (k, γ) or (k, γ, g), for any kind of inertia.

See `momentum` for the equations; ω is one of the functions of `angular_velocity`. The functions are
made for each n, because loops of constant length unroll: 1.5 to 3 times faster than with n from
the parameters (n = 8 to 3).
"""

from __future__ import annotations

import functools
from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np

import geomint as gi
from geomint import part, section
from geomint.problems.spaces.skew import unpack_skew

from ..inertia import GeneralInertia, SpecialInertia
from ..integrable import inner
from ..manifold import Array, skew_components
from ..operators import operator_entries
from .angular_velocity import log_density_after, omega_for, omega_work

__all__ = ["BallForms", "ball_forms", "ball_parameters", "ball_work", "turn"]

Ball = namedtuple("Ball", "omega rho m inertia k0")


class BallForms(NamedTuple):
    """What depends on ω."""

    field: Any
    generator: Any
    energy: Any
    log_density: Any


def ball_parameters(
    inertia: SpecialInertia | GeneralInertia, D: float, k0: Any = None, m: Any = (), rho: Any = ()
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
    return n * (n - 1) // 2 + max(2 * n * n, omega_work(omega, n))


@gi.helper
def turn(n: int, omega: Any, y: Any, out: Any, work: Any) -> None:
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


@functools.cache
def ball_forms(omega: Any, n: int, rows: Ball, vertical: int) -> BallForms:
    """Return the functions of the ball in R^n whose ω is given by `omega`; see `ball_parameters`.

    The state begins with k; γ stands in the rows from `vertical` on.
    """
    size = n * (n - 1) // 2
    log_density = log_density_after(omega)

    def ball_field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        """Eqs. (ch-red), (PE), (ch-red2)."""
        w, rest = part(work, 0, size), part(work, size, len(work) - size)
        omega(n, section(params, rows, "omega"), part(y, 0, size), part(y, vertical, n), w, rest)
        turn(n, w, y, out, rest)

    def ball_generator(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        """ξ = −ω."""
        omega(n, section(params, rows, "omega"), part(y, 0, size), part(y, vertical, n), out, work)
        for i in range(size):
            out[i] = -out[i]

    def ball_energy(params: Any, t: Any, y: Any, work: Any) -> Any:
        """½⟨k, ω⟩, the reduced kinetic energy."""
        w, rest = part(work, 0, size), part(work, size, len(work) - size)
        omega(n, section(params, rows, "omega"), part(y, 0, size), part(y, vertical, n), w, rest)
        return 0.5 * inner(size, y, w)

    def ball_log_density(params: Any, t: Any, y: Any, work: Any) -> Any:
        """Return log ϱ, eq. (mu*)."""
        gamma, rest = part(y, vertical, n), part(work, size, len(work) - size)
        own = section(params, rows, "omega")
        omega(n, own, part(y, 0, size), gamma, part(work, 0, size), rest)
        return log_density(n, own, gamma, rest)

    return BallForms(
        gi.field(ball_field),
        gi.field(ball_generator),
        gi.observable(ball_energy),
        gi.observable(ball_log_density),
    )
